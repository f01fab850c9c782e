"""A link at the name of a file that is being written leads nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from recordings.files import NO_LINK, PART, write_text
from scenarios.errors import InputError


@pytest.mark.skipif(not NO_LINK, reason="this system has no flag against links")
def test_a_link_at_the_part_files_name_is_not_followed(tmp_path: Path) -> None:
    other = tmp_path / "other.txt"
    other.write_text("theirs")
    (tmp_path / f"out.json{PART}").symlink_to(other)
    with pytest.raises(InputError):
        write_text(tmp_path / "out.json", "ours")
    assert other.read_text() == "theirs"
