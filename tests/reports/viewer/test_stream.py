"""A recording for the viewer that cannot be made is one line, never the end of the process."""

from __future__ import annotations

import time

import pytest
import rerun.blueprint as rrb

from reports.viewer.rrd_file import viewer_program
from reports.viewer.stream import recording_bytes
from scenarios.errors import InputError


def test_a_clock_before_1970_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rerun's library ends the process by SIGABRT at such a clock."""
    assert recording_bytes("run", "title", rrb.Blueprint(), [])
    monkeypatch.setattr(time, "time", lambda: -1.0)
    with pytest.raises(InputError, match="before 1970: no recording for the viewer"):
        recording_bytes("run", "title", rrb.Blueprint(), [])


def test_a_viewer_that_was_removed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The program is 280 MB, which a machine that only writes recordings can do without."""
    assert viewer_program().is_file()
    monkeypatch.setattr("reports.viewer.rrd_file.find_spec", lambda name: None)
    with pytest.raises(InputError, match="not installed"):
        viewer_program()
