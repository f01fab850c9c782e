"""HTML templates of the pages, and the scripts that sort tables and draw plots."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2

from reports.pages.packed import packed_plotly
from reports.pages.section import PLOT_CLASS
from reports.pages.typeset import breakable, coded, columns_of_text
from validation.text import digits, sentence

TEMPLATES = Path(__file__).parent.parent / "templates"
END = "</body>"


def render_page(name: str, values: Mapping[str, Any]) -> str:
    """Render a template with its values; a missing value is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.filters |= {one.__name__: one for one in (breakable, coded, columns_of_text, digits, sentence)}
    page = environment.get_template(name).render(values)
    return page.replace(END, _scripts(page) + END)


def _scripts(page: str) -> str:
    """Return the page's scripts inline, so that the page works without a network."""
    own = (TEMPLATES / "page.js").read_text(encoding="utf-8")
    library = f"{packed_plotly()}\n" if PLOT_CLASS in page else ""
    return f"{library}<script>{own}</script>\n"
