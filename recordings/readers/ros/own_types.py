"""Magnetometers in messages of a project's own types: three numbers x, y, z whose names or topic tell a field."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from recordings.readers.ros.bag import Topic
from recordings.readers.text.sensors import BEST, kind_of, letters

NO_FIELD = re.compile(r"bias|offset|ofs|covarian|varian|std|scale|gain|hard|soft|innov|expected|earth|target|setpoint")
"""What a field's path contains that is no measured magnetometer."""
OF_FIELD = re.compile(r"(^|[/_])(mag|compass)", re.IGNORECASE)
"""In the last part of a topic that is a magnetometer's."""
PX4, PX4_FRAME = "px4_msgs/", "px4_frd"
"""Types of PX4's bridge, whose bodies are forward, right, down, and the frame that says so."""
VECTOR, AXES = "vector", ("x", "y", "z")
"""The path under which the vector of a type of one's own is kept, and its parts."""
_PART = re.compile(r"(?P<stem>.*?)[._]?(?:(?P<letter>[xyzXYZ])|\[(?P<place>[012])\])$")


def own_field(topic: str, paths: Iterable[str]) -> tuple[str, ...]:
    """Return the paths of x, y and z of a magnetometer among the numbers of a message; () for none.

    A vector whose last name tells a magnetometer, raw values first; else the only vector of a topic that tells one.
    """
    vectors = {stem: parts for stem, parts in _vectors(paths).items() if not NO_FIELD.search(stem.lower())}
    named = [stem for stem in vectors if kind_of(stem.rsplit(".", 1)[-1]) == "mag"]
    of_topic = bool(OF_FIELD.search(topic.rstrip("/").rsplit("/", 1)[-1])) and len(vectors) == 1
    found = named or (list(vectors) if of_topic else [])
    return vectors[min(found, key=lambda stem: not re.search(BEST, letters(stem)))] if found else ()


def with_own_fields(topics: Mapping[str, Topic], types: Callable[[str], bool]) -> dict[str, Topic]:
    """Return topics, those of a project's own types with their magnetometer under `vector.x` and so on.

    types : whether a type is a project's own.
    """
    own = {name: own_field(name, one.columns) for name, one in topics.items() if types(one.kind)}
    return {name: with_vector(one, own[name]) if own.get(name) else one for name, one in topics.items()}


def _vectors(paths: Iterable[str]) -> Mapping[str, tuple[str, ...]]:
    """Return the paths of x, y, z by what stands before these letters, or before [0], [1], [2]."""
    found: dict[str, dict[str, str]] = {}
    for path in paths:
        part = _PART.fullmatch(path)
        if part:
            axis = part["letter"].lower() if part["letter"] else AXES[int(part["place"])]
            found.setdefault(part["stem"], {}).setdefault(axis, path)
    whole = {stem: parts for stem, parts in found.items() if set(parts) == set(AXES)}
    return {stem: tuple(parts[axis] for axis in AXES) for stem, parts in whole.items()}


def with_vector(topic: Topic, paths: tuple[str, ...]) -> Topic:
    """Return a topic whose magnetometer stands under `vector.x` and so on; PX4's in a frame that says its axes."""
    new = dict(zip(paths, (f"{VECTOR}.{axis}" for axis in AXES), strict=True))
    columns = {new.get(path, path): values for path, values in topic.columns.items()}
    frames = np.full(len(topic.frames), PX4_FRAME) if topic.kind.startswith(PX4) else topic.frames
    return Topic(topic.name, topic.kind, topic.received_ns, topic.stamp_ns, frames, columns)
