"""The magnetometers that a PX4 log holds samples of: from sensor_mag, vehicle_magnetometer or sensor_combined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from recordings.readers.px4.contents import ULog, UlogTopic
from recordings.readers.px4.parameters import ParameterState
from recordings.readers.px4.sampling import sample_times_s
from scenarios.arrays import Array

DENSE = 0.8
"""sensor_mag is read where it has at least this share of the rows of vehicle_magnetometer, the means of its samples."""
MOST_SENSORS = 8
"""Device numbers in one topic beyond which further ones are damage."""


@dataclass(frozen=True, eq=False)
class FieldSamples:
    """A field in gauss, FRD: times_s (n,), field_G (n, 3)."""

    times_s: Array
    field_G: Array


@dataclass(frozen=True, eq=False)
class LoggedSensor:
    """What the log holds of one magnetometer.

    Parameters
    ----------
    number : the device's. instance : of sensor_mag, by which other topics count the sensors.
    sensor : its topic sensor_mag, and samples : of this topic. body : PX4's field, from the topic `source`.
    """

    number: int
    instance: int = 0
    sensor: UlogTopic | None = None
    samples: FieldSamples | None = None
    body: FieldSamples | None = None
    source: str = "vehicle_magnetometer"

    @property
    def is_direct(self) -> bool:
        """Whether sensor_mag is read, not PX4's field."""
        if self.samples is None or self.body is None:
            return self.body is None
        return len(self.samples.times_s) >= DENSE * len(self.body.times_s)

    @property
    def used(self) -> FieldSamples:
        """The samples that are read."""
        found = self.samples if self.is_direct else self.body
        return found or FieldSamples(np.empty(0), np.empty((0, 3)))

    @property
    def topic(self) -> str:
        """The name of the topic that is read."""
        return "sensor_mag" if self.is_direct else self.source


def logged_sensors(log: ULog, state: ParameterState) -> list[LoggedSensor]:
    """Return the sensors: those that vehicle_magnetometer used most first."""
    main = _main_device(log, state)
    found = _navigated_by(log, main)
    for topic in log.instances("sensor_mag"):
        if not {"x", "y", "z"} <= set(topic.names):
            continue
        numbers = topic.column("device_id") if "device_id" in topic else np.full(len(topic), -topic.instance)
        values, counts = np.unique(numbers, return_counts=True)
        number = int(values[np.argmax(counts)])
        rows = numbers == number
        samples = FieldSamples(sample_times_s(topic)[rows], topic.vectors("x", "y", "z")[rows])
        known = found.get(number, LoggedSensor(number))
        found[number] = replace(known, instance=topic.instance, sensor=topic, samples=samples)
    return sorted(found.values(), key=lambda one: (one.number != main, -_rows(one.body), -_rows(one.samples)))


def _main_device(log: ULog, state: ParameterState) -> int:
    """Return the sensor that PX4 navigates by: the one that vehicle_magnetometer's first instance names most often."""
    body, selection = log.first("vehicle_magnetometer"), log.first("sensor_selection")
    if body and "device_id" in body:
        values, counts = np.unique(body.column("device_id"), return_counts=True)
        return int(values[np.argmax(counts)])
    selected = int(selection.column("mag_device_id")[-1]) if selection and "mag_device_id" in selection else 0
    first = log.first("sensor_mag")
    own = int(first.column("device_id")[0]) if first and "device_id" in first else 0
    return selected or state.whole("CAL_MAG_PRIME") or own or state.whole("CAL_MAG0_ID")


def _navigated_by(log: ULog, main: int) -> dict[int, LoggedSensor]:
    """Return the sensors of vehicle_magnetometer, by number, with their samples; in the oldest logs the main sensor."""
    found: dict[int, LoggedSensor] = {}
    for topic in log.instances("vehicle_magnetometer"):
        numbers = topic.column("device_id") if "device_id" in topic else np.full(len(topic), main)
        if "magnetometer_ga[2]" not in topic:
            continue
        times_s, field_G = sample_times_s(topic), topic.vectors(*(f"magnetometer_ga[{k}]" for k in range(3)))
        for number in np.unique(numbers)[:MOST_SENSORS].tolist():
            if number not in found:
                rows = numbers == number
                body = FieldSamples(times_s[rows], field_G[rows])
                found[number] = LoggedSensor(number, topic.instance, body=body)
    oldest = None if found else _oldest(log)
    return {main: LoggedSensor(main, body=oldest, source="sensor_combined")} if oldest else found


def _oldest(log: ULog) -> FieldSamples | None:
    """Return the samples of sensor_combined, whose rows repeat between those of the magnetometer."""
    topic = log.first("sensor_combined")
    if topic is None or not {"magnetometer_ga[2]", "magnetometer_timestamp_relative"} <= set(topic.names):
        return None
    relative = topic.column("magnetometer_timestamp_relative").astype(np.float64)
    times_us = topic.column("timestamp").astype(np.float64) + relative
    _, rows = np.unique(times_us, return_index=True)
    rows = rows[np.abs(relative[rows]) < 1e6]
    field_G = topic.vectors(*(f"magnetometer_ga[{k}]" for k in range(3)))
    return FieldSamples(times_us[rows] * 1e-6, field_G[rows])


def _rows(samples: FieldSamples | None) -> int:
    return len(samples.times_s) if samples else 0
