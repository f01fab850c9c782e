"""HTML templates of the pages, and the scripts that sort tables and draw plots."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from reports.pages.packed import packed_plotly
from reports.pages.section import PLOT_CLASS
from validation.text import digits, sentence

TEMPLATES = Path(__file__).parent.parent / "templates"
END = "</body>"
CODE = re.compile("`([^`]+)`")


def render_page(name: str, values: Mapping[str, Any]) -> str:
    """Render a template with its values; a missing value is an error."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
    )
    environment.filters["digits"] = digits
    environment.filters["sentence"] = sentence
    environment.filters["coded"] = coded
    page = environment.get_template(name).render(values)
    return page.replace(END, _scripts(page) + END)


def coded(text: str) -> Markup:
    """Return a text as HTML, with what stands between backticks as code."""
    return Markup(CODE.sub(r"<code>\1</code>", str(escape(text))))


def _scripts(page: str) -> str:
    """Return the page's scripts inline, so that the page works without a network."""
    own = (TEMPLATES / "page.js").read_text(encoding="utf-8")
    library = f"{packed_plotly()}\n" if PLOT_CLASS in page else ""
    return f"{library}<script>{own}</script>\n"
