"""Time and memory of a diagnosis: 20 minutes at 50 Hz, and ten hours at 10 Hz, with every channel.

    python -m benchmarks.diagnosing LENGTH_S EVERY

prints CPU seconds and peak memory in MB of one diagnosis in a process of its own.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from benchmarks.diagnosis.wide.courses import circling
from benchmarks.diagnosis.wide.making import hidden_along
from benchmarks.measure import Row, cpu_s
from diagnosis.workflow import diagnose

HIDDEN, STRENGTH = "motor_current", 0.5
MINUTES, HOURS = (1200.0, 1), (36_000.0, 5)
"""Length in s, and of how many samples at 50 Hz one is taken."""
SMALL = (120.0, 5)
"""Length with which a test runs the benchmark."""
FORGET_PEAK = "5"
"""What Linux takes for starting the peak of a process' memory anew."""
MOST_CPU_S, MOST_MB = 6.0, 1500.0


def rows(small: bool = False) -> Iterator[Row]:
    """Yield the CPU seconds of the short log and the peak memory of the long log."""
    seconds, _ = _measured(*(SMALL if small else MINUTES))
    yield Row("diagnose 20 min at 50 Hz, CPU s", seconds, MOST_CPU_S, False, "60,000 samples, one hidden effect")
    _, peak_MB = _measured(*(SMALL if small else HOURS))
    yield Row("diagnose 10 h at 10 Hz, peak MB", peak_MB, MOST_MB, False, "360,000 samples, one hidden effect")


def _measured(length_s: float, every: int) -> tuple[float, float]:
    call = [sys.executable, "-m", "benchmarks.diagnosing", str(length_s), str(every)]
    seconds, peak_MB = subprocess.run(call, check=True, capture_output=True, text=True).stdout.split()
    return float(seconds), float(peak_MB)


def main(length_s: float, every: int) -> None:
    """One diagnosis in this process; its memory is counted from when the recording is made, which takes more."""
    made = hidden_along(circling(length_s, every), HIDDEN, STRENGTH)
    Path("/proc/self/clear_refs").write_text(FORGET_PEAK)
    seconds = cpu_s(lambda: diagnose(made.recording, made.model))
    (peak_kB,) = re.findall(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    print(seconds, int(peak_kB) / 1000)


if __name__ == "__main__":
    main(float(sys.argv[1]), int(sys.argv[2]))
