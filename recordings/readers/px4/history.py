"""PX4's calibration of a magnetometer over the time of a log, applied and undone sample by sample."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from recordings.readers.px4.calibration import Correction, Formula, corrections, formula_by_parameters, slot_of
from recordings.readers.px4.contents import ULog
from recordings.readers.px4.parameters import ParameterState
from recordings.readers.px4.power import power_signal
from recordings.readers.px4.sampling import between, held
from recordings.readers.px4.sensors import FieldSamples, LoggedSensor
from scenarios.arrays import Array

FEWEST_COMMON = 3
"""Samples that sensor_mag and vehicle_magnetometer need in common to tell which formula the release has."""
CLEARLY = 0.7
"""A formula replaces that of the parameters where its misfit is below this share."""


class CalibrationHistory:
    """The corrections of a magnetometer, applied or undone row by row.

    Parameters
    ----------
    slot : n of CAL_MAGn_*, None where none is the magnetometer's. spans : the correction in force from each of
        `starts_s` on, the times of the states of the parameters. lacking : whether the log lacks the power signal of
        a compensation that was needed.
    """

    def __init__(self, log: ULog, sensor: LoggedSensor, states: Sequence[ParameterState], formula: Formula) -> None:
        self.log, self.formula, self.instance = log, formula, sensor.instance
        slots = [slot_of(state, sensor.number) for state in states]
        self.slot = next((slot for slot in slots if slot is not None), None)
        self.spans = corrections(states, slots, sensor.number, formula)
        self.starts_s = np.array([state.from_s for state in states])
        self.lacking = False

    def body(self, correction: Correction, samples: FieldSamples) -> Array:
        """Return PX4's field (n, 3) from sensor_mag."""
        c, bias_G = self._power(correction, samples.times_s), self.bias_G(samples.times_s)
        return correction.body(samples.field_G, c, bias_G, self.formula)

    def raw(self, correction: Correction, samples: FieldSamples) -> Array:
        """Return the raw field along the body's axes (n, 3) from PX4's field."""
        c, bias_G = self._power(correction, samples.times_s), self.bias_G(samples.times_s)
        return correction.raw(samples.field_G, c, bias_G, self.formula)

    def raw_of_sensor(self, correction: Correction, samples: FieldSamples) -> Array:
        """Return the raw field along the body's axes (n, 3) from sensor_mag."""
        if self.formula is Formula.DRIVER:
            return correction.raw_of_driver(samples.field_G)
        return np.asarray(samples.field_G @ correction.rotation.T)

    def each(self, samples: FieldSamples, act: Callable[[Correction, FieldSamples], Array]) -> Array:
        """Return (n, 3): what `act` makes of the samples, with the correction in force at each."""
        found = np.empty_like(samples.field_G)
        place = self._place(samples.times_s)
        for k in np.unique(place).tolist():
            rows = place == k
            found[rows] = act(self.spans[k], FieldSamples(samples.times_s[rows], samples.field_G[rows]))
        return found

    def in_force(self, times_s: Array) -> list[int]:
        """Return the places in `spans` of the different corrections at times (n,), the most frequent first."""
        places, counts = np.unique(self._place(times_s), return_counts=True)
        ordered = places[np.argsort(-counts, kind="stable")].tolist()
        distinct = {id(self.spans[k]): k for k in reversed(ordered)}
        return sorted(distinct.values(), key=ordered.index)

    def _place(self, times_s: Array) -> Array:
        return np.asarray(np.clip(np.searchsorted(self.starts_s, times_s, "right") - 1, 0, None))

    def _power(self, correction: Correction, at_s: Array) -> Array:
        if not np.any(correction.power):
            return np.zeros(len(at_s))
        signal = power_signal(
            self.log, correction.power_type, at_s, armed_alone=self.formula is not Formula.SENSORS_MODULE
        )
        self.lacking = self.lacking or signal is None
        return np.zeros(len(at_s)) if signal is None else signal

    def bias_G(self, at_s: Array) -> Array:
        """Return b (n, 3): the last valid magnetometer_bias_estimate, zero after a change of the parameters."""
        topic, k = self.log.first("magnetometer_bias_estimate"), self.instance
        names = [f"bias_{axis}[{k}]" for axis in "xyz"]
        if topic is None or not {*names, f"valid[{k}]"} <= set(topic.names):
            return np.zeros((len(at_s), 3))
        times_s, valid = topic.times_s(), topic.column(f"valid[{k}]") != 0
        estimates = topic.vectors(*names)[valid]
        if not len(estimates):
            return np.zeros((len(at_s), 3))
        bias_G = np.column_stack([held(at_s, times_s[valid], column) for column in estimates.T])
        estimated_s = held(at_s, times_s[valid], times_s[valid], -np.inf)
        since_s = self._since_s()[self._place(at_s)]
        return np.where((estimated_s >= since_s)[:, None], np.nan_to_num(bias_G), 0.0)

    def _since_s(self) -> Array:
        """Return, for each of `spans`, since when the same correction has been in force."""
        since_s = self.starts_s.copy()
        for k in range(1, len(since_s)):
            if self.spans[k] is self.spans[k - 1]:
                since_s[k] = since_s[k - 1]
        return since_s


def usual_formula(log: ULog, state: ParameterState) -> Formula:
    """Return the formula by the release and the parameters of a log."""
    combined = log.first("sensor_combined")
    return formula_by_parameters(state, log.release, oldest=combined is not None and "magnetometer_ga[2]" in combined)


def formula_by_samples(log: ULog, sensor: LoggedSensor, states: Sequence[ParameterState]) -> Formula | None:
    """Return the formula by which sensor_mag gives vehicle_magnetometer; None where both are not there together."""
    if sensor.samples is None or sensor.body is None:
        return None
    expected_G, known = between(sensor.samples.times_s, sensor.body.times_s, sensor.body.field_G)
    if np.count_nonzero(known) < FEWEST_COMMON:
        return None
    samples = FieldSamples(sensor.samples.times_s[known], sensor.samples.field_G[known])
    misfit = {}
    for formula in Formula:
        undo = CalibrationHistory(log, sensor, states, formula)
        error_G = undo.each(samples, undo.body) - expected_G[known]
        misfit[formula] = float(np.median(np.linalg.norm(error_G, axis=1)))
    usual = usual_formula(log, states[0])
    best = min(misfit, key=lambda formula: misfit[formula])
    return best if misfit[best] < CLEARLY * misfit[usual] else usual
