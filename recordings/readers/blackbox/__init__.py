"""Blackbox logs of Betaflight, INAV and their relatives: `.bbl`, `.bfl`, often several logs in a file."""

from __future__ import annotations

import mmap
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from recordings.files import system_errors_about
from recordings.readers.base import FileContents, FileFormat, Wanted
from recordings.readers.blackbox.frames import decoded_log
from recordings.readers.blackbox.header import START
from recordings.readers.blackbox.log import BlackboxLog
from scenarios.errors import InputError

__all__ = ["BLACKBOX"]

MOST_BYTES = 400_000_000
"""Bytes of a log that are read; what lies behind is left out, as of a log that is cut off."""
MOST_LOGS = 1000
"""Logs of a file that are looked for."""


def _recognises(path: Path, head: bytes) -> bool:
    return START in head


def _read(path: Path, wanted: Wanted, stream: str | None) -> FileContents:
    """Read the longest log of a file, or the log whose number is `stream`, counted from 1."""
    with (
        system_errors_about(path, "check the permissions"),
        path.open("rb") as file,
        mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data,
    ):
        spans = _spans(data)
        number = _chosen(path, spans, stream)
        first, last = spans[number - 1]
        log = data[first : min(last, first + MOST_BYTES)]
    found = BlackboxLog(str(number), decoded_log(path, log), wanted).vehicle_log()
    if len(spans) > 1:
        rest = ", ".join(str(k) for k in range(1, len(spans) + 1) if k != number)
        which = "the longest" if stream is None else "as stated"
        line = f"log {number} of {len(spans)} in the file is read, {which} (--stream reads another: {rest})"
        found = replace(found, notes=(line, *found.notes))
    return found.contents(path, wanted, None)


def _spans(data: mmap.mmap) -> list[tuple[int, int]]:
    """Return the first byte and the end of each log of a file."""
    starts = [data.find(START)]
    while starts[-1] >= 0 and len(starts) <= MOST_LOGS:
        starts.append(data.find(START, starts[-1] + len(START)))
    return list(pairwise([*(start for start in starts if start >= 0), len(data)]))


def _chosen(path: Path, spans: list[tuple[int, int]], stream: str | None) -> int:
    """Return the number of the log that is read."""
    numbers = range(1, len(spans) + 1)
    if stream is None:
        return max(numbers, key=lambda number: spans[number - 1][1] - spans[number - 1][0])
    if stream not in map(str, numbers):
        what, do = f"there is no log {stream!r}", f"choose among 1 to {len(spans)}"
        raise InputError(what, where=f"{path}: --stream", do=do)
    return int(stream)


BLACKBOX = FileFormat(
    name="blackbox",
    suffixes=(".bbl", ".bfl"),
    summary="a blackbox log of Betaflight or INAV",
    remark="counts; zero and alignment are not in the log and stay in the offset",
    recognises=_recognises,
    read=_read,
)
