"""A plan and its legs in words and as JSON, from values that are told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.scenario import load
from validation.planning.manoeuvre import Leg
from validation.planning.next_leg import LegSequence, NextLeg
from validation.planning.next_leg_summary import headline as after_words
from validation.planning.next_leg_summary import rows as after_rows
from validation.planning.next_leg_summary import summary as after_summary
from validation.planning.plan import Plan, planned
from validation.planning.summary import PERFECT, attitude, headline, limits, rows, summary
from validation.planning.task import HAND, PlanningTask
from validation.planning.verification import Confirmed


@pytest.fixture(scope="module")
def found() -> Plan:
    task = PlanningTask.of(HAND, load("standard-full"), noise_std_nT=10.0)
    return replace(planned(task, 60.0), confirmed=Confirmed("ml_geometric", 2.5, 40, 3))


def test_the_json_repeats_the_plan(found: Plan) -> None:
    told = summary(found, "plan.toml")
    assert told["scenario"] == "plan.toml"
    assert told["predicted"]["offset_rms_nT"] == found.error
    assert told["predicted"]["met"] is True
    assert told["limit"]["ratio"] == pytest.approx(found.error / told["limit"]["offset_rms_nT"])
    assert told["limit"]["staying"] is None  # a person can hold any tilt
    assert (told["limit"]["roll_deg"], told["limit"]["pitch_deg"]) == (180.0, 90.0)
    assert told["confirmed"] == {"offset_rms_nT": 2.5, "calibrator": "ml_geometric", "trials": 40, "failures": 3}
    assert "confirmed" not in summary(replace(found, confirmed=None), "")
    for leg, said, row in zip(found.choice.legs, told["legs"], rows(found), strict=True):
        assert (said["yaw_deg"], said["pitch_deg"], said["roll_deg"]) == leg.angles_deg
        assert said["lasts_s"] == pytest.approx(leg.amount, abs=0.051)
        assert row[1] == said["attitude"] == attitude(leg)
    assert [row[0] for row in rows(found)] == [str(k + 1) for k in range(len(found.choice.legs))]
    begins = [said["begins_s"] for said in told["legs"]]
    assert np.all(np.diff(begins) >= 3.0 + 1.0 - 0.06)  # a hold and a turn at least


def test_the_headline_says_what_is_missed_and_what_trials_gave(found: Plan) -> None:
    assert "flown 40 times, ml_geometric is off by 2.5 nT rms, 3 failed" in headline(found)
    sound = replace(found, confirmed=Confirmed("ml_geometric", 2.5, 40, 0), target=found.error)
    assert "failed" not in headline(sound)
    assert "target" not in headline(sound)
    missed = replace(found, target=0.99 * found.error)
    assert not missed.met
    assert "is not met: give more --time" in headline(missed)
    assert PERFECT not in headline(found)
    assert found.staying_ratio is None
    assert len(limits(found)) == 1
    staying = replace(found, staying=replace(found.least, value=found.error / 1.5, gap=0.01234))
    assert staying.staying_ratio == pytest.approx(1.5)
    assert "this plan has 1.5 times the limit" in headline(staying)
    assert "in place is" in headline(staying)
    assert headline(staying).count("(duality gap 1.2 %)") == 1
    assert limits(staying)[1][2:] == ("1.5", "1.2")
    assert summary(staying, "")["limit"]["staying"]["ratio"] == pytest.approx(1.5)


@pytest.mark.parametrize(("factor", "pays"), [(0.9 - 1e-6, True), (0.9 + 1e-6, False)])
def test_a_leg_pays_that_takes_a_tenth_of_the_error_off_in_each_minute(found: Plan, factor: float, pays: bool) -> None:
    minutes = found.choice.phase.duration_s / 60.0
    leg = NextLeg(found.choice, 10.0, 10.0 * factor**minutes)
    assert leg.pays is pays
    assert leg.gain == pytest.approx(10.0 - leg.after)
    assert leg.rate == pytest.approx(-np.log(factor))
    assert NextLeg(found.choice, np.inf, 5.0).pays


def test_legs_after_a_recording_are_numbered_and_summed(found: Plan) -> None:
    task = found.task.going_on(np.diag([0.03] * 3 + [1.0] * (len(found.task.wanted) - 3)), 0.0)
    one, other = NextLeg(found.choice, 10.0, 4.0), NextLeg(found.choice, 4.0, 3.9)
    told = LegSequence(task, (one, one), other, found.scenario, 3.0, found.least)
    words = after_words(told)
    assert "leg 1: in 60 s 10 nT becomes 4 nT" in words.replace("1 min", "60 s")
    assert "a further leg does not pay: " in words
    assert "determine the" in words
    said = after_summary(told, "next.toml")
    assert said["predicted"] == {"offset_rms_nT": 3.0, "before": pytest.approx(10.0)}
    assert said["scenario"] == "next.toml"
    assert said["limit"]["offset_rms_nT"] == found.least.value
    assert said["legs"][1]["gain_nT"] == 6.0
    assert said["no_longer_pays"]["before_nT"] == 4.0
    count = len(found.choice.legs)
    assert [row[0] for row in after_rows(told)] == [f"{n}.{k}" for n in (1, 2) for k in range(1, count + 1)]
    nothing = LegSequence(task, (), None, None, None, None)
    assert after_summary(nothing, "")["scenario"] is None
    assert after_summary(nothing, "")["limit"] is None
    assert "pay" not in after_words(nothing)
    undetermined = after_words(LegSequence(task, (NextLeg(found.choice, np.inf, 4.0),), None, None, None, None))
    assert "an undetermined" in undetermined


@pytest.mark.parametrize(
    ("leg", "words"),
    [
        (Leg(0.0, 10.0, 0.0, 1.0), "facing east, nose 10° down"),
        (Leg(90.0, 0.0, -30.0, 1.0), "facing north, left side 30° down"),
        (Leg(-45.0, 0.4, 0.4, 1.0), "facing south-east, level"),
        (Leg(0.0, -90.0, 179.8, 1.0), "facing east, nose 90° up, upside down"),
    ],
)
def test_every_attitude_has_words(leg: Leg, words: str) -> None:
    assert attitude(leg) == words
