"""Sphinx's settings of the site; `docs/book.py` builds it: `make docs`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import docstrings
import drawn
import executed

import magbench

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "magbench"
author = "the magbench authors"
copyright = "the magbench authors, Apache-2.0"
version = release = magbench.__version__
extensions = ["sphinx.ext.autodoc", "myst_parser", "sphinx_design", "sphinx_copybutton", "sphinx_gallery.gen_gallery"]
root_doc = "index"
exclude_patterns = ["gallery", "templates"]
html_extra_path = ["extra"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
default_role = "code"
highlight_language = "none"
autodoc_typehints = "none"  # stated beside each argument
maximum_signature_line_length = 88
autodoc_member_order = "bysource"
autodoc_class_signature = "separated"
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "pictures_of",
    "filename_pattern": r"\.py$",
    "subsection_order": [f"gallery/{group}" for group in drawn.GROUPS],
    "capture_repr": (),
    "image_scrapers": ("drawn.last_figure", "matplotlib"),
    "reset_modules": ("matplotlib", "drawn.in_style"),
    "write_computation_times": False,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "remove_config_comments": True,
}
html_theme = "pydata_sphinx_theme"
html_title = f"magbench {release}"
html_static_path = ["style"]
html_css_files = ["site.css"]
html_logo = "style/logo.svg"
html_favicon = "style/favicon.svg"
templates_path = ["templates"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options: dict[str, Any] = {
    "navbar_start": ["navbar-logo"],
    "logo": {"text": "magbench"},
    "navbar_end": ["versions", "theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_prev_next": True,
    "header_links_before_dropdown": 8,
    "navigation_with_keys": False,
}


def setup(app: Sphinx) -> None:
    """Read docstrings as the project writes them, and run the blocks of the pages that teach."""
    app.connect("source-read", executed.source_read)
    app.connect("autodoc-process-docstring", docstrings.process)
    app.connect("html-page-context", social_card)


def social_card(_app: Sphinx, _page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """The picture and the words that a link to a page shows."""
    place = context["pathto"]("_static/card.png", 1)
    kinds = {"og:title": project, "og:type": "website", "og:image": place, "twitter:card": "summary_large_image"}
    tags = (f'<meta property="{kind}" content="{said}">' for kind, said in kinds.items())
    context["metatags"] = context.get("metatags", "") + "\n".join(tags)
