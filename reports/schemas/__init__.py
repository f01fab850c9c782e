"""JSON Schemas of what the commands print and write: a class a table, its keys with their meaning."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from reports.schemas import bound, calibration, comparison, dataset, diagnosis, listing, run
from scenarios.spec import DIALECT

MODELS: dict[str, type[BaseModel]] = {
    "apply": calibration.ApplyJson,
    "bound": bound.BoundJson,
    "bound-what-if": bound.WhatIfJson,
    "calibrate": calibration.CalibrateJson,
    "calibrations": calibration.CalibrationsJson,
    "calibrations-in-unit": calibration.InUnitJson,
    "compare": comparison.CompareJson,
    "dataset": dataset.DatasetJson,
    "diagnose": diagnosis.DiagnoseJson,
    "diagnose-several": diagnosis.DiagnoseSeveralJson,
    "gate": comparison.GateJson,
    "gate-baseline": comparison.GateBaselineJson,
    "gate-proposal": comparison.GateProposalJson,
    "inspect": listing.InspectJson,
    "list": listing.ListJson,
    "plan": bound.PlanJson,
    "plan-after": bound.PlanAfterJson,
    "read": listing.ReadJson,
    "recheck": calibration.RecheckJson,
    "reproduce": listing.ReproduceJson,
    "run": run.RunJson,
    "show": listing.ShowJson,
    "simulate": dataset.SimulateJson,
}
"""The result of each kind, by its name in `magbench schema KIND`."""


def json_schema(kind: str) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a kind of result; raises KeyError for a kind that is not in MODELS."""
    return {"$schema": DIALECT, **MODELS[kind].model_json_schema(by_alias=True)}
