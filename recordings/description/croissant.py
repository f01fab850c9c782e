"""The Croissant 1.0 description of a dataset (MLCommons): JSON-LD for search engines and data loaders."""

from __future__ import annotations

import json
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from recordings.columns import schema
from recordings.description.card import LICENCE, title_of
from recordings.description.runs import RUNS
from recordings.files import sha256_of, write_text
from recordings.manifest import Manifest
from recordings.split import Split
from recordings.url_path import Place, arrow_source

CROISSANT = "croissant.json"
VERSION = "http://mlcommons.org/croissant/1.0"
PARQUET = "application/x-parquet"
CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
"""The names of Croissant 1.0's terms, as its specification lists them."""
Node = dict[str, Any]


def write_croissant(out: Place, dataset: Manifest, split: Split) -> None:
    """Write OUT/croissant.json: record sets `samples-train`, …, a record a sample, and `runs`, a record a run.

    There is no date of publication, since nothing is published here and equal datasets give equal bytes.
    """
    parts = [part for part, runs in split.counts(dataset.runs).items() if runs]
    with arrow_source(out / RUNS) as source:
        runs = pq.read_schema(source)
    made_by = dataset.packages["magbench"]
    sources = {f"samples-{part}": {"fileSet": {"@id": f"files-{part}"}} for part in parts}
    description: Node = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": VERSION,
        "name": title_of(dataset),
        "description": f"{dataset.scenario.get('summary', '')}. Simulated magnetometer recordings with their truth.",
        "license": f"https://spdx.org/licenses/{LICENCE}",
        "creator": {"@type": "Organization", "name": f"magbench {made_by}"},
        "version": made_by,
        "keywords": ["magnetometer", "calibration", "synthetic"],
        "distribution": [*(_files(part, dataset) for part in parts), _table(out / RUNS)],
        "recordSet": [
            *(_records(name, source, schema(dataset.columns)) for name, source in sources.items()),
            _records("runs", {"fileObject": {"@id": RUNS}}, runs),
        ],
    }
    write_text(out / CROISSANT, json.dumps(description, indent=1, allow_nan=False, ensure_ascii=False) + "\n")


def _files(part: str, dataset: Manifest) -> Node:
    """Return the node of all files of a part."""
    return {
        "@type": "cr:FileSet",
        "@id": f"files-{part}",
        "description": f"{'one run' if dataset.runs_per_file == 1 else 'several runs'} a file, for {part}",
        "encodingFormat": PARQUET,
        "includes": dataset.layout.pattern(part, dataset.runs),
    }


def _table(path: Place) -> Node:
    return {
        "@type": "cr:FileObject",
        "@id": path.name,
        "contentUrl": path.name,
        "encodingFormat": PARQUET,
        "sha256": sha256_of(path),
    }


def _records(name: str, source: Node, table: pa.Schema) -> Node:
    """Return a record set whose fields are the columns of a Parquet table."""
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "field": [_field(f"{name}/{field.name}", field, source) for field in table],
    }


def _field(name: str, field: pa.Field, source: Node) -> Node:
    about = {key.decode(): text.decode() for key, text in (field.metadata or {}).items()}
    unit = f" ({about['unit']})" if about.get("unit", "1") not in ("", "1") else ""
    return {
        "@type": "cr:Field",
        "@id": name,
        "description": about.get("meaning", "") + unit,
        "dataType": _type(field.type),
        "source": {**source, "extract": {"column": field.name}},
    }


def _type(kind: pa.DataType) -> str:
    if pa.types.is_integer(kind):
        return "sc:Integer"
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"
