"""The entry point of the program: few imports, so that a signal ends even the start with one line."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from magbench.refusal import refuse

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What Ctrl-C, `kill`, batch systems and containers, and a closed terminal send."""

RESUMING = ("simulate", "run", "compare")
"""Commands that use again what their output directory holds."""


class Terminated(BaseException):
    """A signal of ENDING arrived: every context exits, and no half-written file remains."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit status, 128 plus the number of the signal after a signal."""
    try:
        with _ending_signals_raise():
            from magbench.app import call

            return call(arguments)
    except Terminated as ended:
        return _interrupted(ended.args[0], arguments)
    except KeyboardInterrupt:
        return _interrupted(signal.SIGINT, arguments)


def _interrupted(number: int, arguments: Sequence[str] | None = None) -> int:
    """Print whether the same command resumes or starts anew."""
    words = sys.argv[1:] if arguments is None else arguments
    what_next = "resumes" if words and words[0] in RESUMING else "starts anew"
    return refuse(f"interrupted; the same command {what_next}", 128 + number)


@contextmanager
def _ending_signals_raise() -> Iterator[None]:
    """Within, the signals of ENDING raise Terminated; ignored signals, as under nohup, stay ignored."""
    before = {number: signal.getsignal(number) for number in ENDING}
    heard = [number for number, handler in before.items() if handler != signal.SIG_IGN]
    try:
        for number in heard:
            signal.signal(number, _end)
        yield
    finally:
        for number in heard:
            signal.signal(number, before[number] or signal.SIG_DFL)


def _end(number: int, frame: FrameType | None) -> None:
    if _importing(frame):  # an import can swallow an exception, or make another of it; it leaves nothing half-written
        os._exit(_interrupted(number))
    raise Terminated(number)


def _importing(frame: FrameType | None) -> bool:
    while frame is not None and "importlib._bootstrap" not in frame.f_code.co_filename:
        frame = frame.f_back
    return frame is not None


if __name__ == "__main__":
    sys.exit(main())
