"""Reading a report's page as a browser would."""

from __future__ import annotations

import json
import re
from typing import Any


def without_scripts(page: str) -> str:
    """What readers see, and what the page would load."""
    return re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)


def plots(page: str) -> list[dict[str, Any]]:
    """The figures that zoom."""
    return [json.loads(data) for data in re.findall(r'<script type="application/json">(.*?)</script>', page)]


def figures(page: str) -> int:
    """Number of figures, those that zoom and those that are pictures."""
    return len(plots(page)) + without_scripts(page).count('src="data:image/')
