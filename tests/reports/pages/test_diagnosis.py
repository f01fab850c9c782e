"""The tiles that answer first: what is missing, how sure that is, what else it could be, and its share of the gap."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from diagnosis.workflow import diagnose
from reports.pages.diagnosis import _tiles
from sim.effects.currents import MotorCurrent
from sim.effects.electronics import Quantisation
from sim.effects.faults import Spikes
from sim.effects.noise import WhiteNoise
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, recording

BARE = {"field": {"enu_nT": FIELD_ENU_NT.tolist()}, "effects": {"white_noise": {"std_nT": [NOISE_NT] * 3}}}
CASES: dict[str, tuple[float, dict[str, Any], tuple[str, str, str]]] = {
    "nothing": (NOISE_NT, {}, ("nothing", "no cause identified", "no gap beyond the noise")),
    "fitted": (
        NOISE_NT,
        {MotorCurrent.name: {"gain_nT_A": [20.0, -10.0, 40.0]}},
        (MotorCurrent.name, "evidence on held-out data", "% removed"),
    ),
    "faults": (
        NOISE_NT,
        {Spikes.name: {"rate_hz": 0.1, "amplitude_nT": 300.0}},
        (Spikes.name, "evidence", "affected samples are left out"),
    ),
    "rounding": (
        NOISE_NT,
        {Quantisation.name: {"step_nT": 2 * NOISE_NT}},
        (Quantisation.name, "evidence", "no gap beyond the noise"),
    ),
    "noise": (3 * NOISE_NT, {}, (WhiteNoise.name, "evidence", "noise cannot be predicted")),
}


@pytest.mark.parametrize(("noise_nT", "hidden", "said"), CASES.values(), ids=CASES)
def test_the_tiles_say_what_the_finding_rests_on(
    noise_nT: float, hidden: dict[str, Any], said: tuple[str, str, str]
) -> None:
    found = diagnose(recording(2000, noise_nT=noise_nT, hidden=hidden), ModelSpec.model_validate(BARE))
    (missing, _), (_, sure), _, (_, share) = _tiles(found)
    assert missing == said[0]
    assert said[1] in sure
    assert said[2] in share


def test_the_tile_says_whether_a_second_recording_was_asked() -> None:
    given = recording(2000, hidden={MotorCurrent.name: {"gain_nT_A": [20.0, -10.0, 40.0]}})
    found = diagnose(given, ModelSpec.model_validate(BARE))
    assert "confirm with a second" in _tiles(found)[1][1]
    asked = replace(found, has_second=True)
    assert "the second recording does not confirm it" in _tiles(asked)[1][1]
    switched = replace(found.named[0], effect=replace(found.named[0].effect, active_s=(10.0, 20.0)))
    assert "a second cannot confirm it" in _tiles(replace(asked, named=(switched,)))[1][1]
