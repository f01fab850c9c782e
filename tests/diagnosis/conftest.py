"""One flight of the quadrotor, with any effects in its magnetometer."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from recordings import Recording
from recordings.assemble import recording_of
from sim import effects as effect_table
from sim.chain import Chain
from sim.scenario import ModelSpec, load
from sim.simulation import PreparedRun, blocks, plan
from sim.state import State

BASE: dict[str, Any] = {
    "soft_iron": {"matrix": [[0.05, 0.01, -0.02], [0.01, -0.03, 0.015], [0.0, 0.01, 0.02]]},
    "hard_iron": {"offset_nT": [500.0, -300.0, 800.0]},
    "white_noise": {"std_nT": [2.0, 2.0, 2.0]},
}
SHORTER = {
    "quad-calibration": "phases.1.duration_s=100",
    "auv-spiral": "phases.0.duration_s=900",
    "auv-spiral-excited": "phases.0.duration_s=900",
}
"""Half of a scenario's motion, two circles and a half of an AUV, decides as the whole does."""
Flight = Callable[..., Recording]


def _shorter(scenario: str) -> list[str]:
    return [SHORTER[scenario]] if scenario in SHORTER else []


@cache
def _flown(scenario: str, whole: bool = False) -> tuple[Recording, State, PreparedRun]:
    quiet = [
        "navigation.attitude_noise_std_deg=0",
        "navigation.position_noise_std_m=0",
        *([] if whole else _shorter(scenario)),
    ]
    made = plan(load(scenario, quiet).model_copy(update={"effects": {}, "effect_order": None, "vary": {}}), 0, 1)
    columns: dict[str, list[Any]] = {}
    for block in blocks(made):
        for key, values in block.items():
            if not key.startswith(("true_", "effect")):
                columns.setdefault(key, []).append(values)
    recording = recording_of({key: np.concatenate(parts) for key, parts in columns.items()})
    return recording, pose(recording, Known(made.field_enu_nT, 5e4)).state, made


@pytest.fixture
def own() -> Callable[..., Recording]:
    """Make a scenario's own recording, with its effects and the errors of its navigation, for a seed."""

    def make(scenario: str, seed: int, *changes: str) -> Recording:
        columns: dict[str, list[Any]] = {}
        for block in blocks(plan(load(scenario, [*_shorter(scenario), *changes]), 0, seed)):
            for key, values in block.items():
                if not key.startswith(("true_", "effect")):
                    columns.setdefault(key, []).append(values)
        return recording_of({key: np.concatenate(parts) for key, parts in columns.items()})

    return make


@pytest.fixture
def flight() -> Flight:
    """Make a recording with effects (tables) beside the base, for a scenario and a seed."""

    return _flight


def _flight(
    hidden: dict[str, Any], scenario: str = "quad-calibration", seed: int = 5, *, whole: bool = False
) -> Recording:
    recording, state, _ = _flown(scenario, whole)
    effects = effect_table.build({**BASE, **hidden}, None, "test")
    return replace(recording, mag_nT=Chain(effects, seed).apply(state)[0])


@pytest.fixture
def model() -> Callable[..., ModelSpec]:
    """The base as a model, for a scenario's field."""

    return _model


def _model(scenario: str = "quad-calibration") -> ModelSpec:
    field = _flown(scenario)[2].field_enu_nT.tolist()
    return ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field}})


@cache
def _diagnosed(hidden: str, scenario: str, seed: int, without: frozenset[str]) -> Diagnosis:
    return diagnose(_flight(json.loads(hidden), scenario, seed), _model(scenario), without=without)


@pytest.fixture(scope="session")
def diagnosed() -> Callable[..., Diagnosis]:
    """The diagnosis of a flight with effects beside the base by the base as a model, made once for all tests."""

    def of(
        hidden: dict[str, Any],
        scenario: str = "quad-calibration",
        seed: int = 5,
        without: frozenset[str] = frozenset(),
    ) -> Diagnosis:
        return _diagnosed(json.dumps(hidden), scenario, seed, without)

    return of
