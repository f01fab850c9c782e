"""Sensor Logger's JSON, exported or pushed over HTTP, as the tables that its CSV export would hold."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from recordings.readers.packages import SUFFIX, TablePackage
from scenarios.errors import InputError
from scenarios.files import parsed_json, read_text

MOST_JSON_BYTES = 40_000_000
"""Bytes of a JSON file that are read: an hour of six sensors at 20 Hz; ten times as much memory."""
EXPORTED, PUSHED = (b'"sensor"', b'"seconds_elapsed"'), (b'"payload"', b'"values"')
"""What the beginning of an export, and of a pushed message, holds."""
STAMP, ELAPSED = "time", "seconds_elapsed"
MOST_SENSORS = 100
Row = Mapping[str, Any]
_DO = "export it as CSV"


def is_json_log(head: bytes) -> bool:
    """Return whether the first bytes of a file are Sensor Logger's JSON."""
    start = head.lstrip()[:1] in (b"[", b"{")
    return start and any(all(word in head for word in words) for words in (EXPORTED, PUSHED))


def json_package(path: Path) -> TablePackage:
    """Return the rows of each sensor as a text table; InputError for JSON of another form, and for too long a file."""
    if path.stat().st_size > MOST_JSON_BYTES:
        raise InputError(f"is longer than {MOST_JSON_BYTES // 10**6} MB of JSON", where=str(path), do=_DO)
    by_sensor: dict[str, list[Row]] = {}
    for sensor, row in _rows(parsed_json(read_text(path, _DO), str(path), _DO)):
        by_sensor.setdefault(sensor, []).append(row)
        if len(by_sensor) > MOST_SENSORS:
            raise InputError(f"holds more than {MOST_SENSORS} sensors", where=str(path), do=_DO)
    start = _start(by_sensor)
    tables = {f"{sensor}{SUFFIX}": _text(rows, start).encode() for sensor, rows in by_sensor.items()}
    return TablePackage(path, tuple(tables), sum(map(len, tables.values())), tables.__getitem__)


def _rows(whole: Any) -> Iterator[tuple[str, Row]]:
    """Yield the sensor and the values of each row; of a pushed message the values stand a level deeper."""
    listed = whole.get("payload") if isinstance(whole, dict) else whole
    for one in listed if isinstance(listed, list) else ():
        if isinstance(one, dict):
            name, values = one.get("sensor", one.get("name")), one.get("values")
            row = {**one, **(values if isinstance(values, dict) else {})}
            if isinstance(name, str) and name.replace(" ", "").isalnum():
                yield name, {key: value for key, value in row.items() if key not in ("sensor", "name", "values")}


def _start(by_sensor: Mapping[str, list[Row]]) -> float:
    """Return the earliest stamp in ns since 1970, 0 without any."""
    stamps = (_number(row.get(STAMP)) for rows in by_sensor.values() for row in rows[:1])
    return min((stamp for stamp in stamps if stamp > 0), default=0.0)


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return 0.0


def _text(rows: list[Row], start: float) -> str:
    """Return rows as a table, with seconds since the start where they hold stamps alone."""
    timed = all(ELAPSED in row for row in rows[:1])
    names = [*rows[0], *([] if timed else [ELAPSED])]
    text = io.StringIO()
    writer = csv.DictWriter(text, names, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow(row if timed else {**row, ELAPSED: f"{(_number(row.get(STAMP)) - start) / 1e9:.6f}"})
    return text.getvalue()
