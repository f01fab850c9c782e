"""Hyperparameters as text."""

from __future__ import annotations

from dataclasses import fields

import pytest

from calib import CALIBRATORS, get
from calib.options import options_of
from scenarios.errors import InputError

STATED = {
    "ml_geometric": {},
    "ml_geometric:huber": {"huber": 1.345},
    "ml_geometric:huber=2.5:iterations=7": {"huber": 2.5, "iterations": 7},
    "ml_geometric:huber=none": {"huber": None},
    "twostep:rounds=9:tolerance=0.01": {"rounds": 9, "tolerance": 0.01},
    "ellipsoid:robust=no": {"robust": False},
    "pso:inertia=0.9/0.5:polish=no": {"inertia": (0.9, 0.5), "polish": False},
    "gyro_ml:aligned": {"aligned": True},
    "least_squares_gradiometer:two_step": {"start": "two_step"},
    "tolles_lawson:terms=18": {"terms": 18},
}


@pytest.mark.parametrize("text", STATED)
def test_options_are_hyperparameters(text):
    name = text.partition(":")[0]
    assert get(text) == CALIBRATORS[name](**STATED[text])


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("twostep:huber", r"twostep has no option 'huber' \(options: .*rounds=6"),
        ("twostep:rounds=0", "twostep.rounds: .*greater than or equal to 1"),
        ("twostep:rounds=few", "twostep.rounds: .*integer.*'few'"),
        ("twostep:rounds", "rounds needs a value .*rounds=.*a whole number"),
        ("twostep:", "no option ''"),
        ("cube:rounds=1", "no calibrator is called 'cube'"),
    ],
)
def test_what_no_option_is_is_refused_in_a_line(text, problem):
    with pytest.raises(InputError, match=problem) as refused:
        get(text)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", list(CALIBRATORS))
def test_defaults_as_text_give_the_default_calibrator(name):
    options = {key: default for key, (default, _) in options_of(CALIBRATORS[name]).items()}
    stated = get(":".join([name, *(f"{key}={default}" for key, default in options.items())]))
    assert stated == get(name)
    assert all(permitted for _, permitted in options_of(CALIBRATORS[name]).values())
    assert set(options) <= {one.name for one in fields(CALIBRATORS[name])}
