"""What is compared: recordings of one instrument, or the sensors of one array, each in its own words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from diagnosis.result import Reach


@dataclass(frozen=True)
class Among:
    """Words for one of those that are compared, and for how far an effect reaches among them.

    key: the word of the JSON; reach: of pages and tables; after: what the gap afterwards rests on; alone: of an effect
    that one alone names.
    """

    one: str
    key: str
    reach: Mapping[Reach, str]
    after: str
    alone: str


RECORDINGS = Among(
    one="recording",
    key="recordings",
    reach={
        Reach.TRANSFERRED: "transferred",
        Reach.NOT_TRANSFERRED: "not transferred",
        Reach.SOME: "in some",
        Reach.SINGLE_RUN: "not borne out",
    },
    after="with the coefficients that the other recordings give, with its own where these differ",
    alone="No finding of the lot: the other recordings do not bear it out.",
)
SENSORS = Among(
    one="sensor",
    key="sensors",
    reach={
        Reach.TRANSFERRED: "the same",
        Reach.NOT_TRANSFERRED: "differs",
        Reach.SOME: "at some",
        Reach.SINGLE_RUN: "at one",
    },
    after="with what its own diagnosis names",
    alone="The others do not show it, or cannot tell.",
)
