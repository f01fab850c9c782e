"""The topics of a bag as a vehicle's log: which is the magnetometer, the IMU, the place, and what is a channel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from recordings.channels import (
    ALTITUDE,
    ARMED,
    BATTERY_VOLTAGE,
    LATITUDE,
    LONGITUDE,
    TEMPERATURE,
    THROTTLE,
    current_name,
)
from recordings.columns import ATTITUDE
from recordings.likely_units import field_unit
from recordings.readers.navigation import east_north_m, median_place
from recordings.readers.ros import roles
from recordings.readers.ros.axes import LEAST_UP, BodyAxes, cosine_up
from recordings.readers.ros.bag import Bag, Topic
from recordings.readers.ros.clock import Clock, date_of
from recordings.readers.ros.mounts import plain, says_down
from recordings.readers.ros.own_types import VECTOR
from recordings.readers.ros.roles import frame_of, has_fix, has_vector, nearest, vector_of
from recordings.readers.vehicle_log import VehicleLog, vector_columns
from recordings.reading import COUNT
from recordings.streams import Interpolation, Stream
from recordings.units import UNITS
from scenarios.arrays import Array
from scenarios.text import figure

TESLA_NT = 1e9
MOST_TESLA = 1e-3
"""A thousandth of a tesla is twenty times the Earth's field: values beyond are in another unit."""
MOSTLY = 0.9
"""Share of a battery's currents that are positive, above which a discharge is counted positive."""
Columns = dict[str, NDArray[Any]]
SLERP = dict.fromkeys(ATTITUDE, Interpolation.SLERP)
NOT_TOLD = "a bag does not tell what calibration the driver or the autopilot applied: nothing is undone"


