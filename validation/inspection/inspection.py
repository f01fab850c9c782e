"""A file inspected: every section's findings, and what the pictures are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from recordings.manifest import read_manifest
from scenarios.plain import json_ready
from validation.inspection.finding import Finding
from validation.inspection.frames import frame_findings
from validation.inspection.log import RawLog, read_log, series_of
from validation.inspection.motion import motion_findings
from validation.inspection.sensor_data import Look, look_at
from validation.inspection.spectra import noise_findings
from validation.inspection.sufficiency import calibration_findings
from validation.inspection.timing import in_seconds, timing_findings
from validation.inspection.units import unit_findings
from validation.inspection.values import missing_finding, value_findings
from validation.text import counted

SECTION = "file"


@dataclass(frozen=True, repr=False)
class Inspection:
    """What a first look at a recording found, and one `Look` for each magnetometer."""

    log: RawLog
    findings: tuple[Finding, ...]
    looks: tuple[Look, ...]

    def __repr__(self) -> str:
        """How much there is to mend, and what."""
        return "\n".join([headline(self), *(finding.text for finding in self.warnings)])

    @property
    def warnings(self) -> list[Finding]:
        """What should be mended or known before anything is computed from the recording."""
        return [finding for finding in self.findings if finding.level == "warning"]


def inspect_file(path: Path, *, maps: Sequence[str] = (), run: int = 0) -> Inspection:
    """Look at a run, a dataset directory or a measured log, and tell what is in it and what is odd.

    maps : `--map` texts, see `recordings.importer.read_columns`. Faults of the values are findings, not errors.
    Raises InputError for a file without columns of time and field, or that cannot be read at all.
    """
    found, runs = inspect_log(read_log(path, maps=maps, run=run)), read_manifest(path).runs if path.is_dir() else 1
    return found if runs == 1 else replace(found, findings=(_one_of(runs, run), *found.findings))


def inspect_log(log: RawLog) -> Inspection:
    """The same of a log that has been read."""
    log, unit = in_seconds(log)
    findings = [_taken(log), *unit, *timing_findings(log), missing_finding(log)]
    looks = []
    for sensor in log.sensors:
        raw = series_of(log, sensor)
        look = look_at(raw, sensor)
        looks.append(look)
        findings += [*value_findings(look), *unit_findings(log, look, raw)]
        if sensor == log.sensors[0]:
            findings += frame_findings(look)
        findings += [*motion_findings(look), *calibration_findings(look), *noise_findings(look)]
    return Inspection(log, tuple(findings), tuple(looks))


def _one_of(runs: int, run: int) -> Finding:
    """Which run of a dataset was looked at."""
    text = f"The dataset has {runs:,} runs, and this is run {run}: --run looks at another."
    return Finding(SECTION, "runs", runs, "", text, "note")


def _taken(log: RawLog) -> Finding:
    """Whether the other commands take the file as it is."""
    if not log.refusal:
        return Finding(SECTION, "accepted", True, "", "`magbench calibrate` takes the file as it is.")
    return Finding(SECTION, "accepted", False, "", f"`magbench calibrate` refuses the file: {log.refusal}", "warning")


def summary(inspection: Inspection) -> dict[str, Any]:
    """The JSON of `inspect`: file, samples, sensors, warnings, and the findings; what is not finite becomes null."""
    return {
        "file": str(inspection.log.path),
        "samples": len(inspection.log),
        "sensors": len(inspection.looks),
        "warnings": [finding.text for finding in inspection.warnings],
        "findings": [json_ready(asdict(finding)) for finding in inspection.findings],
    }


def headline(inspection: Inspection) -> str:
    """One sentence: how much there is to mend."""
    count = len(inspection.warnings)
    return f"{inspection.log.path.name}: {counted(count, 'warning')}" + ("." if count else ", nothing to mend.")
