"""Pictures of pages: which become SVG, and that a picture drawn twice is laid out once."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
from PIL import Image

from reports.plots import style
from reports.plots.style import DPI, SVG_MARKS, WIDTH_IN, data_url, panels, styled


def test_a_line_becomes_svg() -> None:
    figure, axis = panels(2.0)
    axis.plot([0.0, 1.0])
    assert data_url(figure).startswith("data:image/svg+xml;base64,")


def test_a_scatter_of_many_marks_becomes_png_without_an_svg(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(style, "_svg", pytest.fail)
    figure, axis = panels(2.0)
    axis.scatter(*np.random.default_rng(0).normal(size=(2, SVG_MARKS + 1)))
    kind, data = data_url(figure).split(",")
    assert kind == "data:image/png;base64"
    assert Image.open(io.BytesIO(base64.b64decode(data))).size == (round(DPI * WIDTH_IN), round(DPI * 2.0))


def test_a_picture_drawn_twice_is_laid_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """An SVG that is longer than its PNG, with labels that the panel must make room for."""
    monkeypatch.setattr(style, "SVG_BYTES", 0)
    with styled():
        figure, axis = panels(2.0)
        axis.plot(np.random.default_rng(0).normal(size=5000))
        axis.set_ylabel("two\nlines")
    calls = []
    engine = figure.get_layout_engine()
    execute = type(engine).execute
    monkeypatch.setattr(type(engine), "execute", lambda self, one: calls.append(one) or execute(self, one))
    assert data_url(figure).startswith("data:image/png")
    assert len(calls) == 1
    assert axis.get_position().x0 > 0.03