@dataclass(eq=False)
class BagLog:
    """A vehicle's log while it is gathered from a bag's topics.

    used : topic -> paths of fields that are a recording's own columns and thus no channels.
    axes : the turns of frames to the body. up : by IMU, the cosine between up and its force in its own world.
    """

    bag: Bag
    magnetometers: Mapping[str, Topic]
    notes: list[str] = field(default_factory=list)
    streams: dict[str, Stream] = field(default_factory=dict)
    used: dict[str, tuple[str, ...]] = field(default_factory=dict)
    unit: str = "nT"
    up: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.main = next(iter(self.magnetometers.values()))
        self.clock = Clock.of(self.main)
        imus = [frame_of(topic) for topic in self.of_kind(roles.IMU)]
        self.axes = BodyAxes(self.bag.mounts, self.bag.mounts.body_of(frame_of(self.main), imus))

    def of_kind(self, *kinds: str) -> list[Topic]:
        """Return the topics of some types."""
        return [topic for topic in self.bag.topics.values() if topic.kind in kinds]

    def add(self, topic: Topic, columns: Columns, how: Mapping[str, Interpolation] | None = None, *used: str) -> None:
        """Take columns of a topic as a stream, from fields under the paths `used`."""
        key = f"{topic.name} {', '.join(columns)[:40]}"
        self.streams[key] = Stream(self.clock.times_s(topic), columns, how or {})
        self.used[topic.name] = (*self.used.get(topic.name, ()), *used)

    def vehicle_log(self) -> VehicleLog:
        """Return the log, with every field that has no meaning of its own as a channel."""
        place = self._place()
        self._judge_axes()
        fields = {name: self._field(topic) for name, topic in self.magnetometers.items()}
        for step in (self._imu, self._pose, self._temperature, self._battery, self._motors, self._autopilot):
            step()
        self._channels()
        return VehicleLog(
            fields,
            self.streams,
            (*self.bag.notes, *self.axes.notes, *self.notes, NOT_TOLD),
            frame="flu",
            unit=self.unit,
            place=place,
            date=date_of([*self.of_kind(roles.FIX), self.main]),
        )

    def _estimates(self) -> list[Topic]:
        return [topic for topic in self.of_kind(roles.IMU) if has_vector(topic, "orientation")]

    def _judge_axes(self) -> None:
        """Take an IMU whose attitude turns its specific force down as forward, right, down to north, east, down."""
        for imu in self._estimates():
            force, q = vector_of(imu, "linear_acceleration"), _unit(vector_of(imu, "orientation", "wxyz"))
            self.up[imu.name] = cosine_up(q, force) if has_vector(imu, "linear_acceleration") else 0.0
            if self.up[imu.name] < -LEAST_UP:
                self.axes.down.add(plain(frame_of(imu)))

    def _field(self, topic: Topic) -> Stream:
        """Return the stream of a magnetometer; samples without all three axes are left out."""
        path = "magnetic_field" if topic.kind == roles.MAGNETIC else "vector"
        values = vector_of(topic, path)
        known = np.isfinite(values).all(axis=1)
        if not known.all():
            self.notes.append(f"{topic.name}: {np.count_nonzero(~known)} samples without all three axes left out")
        self.used[topic.name] = (path,)
        field = self.axes.vectors(frame_of(topic), values[known])
        columns = vector_columns("mag", self._factor(topic, field) * field)
        return Stream(self.clock.times_s(topic)[known], columns)

    def _factor(self, topic: Topic, values: Array) -> float:
        """Return the nT of a unit of a magnetometer's values: tesla as the type says, else what the values tell."""
        strength = float(np.median(np.linalg.norm(values, axis=1))) if len(values) else 0.0
        if strength <= MOST_TESLA and (topic.kind == roles.MAGNETIC or strength > 0):
            return TESLA_NT
        unit = field_unit(values)
        self.notes.append(f"{topic.name}: a strength of {figure(strength)} is not in tesla: taken as {unit}")
        if unit == COUNT:
            self.unit = COUNT
            return 1.0
        return UNITS["mag"][unit][0]

    def _imu(self) -> None:
        """Take rate and specific force from the nearest IMU, the attitude from the nearest one that estimates it."""
        for group, path in (("gyro", "angular_velocity"), ("accel", "linear_acceleration")):
            imu = nearest([topic for topic in self.of_kind(roles.IMU) if has_vector(topic, path)], self.main)
            if imu is not None:
                values = self.axes.vectors(frame_of(imu), vector_of(imu, path))
                self.add(imu, vector_columns(group, values), None, path)
                self._same_frame(imu)
        imu = nearest(self._estimates(), self.main)
        if imu is not None:
            frame, up = frame_of(imu), self.up.get(imu.name, 0.0)
            self._attitude(imu, "orientation", frame, up < -LEAST_UP or (abs(up) <= LEAST_UP and says_down(frame)))

    def _same_frame(self, imu: Topic) -> None:
        ours, theirs = frame_of(self.main), frame_of(imu)
        if self.axes.told(theirs):
            return
        line = f"the axes of {ours} (magnetometer) are taken as those of {theirs} (IMU)"
        if ours and theirs and ours != theirs and line not in self.notes:
            self.notes.append(line)

    def _attitude(self, topic: Topic, path: str, frame: str, north_east_down: bool = False) -> None:
        """Take a quaternion x y z w of a frame as w x y z of the body."""
        q = self.axes.attitude(frame, _unit(vector_of(topic, path, "wxyz")), north_east_down)
        self.add(topic, vector_columns("attitude", q), SLERP, path)
        line = (
            f"attitude from {topic.name}: if its heading comes from this magnetometer, a fit to it is circular in yaw"
        )
        self.notes.append(line)

    def _pose(self) -> None:
        """Take the position from the best pose, else from fixes; the attitude too where no IMU gives it."""
        kinds = list(roles.POSES)
        poses = [topic for topic in self.of_kind(*kinds) if not roles.is_planned(topic)]
        best = max(poses, key=lambda topic: (-kinds.index(topic.kind), len(topic.received_ns)), default=None)
        if best is None:
            self._position_of_fixes()
            return
        path = roles.POSES[best.kind]
        self.add(best, vector_columns("position", vector_of(best, f"{path}.position")), None, f"{path}.position")
        has_attitude = any("att_qw" in stream.columns for stream in self.streams.values())
        if not has_attitude and has_vector_of_pose(best, path):
            frames = best.columns.get("child_frame_id")
            self._attitude(best, f"{path}.orientation", self.axes.body if frames is None else str(frames[0]))

    def _fixes(self) -> Topic | None:
        return max(self.of_kind(roles.FIX), key=lambda topic: int(has_fix(topic).sum()), default=None)

    def _place(self) -> tuple[float, ...] | None:
        """Return the median of the fixes, and take them as channels."""
        topic = self._fixes()
        if topic is None or not has_fix(topic).any():
            return None
        fixes = topic.rows(has_fix(topic))
        place = fixes.vector("latitude", "longitude", "altitude")
        columns: Columns = dict(zip((LATITUDE, LONGITUDE, ALTITUDE), place.T, strict=True))
        self.add(fixes, columns, None, "latitude", "longitude", "altitude")
        latitude, longitude, altitude = place.T
        known = np.isfinite(altitude)
        return median_place(latitude, longitude, float(np.median(altitude[known])) if known.any() else 0.0)

    def _position_of_fixes(self) -> None:
        """Take the position from fixes: east, north, up of the first fix on a sphere."""
        topic = self._fixes()
        if topic is None or not has_fix(topic).any():
            return
        fixes = topic.rows(has_fix(topic))
        latitude, longitude, altitude = fixes.vector("latitude", "longitude", "altitude").T
        enu = np.column_stack([*east_north_m(latitude, longitude), altitude - altitude[0]])
        self.add(fixes, vector_columns("position", enu))
        self.notes.append(f"position from {topic.name}, relative to the first fix")

    def _temperature(self) -> None:
        topic = nearest(self.of_kind(roles.THERMOMETER), self.main)
        if topic is not None:
            self.add(topic, {TEMPERATURE: topic.columns["temperature"]}, None, "temperature")
            self.notes.append(f"temperature from {topic.name}")

    def _battery(self) -> None:
        """Take voltage and current of the first battery; ROS counts a discharge negative."""
        topic = next(iter(self.of_kind(roles.BATTERY)), None)
        if topic is None:
            return
        self.add(topic, {BATTERY_VOLTAGE: topic.columns["voltage"]}, None, "voltage")
        if self.of_kind(*roles.ESCS) or not np.isfinite(topic.columns["current"]).any():
            return
        current = topic.columns["current"]
        positive = float(np.mean(current[np.isfinite(current)] > 0)) > MOSTLY
        self.add(topic, {current_name(1): current if positive else -current}, None, "current")
        sign = "; it is positive throughout: taken as the discharge" if positive else ""
        self.notes.append(f"current_1_A is the battery's current, of {topic.name}{sign}")

    def _motors(self) -> None:
        """Take the currents of speed controllers, where logged."""
        for topic in self.of_kind(*roles.ESCS)[:1]:
            path = roles.ESCS[topic.kind]
            found = [name for name in topic.columns if name.startswith(path) and name.endswith("].current")]
            self.add(topic, {current_name(k): topic.columns[name] for k, name in enumerate(found, 1)}, None, *found)

    def _autopilot(self) -> None:
        """Take mode, arming and throttle from MAVROS."""
        held = dict.fromkeys(("phase", ARMED), Interpolation.HELD)
        for topic in self.of_kind(roles.STATE)[:1]:
            state = {"phase": topic.columns["mode"], ARMED: topic.columns["armed"]}
            self.add(topic, state, held, "mode", "armed")
        for topic in self.of_kind(*roles.HUD)[:1]:
            self.add(topic, {THROTTLE: topic.columns["throttle"]}, None, "throttle")

    def _channels(self) -> None:
        """Take every other number as a channel, but for covariances."""
        for topic in self.bag.topics.values():
            used = self.used.get(topic.name, ())
            columns = {
                f"{topic.name}.{path}": values
                for path, values in topic.columns.items()
                if values.dtype.kind == "f" and "covariance" not in path and not path.startswith(used or "\0")
            }
            if columns:
                self.streams[topic.name] = Stream(self.clock.times_s(topic), columns)


