"""The public answer to a log: its status, its error against the claim, and whether the reason names the disturbance."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import magbench
from benchmarks.honesty.logs import Log

CHI_SQUARE_95 = 7.815
"""The 95 % quantile of chi squared with three degrees of freedom."""
UNCLAIMED = 0.01
"""Error over F that counts as beyond the claim of a calibration without covariance."""
METHODS = ("sphere", "ellipsoid")
JUDGED = "ellipsoid"
NAMES = {
    "stuck axis": r"stuck|froze",
    "sentinel": r"sentinel|99,?999|missing|stand for",
    "saturation": r"satur|full scale|cut off",
    "wrap": r"wrap|overflow",
    "mirrored axes": r"left-handed|mirror|handed",
    "wrong unit": r"\bunit\b|in uT|in µT|in mG|in gauss|in G\b",
    "wild values": r"wild|outlier|spike",
    "uneven room": r"room|uneven|place|field (itself )?(changes|varies)|not uniform",
    "characteristic": r"characteristic|nonlinear|cubic",
    "half a sphere": r"roll|pitch|yaw|cover|plane|further|attitudes|motion",
    "clock": r"clock|time|stamp",
    "held rows": r"held|slower|repeat",
    "short flicker": r"flicker|slow|drift|colour|1/f|wander",
}
"""What a reason must say of each disturbance, as a regular expression."""
HARMLESS = ("uneven room", "characteristic", "half a sphere", "short flicker")
"""Disturbances of the field or the motion that need no word where the answer is ok and within its claim."""


@dataclass(frozen=True)
class Verdict:
    """The answer to one log. squared : error in units of the claimed covariance, d^T C^-1 d."""

    disturbance: str
    status: str
    error: float
    squared: float
    named: bool
    agree: bool
    told: str

    @property
    def ok(self) -> bool:
        """Return whether the calibration claims to be good."""
        return self.status == "ok"

    @property
    def explained(self) -> bool:
        """Return whether the reason names the disturbance, or a harmless one left the answer right."""
        return self.named or (self.disturbance in HARMLESS and self.ok and not self.wrong)

    @property
    def wrong(self) -> bool:
        """Return whether the calibration claims to be good and its error is beyond the claimed 95 %."""
        return self.ok and self.squared > CHI_SQUARE_95


def verdict(log: Log, place: Path) -> Verdict:
    """Write a log to a file, and judge what `magbench.calibrate` and `magbench.inspect` say of it."""
    path = place / "log.csv"
    path.write_text(log.text(), encoding="utf-8")
    found = {one.name: one.value for one in magbench.inspect(path).findings}
    try:
        fits = magbench.calibrate(path, log.strength_nT, with_=list(METHODS))
    except magbench.InputError as refusal:
        told = str(refusal)
        return Verdict(log.disturbance, "refused", np.nan, np.nan, _named(log, told), not found["accepted"], told)
    fit = fits[JUDGED]
    told = " | ".join([fit.status.reason, *fit.recording.origin.notes])
    agree = all(found[f"enough_for_{name}"]["status"] == fits[name].status.kind for name in METHODS)
    error = fit.offset_nT - log.offset_nT
    size = float(np.linalg.norm(error))
    covariance = fit.offset_covariance_nT2
    if covariance is None:
        squared = np.inf if size > UNCLAIMED * log.strength_nT else 0.0
    else:
        squared = float(error @ np.linalg.solve(covariance, error))
    return Verdict(log.disturbance, fit.status.kind, size, squared, _named(log, told), agree, told)


def _named(log: Log, told: str) -> bool:
    pattern = NAMES.get(log.disturbance)
    return pattern is None or re.search(pattern, told, re.IGNORECASE) is not None
