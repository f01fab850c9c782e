"""Mutants that no test is meant to notice, one by one, each with its reason."""

from __future__ import annotations

import tomllib
from pathlib import Path

REASONS = Path(__file__).with_suffix(".toml")


def set_aside() -> dict[str, str]:
    """The word for each, by its key: bound, tolerance, equivalent, wording."""
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8"))
    return {key: word for word, keys in reasons.items() for key in keys}
