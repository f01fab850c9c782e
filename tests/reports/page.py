"""Reading a report's page as a browser would."""

from __future__ import annotations

import base64
import gzip
import json
import re
from typing import Any


def without_scripts(page: str) -> str:
    """What readers see, and what the page would load."""
    return re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)


def read(page: str) -> str:
    """The page's words as `plain` gives those of a text."""
    return plain(re.sub("</?code>|<wbr>", "", page))


def plain(text: str) -> str:
    """A text without what typesetting changes: marks of code, minus signs, spaces that do not break, degrees."""
    return re.sub(r"(?<=\d) deg\b", "°", text.replace("`", "").replace("−", "-").replace("\xa0", " "))


def plots(page: str) -> list[dict[str, Any]]:
    """The figures that zoom."""
    packed = re.findall(r'<script type="application/gzip">(.*?)</script>', page)
    return [json.loads(gzip.decompress(base64.b64decode(data))) for data in packed]


def figures(page: str) -> int:
    """Number of figures, those that zoom and those that are pictures."""
    return len(plots(page)) + without_scripts(page).count('src="data:image/')


def faults(page: str) -> list[str]:
    """What no page may have: no answer, no tool in the title, a raw backtick, a tile without a figure, 1.5 MB."""
    seen = without_scripts(page)
    words = re.sub(r"<(style|code|pre)>.*?</\1>|<[^>]*>", "", seen, flags=re.DOTALL)
    found = {
        "no answer": '<p class="answer' not in seen,
        "no tool in the title": "magbench" not in seen.partition("</title>")[0],
        "a raw backtick": "`" in words,
        "a tile without a figure": bool(re.search(r'class="tile"><b>[–-]?\s*</b>', seen)),
        "1.5 MB": len(page) > 1_500_000,
    }
    return [fault for fault, there in found.items() if there]
