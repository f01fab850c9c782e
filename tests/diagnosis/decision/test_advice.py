"""Every line of advice."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.decision.advice import advice_for
from diagnosis.evidence.localise import ChannelShare
from diagnosis.evidence.residual_tests import RisingSpectrum
from diagnosis.result import Diagnosis, EvidenceKind, Transfer
from diagnosis.verdict import Verdict
from sim.effects import BY_NAME
from sim.effects.iron import HardIron
from tests.diagnosis.decision.answers import (
    FOUND,
    POSED,
    SEEN,
    diagnosis_of,
    either,
)
from tests.diagnosis.synthetic import problem, recording, without_attitude


def _turned(hz: float = 0.005) -> np.ndarray[Any, Any]:
    """A gap across the field, slow if nothing else is said."""
    across = np.cross(POSED.state.field_nT, [0.0, 0.0, 1.0])
    return np.sin(2 * np.pi * hz * POSED.state.time_s)[:, None] * across / np.linalg.norm(across, axis=1, keepdims=True)


def test_nothing_is_advised_where_nothing_was_found() -> None:
    assert advice_for(diagnosis_of(Verdict.NONE)) == ()


@pytest.mark.parametrize(
    ("found", "says"),
    [
        (diagnosis_of(Verdict.CLASS, either(FOUND, "bandwidth")), "may also be bandwidth. To distinguish: "),
        (diagnosis_of(Verdict.NAMED, FOUND), "--confirm"),
        (diagnosis_of(Verdict.NONE, absorbed=("eddy_current",)), "eddy_current can hardly be distinguished from"),
        (diagnosis_of(Verdict.NONE, untested=("motor_current (no current)",)), "lack of channels: motor_current"),
        (diagnosis_of(Verdict.UNKNOWN, before_nT=_turned(), after_nT=_turned()), "check the attitude"),
    ],
)
def test_each_finding_has_its_advice(found: Diagnosis, says: str) -> None:
    (line,) = [line for line in advice_for(found) if says in line]
    assert line.endswith(".")


@pytest.mark.parametrize(
    ("left_nT", "clocks"),
    [(10 * _turned(3.0), True), (10 * _turned(3.0)[:, :1] * np.ones(3), False)],
    ids=["across", "in the body"],
)
def test_what_rises_and_turns_the_field_is_of_the_clocks_and_no_wheel(
    left_nT: np.ndarray[Any, Any], clocks: bool
) -> None:
    """Stamps that are off leave an error as fast as the samples, of which the strength has nothing."""
    found = diagnosis_of(Verdict.UNKNOWN, rise=RisingSpectrum(2.0, 5.0, False), before_nT=left_nT, after_nT=left_nT)
    told = " ".join(advice_for(found))
    assert ("time stamps" in told) is clocks
    assert ("a wheel" in told) is not clocks


def test_a_recorded_channel_is_offered_as_an_actuator() -> None:
    time = np.linspace(0.0, 1.0, 4000)
    wave, sag = np.sin(20 * time), np.cos(30 * time)
    given = replace(recording(), channels={"pump": wave, "battery": 12 - time, "battery_V": sag, "cell_voltage": sag})
    supply = [ChannelShare(name, "body", 0.6) for name in ("battery_V", "cell_voltage")]
    led = (ChannelShare("pump", "body", 0.5), ChannelShare("battery", "body", 0.45))
    by_supply = advice_for(diagnosis_of(Verdict.UNKNOWN, problem=problem(given), where=(*supply, *led)))
    assert "--actuator" not in " ".join(by_supply)  # a voltage follows the load and drives nothing
    found = diagnosis_of(Verdict.UNKNOWN, problem=problem(given), where=led)
    assert "--actuator pump" in advice_for(found)[0]
    assert "battery" not in advice_for(found)[0]  # it only falls, as every slow course does
    as_time = (ChannelShare("pump", "body", 0.5), ChannelShare("time_s", "body", 0.49))
    assert "--actuator" not in " ".join(advice_for(replace(found, where=as_time)))
    assert "--actuator" not in " ".join(advice_for(replace(found, verdict=Verdict.CLASS)))


def test_navigation_is_suspected_for_what_is_left_and_not_for_what_was_found() -> None:
    along_nT = POSED.state.field_nT * np.sin(0.03 * POSED.state.time_s)[:, None] / 1e4
    for before_nT, after_nT, told in ((_turned(), along_nT, False), (along_nT, _turned(), True)):
        found = diagnosis_of(Verdict.PARTIAL, FOUND, before_nT=before_nT, after_nT=after_nT)
        assert any("check the attitude" in line for line in advice_for(found)) is told


def test_a_height_is_offered_as_no_actuator() -> None:
    given = replace(recording(), channels={"altitude_m": np.linspace(0.0, 900.0, 4000), "pump": np.ones(4000)})
    where = (ChannelShare("altitude_m", "body", 0.9), ChannelShare("pump", "body", 0.5))
    told = " ".join(advice_for(diagnosis_of(Verdict.UNKNOWN, problem=problem(given), where=where)))
    assert "--actuator pump" in told
    assert "--actuator altitude_m" not in told


def test_what_was_confirmed_need_not_be_confirmed_again() -> None:
    assert advice_for(diagnosis_of(Verdict.NAMED, replace(FOUND, transfer=Transfer.TRANSFERRED))) == ()


def test_what_the_values_show_needs_no_second_recording() -> None:
    assert advice_for(diagnosis_of(Verdict.UNKNOWN, SEEN)) == ()
    assert "--confirm" in " ".join(advice_for(diagnosis_of(Verdict.PARTIAL, SEEN, FOUND)))


def test_a_channel_whose_curve_stands_is_an_actuator_where_it_commands_a_current() -> None:
    given = replace(recording(), channels={"pump": np.linspace(-0.5, 2.0, 4000)})
    curve = replace(FOUND, effect=BY_NAME["channel_effect"](channel="pump"), kind=EvidenceKind.CURVE)
    found = diagnosis_of(Verdict.UNKNOWN, curve, problem=problem(given), where=(ChannelShare("pump", "body", 0.5),))
    told = " ".join(advice_for(found))
    assert "The curve of pump shows no mechanism" in told
    assert "The curve holds for pump from -0.5 to 2 only." in told
    assert told.count("--actuator pump") == 1
    as_current = replace(given, current_A=given.channels["pump"][:, None])
    assert "--actuator" not in " ".join(advice_for(replace(found, problem=problem(as_current))))


def test_without_attitude_attitude_is_asked_for() -> None:
    found = diagnosis_of(Verdict.NONE, problem=problem(without_attitude(recording())))
    assert "log attitude" in advice_for(found)[0]
    assert "no interval" not in advice_for(found)[0]


def test_beside_a_recorded_attitude_the_fields_vector_is_asked_for() -> None:
    bare = problem(without_attitude(recording()))
    found = diagnosis_of(Verdict.NONE, problem=replace(bare, recording=recording()))
    assert "give --field-enu-nT" in advice_for(found)[0]
    assert "log attitude" not in advice_for(found)[0]


def test_where_parameters_have_no_interval_it_is_said_why() -> None:
    found = diagnosis_of(Verdict.NAMED, FOUND, problem=problem(without_attitude(recording())))
    assert "strength was compared, and parameters have no interval" in advice_for(found)[0]


@pytest.mark.parametrize(("stood", "told"), [((0.0, 100.0), True), ((100.0, 400.0), True), ((0.0, 50.0), False)])
def test_iron_that_begins_where_the_vehicle_stops_standing_may_be_the_field_there(
    stood: tuple[float, float], told: bool
) -> None:
    """It acts from 100.0 s on; the run has 400 s."""
    on = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0), active_s=(100.0, 500.0)))
    time_s, field_nT = POSED.state.time_s, POSED.state.field_nT.copy()
    field_nT[(time_s >= stood[0]) & (time_s < stood[1])] = field_nT[0]
    posed = replace(POSED, state=replace(POSED.state, field_nT=field_nT))
    lines = advice_for(diagnosis_of(Verdict.PARTIAL, on, problem=posed))
    assert any("turn the vehicle at this place too" in line for line in lines) is told
    jump = replace(FOUND, effect=BY_NAME["offset_jump"](100.0, (3.0, 0.0, 0.0)))
    lines = advice_for(diagnosis_of(Verdict.PARTIAL, jump, problem=posed))
    assert any("from 100.0 s on" in line and "turn the vehicle at this place too" in line for line in lines) is told
    always = replace(FOUND, effect=HardIron((3.0, 0.0, 0.0)))
    assert "turn the vehicle at this place too" not in " ".join(
        advice_for(diagnosis_of(Verdict.PARTIAL, always, problem=posed))
    )
