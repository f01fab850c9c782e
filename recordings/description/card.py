"""The dataset card, README.md: front matter for Hugging Face, then text for people."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from recordings.columns import schema
from recordings.description.runs import FIXED, RUNS
from recordings.files import write_text
from recordings.manifest import MANIFEST, Manifest
from recordings.split import Split
from recordings.url_path import Place

CARD = "README.md"
LICENCE = "Apache-2.0"
"""SPDX's name of the licence of magbench, and so of datasets from the catalogue's scenarios."""
SIZES = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M", "10M<n<100M", "100M<n<1B", "1B<n<10B", "10B<n<100B")
"""Hugging Face's classes of size, from a thousand samples on, in steps of a factor of ten."""


def write_card(out: Place, dataset: Manifest, split: Split) -> None:
    """Write OUT/README.md; the configurations name the parts that hold a run."""
    import jinja2  # here: readers of a dataset write no card

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    write_text(out / CARD, environment.get_template("card.md.jinja").render(_values(dataset, split)))


def title_of(dataset: Manifest) -> str:
    """Return the title of the dataset: the scenario's name."""
    return str(dataset.scenario["name"])


def _values(dataset: Manifest, split: Split) -> dict[str, Any]:
    samples = sum(file.rows for file in dataset.files)
    return {
        "dataset": dataset,
        "title": title_of(dataset),
        "summary": dataset.scenario.get("summary", ""),
        "licence": LICENCE,
        "samples": samples,
        "size": SIZES[min(max(len(str(samples)) - 3, 0), len(SIZES) - 1)],
        "parts": _parts(dataset, split),
        "shares": f"{split.train}/{split.validation}/{split.test}",
        "vary": {key: json.dumps(how) for key, how in dataset.scenario.get("vary", {}).items()},
        "types": {field.name: _type(field.type) for field in schema(dataset.columns)},
        "runs_columns": {name: meaning for name, (_, meaning) in FIXED.items()},
        **{"name": Path(dataset.layout.file_of(0).path).name, "held_runs": _held(dataset)},
        **{"runs_table": RUNS, "manifest": MANIFEST},
    }


def _held(dataset: Manifest) -> str:
    """Return how many runs a file holds, in words."""
    return "one run" if dataset.runs_per_file == 1 else f"{dataset.runs_per_file} runs, told apart by `run`,"


def _parts(dataset: Manifest, split: Split) -> dict[str, dict[str, Any]]:
    """Return the numbers of runs and samples, and the pattern of the files, of each part that holds a run."""
    rows = {part: 0 for part, runs in split.counts(dataset.runs).items() if runs}
    for file in dataset.files:
        rows[split.part_of(file.run)] += file.rows
    counts, pattern = split.counts(dataset.runs), dataset.layout.pattern
    return {
        part: {"runs": counts[part], "samples": samples, "files": pattern(part, dataset.runs)}
        for part, samples in rows.items()
    }


def _type(kind: Any) -> str:
    """Return an Arrow type in a word; a dictionary of words is text."""
    return "text" if str(kind).startswith("dictionary") else str(kind).replace("double", "float64")
