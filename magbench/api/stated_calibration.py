"""A calibration in place of a model: the iron that a diagnosis fits, compared with the iron that is stated."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from magbench.api.recheck_result import RecheckResult

MODELS = (".toml",)
"""Endings of scenario and model files."""


def is_calibration(model: str | PathLike[str] | None) -> bool:
    """Whether a model is a file of another kind than scenarios: a calibration, which names the iron alone."""
    return model is not None and Path(model).is_file() and Path(model).suffix not in MODELS


def changed_iron(found: RecheckResult) -> dict[str, Any]:
    """The stated iron against the log's: verdict, and each changed effect by name, with 95 % intervals."""
    from sim.effects.iron import HardIron, SoftIron
    from validation.rechecking.parts import JOINT, OFFSET, SOFT_IRON

    told = found.summary()
    names = {OFFSET: HardIron.name, SOFT_IRON: SoftIron.name, JOINT: f"{HardIron.name} or {SoftIron.name}"}
    causes = [{"effect": names.get(one["what"], one["what"])} | one for one in told["changes"]]
    return {"verdict": told["verdict"], "sentence": told["sentence"], "changed": causes}
