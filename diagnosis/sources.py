"""Sources of a diagnosis: recordings before they are read, with their names and own references."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Self

from calib.reference import Reference
from recordings import Recording, read_recording
from recordings.importer import sensors_in
from recordings.manifest import file_of, is_dataset, read_manifest
from recordings.reading import Reading
from scenarios.errors import InputError
from validation.calibrating.reference import reference_of

Stated = Callable[[float | None, Sequence[float] | None, str], Reference]
"""(strength in nT, field vector in nT, further remedy) -> the stated reference, else the source's own."""


@dataclass(frozen=True)
class Source:
    """A recording before it is read.

    name : unique among the sources. place : file, for error messages. read, reference : see `Stated`.
    run : of a dataset. sensor, reference_sensor : of an array, counted from 1.
    """

    name: str
    place: Path
    read: Callable[[], Recording]
    reference: Stated
    run: int = 0
    sensor: int | None = None
    reference_sensor: int | None = None

    @classmethod
    def of_file(cls, file: Path, name: str, run: int = 0, reading: Reading | None = None) -> Self:
        """The source of one run's file or measured log."""
        return cls(name, file, partial(read_recording, file, reading=reading), partial(reference_of, file), run)


def file_sources(
    paths: Sequence[Path],
    run: int | None,
    sensor: int | None = None,
    reading: Reading | None = None,
    reference_sensor: int | None = None,
) -> tuple[Source, ...]:
    """The sources in files and dataset directories; of a dataset all runs unless `run` selects one.

    Of a single recording by an array every sensor is a source, as `name@1` and so on, unless `sensor` selects one.
    Raises InputError for a run that does not exist, and for several recordings by an array without a sensor.
    """
    found: list[Source] = []
    for path in paths:
        runs = range(read_manifest(path).runs) if is_dataset(path) and run is None else (run or 0,)
        suffix = " run {}" if len(runs) > 1 else ""
        stem = path.resolve().name if path.is_dir() else path.stem
        found += [Source.of_file(file_of(path, k), stem + suffix.format(k), k, reading) for k in runs]
    separate = _by_sensor(_distinct(found), sensor, reading, reference_sensor)
    return tuple(replace(source, reference_sensor=reference_sensor) for source in separate)


def _by_sensor(
    found: Sequence[Source], sensor: int | None, reading: Reading | None, reference_sensor: int | None
) -> Sequence[Source]:
    """The selected sensor of each source; else all sensors of a single array but the reference."""
    if sensor is not None:
        return [replace(source, sensor=sensor) for source in found]
    arrays = [sensors_in(source.place, reading) for source in found]
    if len(found) == 1 and len(arrays[0]) > 1:
        (whole,) = found
        return [replace(whole, name=f"{whole.name}@{k}", sensor=k) for k in arrays[0] if k != reference_sensor]
    for source, sensors in zip(found, arrays, strict=True):
        if len(sensors) > 1:
            what = f"an array of {len(sensors)} sensors among several recordings"
            raise InputError(what, where=str(source.place), do="select one with --sensor, or give one recording")
    return found


def _distinct(found: Sequence[Source]) -> list[Source]:
    """The sources with their folder before equal names, and a number after names that are still equal."""
    count = Counter(source.name for source in found)
    names = [f"{s.place.resolve().parent.name} {s.name}" if count[s.name] > 1 else s.name for s in found]
    again = Counter(names)
    unique = [f"{name} {i + 1}" if again[name] > 1 else name for i, name in enumerate(names)]
    return [replace(source, name=name) for source, name in zip(found, unique, strict=True)]


def of_one_array(found: Sequence[Source]) -> bool:
    """Whether the sources are the sensors of one recording."""
    return len({s.sensor for s in found}) == len(found) > 1 == len({(s.place, s.run) for s in found})


def check_single(found: Sequence[Source], option: str) -> None:
    """InputError where an option for one recording is given beside several, or beside all sensors of an array."""
    if len(found) > 1:
        kind, do = ("sensor", "select one with --sensor") if of_one_array(found) else ("recording", "give one, or all")
        raise InputError(f"needs one {kind}, and there are {len(found)}", where=option, do=do)
