"""The JSON of several recordings repeats what was found; the gap of all; the worst of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.evidence.gap_size import GapSize
from diagnosis.evidence.localise import ChannelShare
from diagnosis.policy import STANDARD
from diagnosis.result import Transfer
from diagnosis.several.result import SENSORS
from tests.diagnosis.several.told import ABSENT, GAP, HERE, OPEN, common, gap, own, pooled

GAP_JSON = {
    "before": {"rms_nT": 20.0, "rms_sigma": 10.0},
    "after": {"rms_nT": 6.0, "rms_sigma": 3.0},
    "explained": 91 / 99,
}

HOT, ON = ("temperature", "body"), ("current", "body")


def test_the_json_has_the_verdict_the_effects_and_each_recording() -> None:
    some = common(Transfer.SOME, (HERE, ABSENT, OPEN), (3.0, None, 2.0))
    single = common(Transfer.SINGLE_RUN, (HERE, OPEN, OPEN), (1.0, None, None))
    gaps = (gap(where=[ChannelShare("mag_x_nT", "body", 0.37037)]), gap(left=("left",)), gap())
    told = pooled(some, single=(single,), gaps=gaps, advice=("do",), sentence="so.").as_dict()
    assert (told["verdict"], told["sentence"], told["mode"]) == ("named", "so.", "vector")
    assert told["where"] == [{"channel": "mag_x_nT", "frame": "body", "score": 0.1235}]
    assert (told["left"], told["advice"]) == (["second: left"], ["do"])
    assert told["gap"]["before"] == pytest.approx(GAP_JSON["before"])
    assert told["gap"]["explained"] == pytest.approx(GAP_JSON["explained"])
    assert "worst" not in told
    (effect,), (alone,) = told["effects"], told["not_borne_out"]
    assert (effect["name"], effect["evidence"], alone["evidence"]) == ("motor_current", "some", "single-run")
    assert (effect["how"], effect["evidence_nats"], effect["strength_sigma"]) == ("held-out", 50.0, 2.0)
    assert effect["agreement"] == {"chi2": 1.5, "degrees": 3, "p": 0.7}
    assert [one["says"] for one in effect["recordings"]] == [HERE, ABSENT, OPEN]
    assert [one["evidence_nats"] for one in effect["recordings"]] == [50.0, None, 50.0]
    assert effect["recordings"][1]["parameters"] == {}
    assert effect["recordings"][2]["parameters"]["gain_nT_A"]["value"] == [2.0, 0.0, 0.0]
    gain = effect["parameters"]["gain_nT_A"]
    assert (gain["value"], gain["unit"]) == ([3.0, 0.0, 0.0], "nT/A")
    assert gain["high"][0] == pytest.approx(3.0 + 1.96 * 0.1, abs=1e-4)
    assert [one["name"] for one in told["recordings"]] == ["first", "second", "third"]
    assert [list(one["coefficients"]) for one in told["recordings"]] == [["motor_current"], [], ["motor_current"]]
    assert told["recordings"][0]["gap_together"] == GAP_JSON
    assert (told["recordings"][0]["gap"], told["recordings"][0]["verdict"]) == ({"own": 1}, "none")


def test_effects_of_single_recordings_are_told_with_the_worst_one_s_first() -> None:
    """Where one recording says more alone than all together; not those that are common."""
    assert pooled().as_dict()["effects"] == []
    told = pooled(first=1).as_dict()
    assert told["effects"] == [{"name": "scale", "only_in": name} for name in ("second", "first", "third")]
    assert told["worst"] == "second"
    each = (own(), own(effects=({"name": "motor_current"},)), own(effects=()))
    told = pooled(common(Transfer.SOME), each=each, first=1).as_dict()
    assert [(one["name"], one.get("only_in")) for one in told["effects"]] == [
        *(("scale", "first"), ("motor_current", None))
    ]


def test_sensors_are_no_second_recording() -> None:
    told = pooled(common(Transfer.TRANSFERRED), scope=SENSORS, each=[own(effects=())] * 3, first=0).as_dict()
    (effect,) = told["effects"]
    assert (effect["evidence"], effect["among_sensors"]) == ("single-run", "the same")
    assert len(effect["sensors"]) == len(told["sensors"]) == 3
    assert "recordings" not in told


def test_only_what_no_recording_shows_cannot_be_seen() -> None:
    each = [own(not_observable=names) for names in (("a", "b", "c"), ("c", "a"), ("a", "d", "c"))]
    assert pooled(each=each).not_observable == ("a", "c")
    assert repr(pooled(sentence="so.")) == "named: so."


def test_the_gap_of_all_is_their_rms_and_what_is_explained_at_most_all() -> None:
    """Of the recordings with a gap alone."""
    other, none = GapSize(10.0, 5.0, 2.0, 1.0, 0.8), GapSize(2.0, 1.0, 6.0, 3.0, None)
    whole = GapSize.joint([GAP, other])
    assert whole.before_nT == pytest.approx(np.sqrt((20.0**2 + 10.0**2) / 2))
    assert whole.after_sigma == pytest.approx(np.sqrt((3.0**2 + 1.0**2) / 2))
    assert whole.explained == pytest.approx((10.0**2 - 3.0**2 + 5.0**2 - 1.0**2) / (10.0**2 + 5.0**2 - 2))
    assert GapSize.joint([replace(GAP, after_sigma=0.5)]).explained == 1.0
    assert GapSize.joint([GAP, none]).explained == pytest.approx(GAP.explained)
    assert GapSize.joint([none]).explained is None


def test_a_channel_s_share_is_its_mean_over_all_recordings_the_largest_first() -> None:
    """A recording in which it has no share counts as none; the list is cut."""
    hot, on, more = (ChannelShare(*one, share) for one, share in ((HOT, 0.6), (ON, 0.3), (ON, 0.6)))
    found = pooled(gaps=(gap(where=[hot, on]), gap(where=[more]), gap())).where
    assert [(one.channel, one.frame) for one in found] == [ON, HOT]
    assert [one.share for one in found] == pytest.approx([0.3, 0.2])
    many = pooled(gaps=(gap(where=[ChannelShare(f"c{k}", "earth", 0.01 * k) for k in range(50)]),)).where
    assert [one.channel for one in many] == [f"c{49 - k}" for k in range(STANDARD.most_channels)]
