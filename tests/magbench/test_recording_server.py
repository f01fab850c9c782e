"""The server behind `magbench show --web`: the recording for the viewer's page, and the way there."""

from __future__ import annotations

import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

from magbench.recording_server import RecordingServer

CONTENT = bytes(range(256)) * 1000
VIEWER = "http://127.0.0.1:1"


@pytest.fixture
def server(tmp_path: Path) -> Iterator[RecordingServer]:
    file = tmp_path / "a recording.rrd"
    file.write_bytes(CONTENT)
    with RecordingServer(file, VIEWER) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server
        server.shutdown()


class Followed(Exception):
    """Where an address leads."""


class Stay(urllib.request.HTTPRedirectHandler):
    """Tells where an address leads, and does not go there."""

    def redirect_request(self, *args: object) -> None:
        raise Followed(args[-1])


def test_the_viewer_gets_the_whole_recording_and_no_other_page_may_read(server: RecordingServer) -> None:
    with urllib.request.urlopen(server.address + "/recording.rrd") as answer:
        assert answer.read() == CONTENT
        assert answer.headers["Access-Control-Allow-Origin"] == VIEWER


@pytest.mark.parametrize("path", ["", "/", "/index.html"])
def test_the_bare_address_leads_to_the_viewer_with_the_recording(server: RecordingServer, path: str) -> None:
    with pytest.raises(Followed) as led:
        urllib.request.build_opener(Stay).open(server.address + path)
    to = urlsplit(str(led.value))
    assert f"{to.scheme}://{to.netloc}" == VIEWER
    assert parse_qs(to.query) == {"url": [server.address + "/recording.rrd"]}


def test_only_this_machine_is_served(server: RecordingServer) -> None:
    assert server.server_address[0] == "127.0.0.1"
