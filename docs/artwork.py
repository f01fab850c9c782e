"""Logo, favicon, social card and badges, drawn from the colours of the reports: `python docs/artwork.py`."""

from __future__ import annotations

import io
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from reports.palette import INK, LINES, RAW

DOCS = Path(__file__).parent
STYLE, PICTURES = DOCS / "style", DOCS / "pictures"
TESTED = ("3.11", "3.13")
"""The oldest and the newest Python on which the wheel was installed and run."""
CARD_INCH, CARD_DPI, CARD_COLOURS = (12.8, 6.4), 100, 64
BLUE, ORANGE = LINES[0], LINES[1]
HEIGHT, LETTER = 20, 6.7
"""Height of a badge, and width of its letters, in pixels."""
Box = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {w:g} {h}" width="{w:g}" height="{h}" role="img">'


def main() -> None:
    """Write all of them."""
    for path, content in files():
        path.write_bytes(content)


def files() -> Iterator[tuple[Path, bytes]]:
    """Each file with its content; of the card the pixels are the same on every machine, the bytes may differ."""
    yield STYLE / "logo.svg", logo(1.0).encode()
    yield STYLE / "favicon.svg", logo(2.2).encode()
    yield STYLE / "card.png", card()
    for name, (left, right) in facts().items():
        yield PICTURES / f"badge-{name}.svg", badge(left, right).encode()


def logo(weight: float) -> str:
    """The measured ellipsoid and the sphere that calibration makes of it, with the offset between their centres."""
    line = f'stroke-width="{1.8 * weight:g}" fill="none"'
    return (
        f"{Box.format(w=64, h=64)}<title>magbench</title>"
        f'<ellipse cx="40" cy="25" rx="21" ry="14" transform="rotate(-28 40 25)" stroke="{ORANGE}" {line} '
        'stroke-dasharray="5 3"/>'
        f'<circle cx="25" cy="38" r="20" stroke="{BLUE}" {line}/>'
        f'<path d="M40 25 L29 34.5 M30.5 28.5 L28.5 35 L35.5 34" stroke="{RAW}" {line} stroke-linecap="round"/>'
        f'<circle cx="25" cy="38" r="{2.4 * weight:g}" fill="{BLUE}"/></svg>\n'
    )


def facts() -> dict[str, tuple[str, str]]:
    """What the badges say, as pyproject.toml has it."""
    project: dict[str, Any] = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))
    strict = project["tool"]["mypy"]["strict"]
    return {
        "python": ("python", " to ".join(TESTED)),
        "license": ("license", project["project"]["license"]),
        "types": ("types", "mypy strict" if strict else "mypy"),
    }


def badge(left: str, right: str) -> str:
    """A badge of two words, the second on blue."""
    one, two = (LETTER * len(text) + 12 for text in (left, right))
    style = 'fill="#ffffff" text-anchor="middle" font-family="sans-serif" font-size="11"'
    word = f'<text x="{{x:g}}" y="14" {style}>{{text}}</text>'
    return (
        f"{Box.format(w=one + two, h=HEIGHT)}<title>{left}: {right}</title>"
        f'<rect width="{one:g}" height="{HEIGHT}" fill="{INK}"/>'
        f'<rect x="{one:g}" width="{two:g}" height="{HEIGHT}" fill="{BLUE}"/>'
        f"{word.format(x=one / 2, text=left)}{word.format(x=one + two / 2, text=right)}</svg>\n"
    )


def card() -> bytes:
    """The picture that a link to the site shows: measured and calibrated field on the sphere, beside the name."""
    with rc_context({"font.family": "DejaVu Sans", "text.color": INK}):
        figure = Figure(figsize=CARD_INCH, dpi=CARD_DPI, facecolor="white")
        figure.text(0.06, 0.60, "magbench", fontsize=64, weight="bold")
        figure.text(
            0.06, 0.36, "Simulate, calibrate, diagnose:\na test bench for three-axis\nmagnetometers", fontsize=26
        )
        axes = figure.add_axes((0.54, 0.03, 0.44, 0.94))
        _draw_clouds(axes)
        file = io.BytesIO()
        figure.savefig(file, format="png")
    small = io.BytesIO()
    Image.open(file).convert("RGB").quantize(CARD_COLOURS, dither=Image.Dither.NONE).save(small, "png", optimize=True)
    return small.getvalue()


def _draw_clouds(axes: Any) -> None:
    """Directions of a spiral over the sphere, as measured with hard and soft iron, and calibrated."""
    height = np.linspace(-0.99, 0.99, 500)
    angle = np.pi * (1 + 5**0.5) * np.arange(len(height))
    across = np.sqrt(1 - height**2)
    sphere = np.column_stack([across * np.cos(angle), height, across * np.sin(angle)])
    raw = sphere @ np.array([[1.15, 0.30, 0.0], [0.30, 0.75, 0.0], [0.0, 0.0, 1.0]]) + [0.75, 0.60, 0.0]
    front, behind = sphere[:, 2] > 0, sphere[:, 2] <= 0
    for points, colour in ((raw, ORANGE), (sphere, BLUE)):
        axes.scatter(*points[behind, :2].T, s=7, color=RAW, alpha=0.45, linewidths=0)
        axes.scatter(*points[front, :2].T, s=16, color=colour, linewidths=0)
    axes.annotate("", xy=(0.06, 0.05), xytext=(0.75, 0.60), arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 2.5})
    axes.set_aspect("equal")
    axes.set_axis_off()


if __name__ == "__main__":
    main()
