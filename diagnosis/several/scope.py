"""Wording for the scope of a comparison: recordings of one instrument, or sensors of one array."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from diagnosis.result import Transfer


@dataclass(frozen=True)
class Scope:
    """Words for the compared units and for the transfer of effects between them.

    key: JSON key. labels: of transfer, for pages and tables. after: basis of the gap afterwards. alone: remark on an
    effect named by a single unit.
    """

    noun: str
    key: str
    labels: Mapping[Transfer, str]
    after: str
    alone: str


RECORDINGS = Scope(
    noun="recording",
    key="recordings",
    labels={
        Transfer.TRANSFERRED: "transferred",
        Transfer.NOT_TRANSFERRED: "not transferred",
        Transfer.SOME: "in some",
        Transfer.SINGLE_RUN: "not confirmed",
    },
    after="with the coefficients of the other recordings, or its own where these differ",
    alone="Not a common finding: the other recordings do not confirm it.",
)
SENSORS = Scope(
    noun="sensor",
    key="sensors",
    labels={
        Transfer.TRANSFERRED: "the same",
        Transfer.NOT_TRANSFERRED: "differs",
        Transfer.SOME: "at some",
        Transfer.SINGLE_RUN: "at one",
    },
    after="with the effects of its own diagnosis",
    alone="The other sensors do not show it, or cannot decide.",
)
