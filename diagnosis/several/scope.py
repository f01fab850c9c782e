"""What is compared: recordings of one instrument, or the sensors of one array, each in its own words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from diagnosis.result import Transfer


@dataclass(frozen=True)
class Scope:
    """Words for one of those that are compared, and for how far an effect reaches among them.

    key: the word of the JSON; reach: of pages and tables; after: what the gap afterwards rests on; alone: of an effect
    that one alone names.
    """

    one: str
    key: str
    reach: Mapping[Transfer, str]
    after: str
    alone: str


RECORDINGS = Scope(
    one="recording",
    key="recordings",
    reach={
        Transfer.TRANSFERRED: "transferred",
        Transfer.NOT_TRANSFERRED: "not transferred",
        Transfer.SOME: "in some",
        Transfer.SINGLE_RUN: "not borne out",
    },
    after="with the coefficients that the other recordings give, with its own where these differ",
    alone="No finding of the lot: the other recordings do not bear it out.",
)
SENSORS = Scope(
    one="sensor",
    key="sensors",
    reach={
        Transfer.TRANSFERRED: "the same",
        Transfer.NOT_TRANSFERRED: "differs",
        Transfer.SOME: "at some",
        Transfer.SINGLE_RUN: "at one",
    },
    after="with what its own diagnosis names",
    alone="The others do not show it, or cannot tell.",
)
