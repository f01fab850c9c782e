"""Hyperparameters: what is not allowed is refused when a calibrator is made, and what is allowed can be fitted with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pytest

from calib import CALIBRATORS, Calibrator, get
from calib.families.vector_filter import KalmanSettings
from calib.methods.ellipsoid_segmented import EllipsoidSegmented
from calib.methods.ml_newton import MaximumLikelihoodNewton
from calib.methods.tolles_lawson import TollesLawsonCalibrator
from calib.methods.twostep import TwoStep
from scenarios.errors import InputError
from tests.calib.test_contract import with_all

ALL = pytest.mark.parametrize("name", list(CALIBRATORS))
QUICK = {"iterations": 3, "polish": False}


def numeric(settings: Any) -> dict[str, Any]:
    """The fields that hold a number or numbers."""
    held = {item.name: getattr(settings, item.name) for item in fields(settings)}
    return {k: v for k, v in held.items() if isinstance(v, int | float | tuple) and not isinstance(v, bool)}


def with_value(method: Calibrator, bad: float) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """Each numeric field of a method, or of a table in it: its name, what holds it, and the change to make there."""
    tables = [getattr(method, item.name) for item in fields(method) if is_dataclass(getattr(method, item.name))]
    for holder in (method, *tables):
        for field, value in numeric(holder).items():
            yield field, holder, {field: (bad,) * len(value) if isinstance(value, tuple) else bad}


def quick(method: Calibrator) -> Calibrator:
    """The same with few iterations."""
    return replace(method, **{key: value for key, value in QUICK.items() if hasattr(method, key)})


@ALL
@pytest.mark.parametrize("bad", [0, -1, np.nan])
def test_a_value_is_refused_by_name_or_can_be_fitted_with(name, bad, standard):
    method = quick(get(name))
    recording = with_all(standard.recording("full", 0, n=200), name, standard)
    for field, holder, change in with_value(method, bad):
        try:
            changed = replace(holder, **change)
        except InputError as error:
            assert f".{field}" in str(error)  # noqa: PT017, either outcome is right
            assert f"found {bad}" in str(error)  # noqa: PT017
            continue
        assert np.isfinite(bad), field
        if holder is not method:
            key = next(item.name for item in fields(method) if getattr(method, item.name) is holder)
            changed = replace(method, **{key: changed})
        result = changed.fit(recording, standard.REFERENCE)
        assert result.status.kind == "ok" or result.status.reason
        assert np.isfinite(result.offset_nT).all()


@pytest.mark.parametrize("name", [name for name in CALIBRATORS if hasattr(get(name), "population")])
def test_the_smallest_population_allowed_can_move(name, standard):
    method = quick(get(name))
    recording = with_all(standard.recording("full", 0, n=100), name, standard)
    if CALIBRATORS[name].one_axis:
        recording = standard.level_turns(100, 0)
    refused = []
    for size in range(1, 8):
        try:
            small = replace(method, population=size)
        except InputError:
            refused.append(size)
            continue
        small.fit(recording, standard.REFERENCE)
    assert refused == list(range(1, len(refused) + 1))
    assert 1 <= len(refused) <= 4


@pytest.mark.parametrize(
    ("make", "where", "what"),
    [
        (lambda: TwoStep(rounds=0), "twostep.rounds", "greater than or equal to 1; found 0"),
        (lambda: TwoStep(rounds=2.5), "twostep.rounds", "integer"),
        (lambda: TwoStep(tolerance="small"), "twostep.tolerance", "number"),
        (lambda: TwoStep(tolerance=np.inf), "twostep.tolerance", "finite"),
        (lambda: EllipsoidSegmented(cuts_s=(1.0, np.nan)), "ellipsoid_segmented.cuts_s.1", "finite"),
        (lambda: TollesLawsonCalibrator(band_hz=(0.5, 0.1)), "tolles_lawson.band_hz", "greater than the first"),
        (lambda: TollesLawsonCalibrator(terms=17), "tolles_lawson.terms", "16 or 18"),
        (lambda: KalmanSettings(noise_variance_nT2=0.0), "settings.noise_variance_nT2", "greater than 0"),
        (lambda: MaximumLikelihoodNewton(iterations=0), "ml_newton.iterations", "found 0"),
    ],
)
def test_what_is_refused_and_what_would_be_right_is_told(make, where, what):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.where == where
    assert what in caught.value.what


def test_numbers_of_numpy_and_lists_are_as_good_as_python_s():
    assert TwoStep(rounds=np.int64(3), tolerance=np.float64(1e-4)).rounds == 3
    assert EllipsoidSegmented(cuts_s=[100.0, 200]).cuts_s == [100.0, 200]
    assert EllipsoidSegmented(cuts_s=np.array([100.0])).cuts_s is not None
