"""Web server of one recording, for the rerun viewer in a browser on this machine."""

from __future__ import annotations

import shutil
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import quote

HOST = "127.0.0.1"
FILE = "/recording.rrd"


class RecordingServer(ThreadingHTTPServer):
    """Serves a recording to a viewer's page alone; every other address leads to that page.

    file : the recording. viewer : address of the viewer's page.
    """

    daemon_threads = True

    def __init__(self, file: Path, viewer: str) -> None:
        super().__init__((HOST, 0), _Handler)
        self.file, self.viewer = file, viewer
        self.address = f"http://{HOST}:{self.server_port}"

    @property
    def page(self) -> str:
        """Address of the viewer's page with the recording open."""
        return f"{self.viewer}/?url={quote(self.address + FILE, safe='')}"


class _Handler(BaseHTTPRequestHandler):
    server: RecordingServer

    def do_GET(self) -> None:
        """Send the recording, or the way to the viewer's page."""
        if self.path != FILE:
            self.send_response(302)
            self.send_header("Location", self.server.page)
            self.end_headers()
            return
        with self.server.file.open("rb") as file:
            self.send_response(200)
            self.send_header("Access-Control-Allow-Origin", self.server.viewer)
            self.send_header("Content-Type", "application/octet-stream")
            self.send_header("Content-Length", str(self.server.file.stat().st_size))
            self.end_headers()
            shutil.copyfileobj(file, self.wfile)

    def log_message(self, format: str, *args: object) -> None:
        """Keep the terminal to the one line of the command."""
