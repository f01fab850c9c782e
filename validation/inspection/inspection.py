"""Inspection of a file: findings of every section, and data for the pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from calib import Reference
from recordings.manifest import is_dataset, read_manifest
from recordings.reading import Reading
from scenarios.plain import json_ready
from validation.calibrating.reference import stated_reference, told_field
from validation.inspection.finding import Finding
from validation.inspection.frames import frame_findings
from validation.inspection.log import RawLog, read_log, series_of
from validation.inspection.motion import motion_findings
from validation.inspection.sensor_data import SensorData, derive, without_faults
from validation.inspection.spectra import noise_findings
from validation.inspection.sufficiency import calibration_findings
from validation.inspection.timing import in_seconds, timing_findings
from validation.inspection.units import unit_findings
from validation.inspection.values import missing_finding, value_findings
from validation.screening.screening import screen
from validation.text import counted

SECTION = "file"


@dataclass(frozen=True, repr=False)
class Inspection:
    """Findings on a recording, and a `SensorData` for each magnetometer."""

    log: RawLog
    findings: tuple[Finding, ...]
    sensors: tuple[SensorData, ...]

    def __repr__(self) -> str:
        """Return the headline and all warnings."""
        return "\n".join([headline(self), *(finding.text for finding in self.warnings)])

    @property
    def warnings(self) -> list[Finding]:
        """Return findings to mend or to know before results are computed from the recording."""
        return [finding for finding in self.findings if finding.level == "warning"]


def inspect_file(
    path: Path,
    *,
    maps: Sequence[str] = (),
    reading: Reading | None = None,
    run: int = 0,
    reference: Reference | None = None,
) -> Inspection:
    """Inspect a run, a dataset directory or a measured log.

    reading : how the log is read, by default as kept beside it; maps : further `--map` texts.
    reference : the field there, see `inspect_log`. Faults of the values are findings, not errors.
    Raises InputError for a file that cannot be read or has no columns of time and field.
    """
    found = inspect_log(read_log(path, maps=maps, reading=reading, run=run), reference)
    runs = read_manifest(path).runs if is_dataset(path) else 1
    return found if runs == 1 else replace(found, findings=(_one_of(runs, run), *found.findings))


def inspect_log(log: RawLog, reference: Reference | None = None) -> Inspection:
    """Inspect a log that has been read.

    Without a reference the field is that of the place and date in the log, else its median strength.
    """
    reference = _told(log) if reference is None else reference
    log, unit = in_seconds(log)
    findings = [_taken(log), *_read(log), *unit, *timing_findings(log), missing_finding(log)]
    sensors = []
    screened = None if log.recording is None else screen(log.recording, reference)
    for sensor in log.sensors:
        raw = series_of(log, sensor)
        judged = screened if screened is None or sensor is None else screened.of_sensor(sensor - 1)
        as_read = derive(raw, sensor, judged, reference)
        data = without_faults(as_read)
        sensors.append(data)
        findings += [*value_findings(as_read), *unit_findings(log, data, raw)]
        if sensor == log.sensors[0]:
            findings += frame_findings(data, log.frame, reference)
        findings += [*motion_findings(data), *calibration_findings(data), *noise_findings(data)]
    return Inspection(log, tuple(findings), tuple(sensors))


def _told(log: RawLog) -> Reference | None:
    """Return the field at the place and date that the log tells; None where it tells only one of them, or neither."""
    origin = log.origin
    if origin.place is None or origin.date is None:
        return None
    return stated_reference(str(log.path), *told_field(None, None, origin))


def _one_of(runs: int, run: int) -> Finding:
    """Return a note on the run of a dataset that was inspected."""
    text = f"The dataset has {runs} runs, and this is run {run}; select another with --run."
    return Finding(SECTION, "runs", runs, "", text, "note")


def _taken(log: RawLog) -> Finding:
    """Return whether the other commands accept the file."""
    if not log.refusal:
        return Finding(SECTION, "accepted", True, "", "`magbench calibrate` accepts the file.")
    return Finding(SECTION, "accepted", False, "", f"`magbench calibrate` refuses the file: {log.refusal}", "warning")


def _read(log: RawLog) -> list[Finding]:
    """Return how names, units and rows were read, a finding a note."""
    return [Finding(SECTION, "reading", note, "", _sentence(note), "note") for note in log.origin.notes]


def _sentence(note: str) -> str:
    """Return a note as a sentence; a name of a column, as current_1_A, keeps its first letter."""
    first = note.split(maxsplit=1)[0]
    return (note if "_" in first else note[0].upper() + note[1:]) + "."


def summary(inspection: Inspection) -> dict[str, Any]:
    """Return the JSON of `inspect`: file, samples, sensors, warnings and findings; null for values not finite."""
    return {
        "file": str(inspection.log.path),
        "samples": len(inspection.log),
        "sensors": len(inspection.sensors),
        "warnings": [finding.text for finding in inspection.warnings],
        "findings": [json_ready(asdict(finding)) for finding in inspection.findings],
    }


def headline(inspection: Inspection) -> str:
    """Return one sentence with the number of warnings."""
    count = len(inspection.warnings)
    return f"{inspection.log.path.name}: {counted(count, 'warning')}" + ("." if count else ", nothing to mend.")
