"""Compressed script elements: the page holds text as gzip in base64, and the browser unpacks it (``page.js``)."""

from __future__ import annotations

import base64
import gzip
from pathlib import Path

from markupsafe import Markup

PLOTLY = Path(__file__).parent.parent / "libraries" / "plotly-basic.min.js.gz"
"""plotly.js with the traces that `reports.plots.interactive` writes; README.md beside it names version and licence."""


def packed(text: str) -> Markup:
    """Return a script element that holds a text, in a fifth to a third of its size."""
    return _element(gzip.compress(text.encode(), mtime=0), "")


def packed_plotly() -> Markup:
    """Return the script element that holds plotly.js."""
    return _element(PLOTLY.read_bytes(), ' id="plotly"')


def _element(compressed: bytes, attributes: str) -> Markup:
    content = base64.b64encode(compressed).decode()
    return Markup(f'<script type="application/gzip"{attributes}>{content}</script>')