def _unit(q: Array) -> Array:
    """Return quaternions (n, 4) of length 1; NaN for one without length, which is no attitude."""
    length = np.linalg.norm(q, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.where((length > 0)[:, None], q / length[:, None], np.nan))


def has_vector_of_pose(topic: Topic, path: str) -> bool:
    """Return whether a pose has an attitude: some quaternion has a length."""
    q = vector_of(topic, f"{path}.orientation", "wxyz")
    return bool(np.any(np.nan_to_num(q) != 0))


def magnetometers_of(bag: Bag) -> dict[str, Topic]:
    """Return the magnetometers by topic, by topic and frame where a topic has several frames; the fastest first."""
    topics = [topic for topic in bag.topics.values() if topic.kind == roles.MAGNETIC]
    topics = topics or [topic for topic in bag.topics.values() if roles.is_field_vector(topic.name, topic.kind)]
    own = [topic for topic in bag.topics.values() if roles.is_own(topic.kind) and f"{VECTOR}.x" in topic.columns]
    topics = topics or own
    found = {}
    for topic in topics:
        frames = sorted(set(topic.frames.tolist()))
        for frame in frames[:9]:
            name = f"{topic.name} {frame}" if len(frames) > 1 else topic.name
            found[name] = topic.rows(topic.frames == frame)
    return dict(sorted(found.items(), key=lambda item: -len(item[1].received_ns)))
