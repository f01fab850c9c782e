"""The bar's figures from the trials."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from benchmarks.diagnosis.outside import OUTSIDE
from benchmarks.diagnosis.truth import EQUIVALENT, EXACT
from benchmarks.diagnosis.wide.noises import SLOW
from diagnosis.result import EvidenceKind
from diagnosis.verdict import Verdict
from sim.effects import EFFECTS

Row = dict[str, Any]
SLOW_NOISES = {effect.name for effect in EFFECTS if effect.traits.spectrum is not None}
NOISES = SLOW_NOISES | {"white_noise"}
CONFIDENT = (Verdict.NAMED, Verdict.COMPOSITE)
IN_TIME = {"offset_jump", "hard_iron_drift", "diurnal_drift"} | NOISES
"""Effects whose cause is time alone."""
WITHIN = {"time_s": (0.25, "s"), "position_enu_m": (0.5, "m"), "frequency_hz": (1e-3, "Hz"), "delay_s": (0.05, "")}
"""Most error of a parameter that a search finds, and its unit; without one it is relative."""


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Every group of the bar, by name."""
    out = {title: score(some) for group in GROUPS for title, some, score in _parts(group, rows)}
    strong = [r for r in rows if r["kind"] == "single" and r["strengths"][0] >= 0.3 and r["explained"] is not None]
    if strong:
        explained = [r["explained"] for r in strong]
        out["gap"] = {"median": float(np.median(explained)), "tenth_percentile": float(np.quantile(explained, 0.1))}
        out["parameters"] = _parameters(strong)
    out["written model"] = _written(rows)
    seconds = [r["seconds"] for r in rows]
    out["seconds"] = {"slowest": max(seconds), "median": float(np.median(seconds))}
    return out


def confusion(rows: Sequence[Row]) -> tuple[list[str], list[str], Any]:
    """Hidden effects, what was named first, and how often (hidden, first) over single and direct trials."""
    some = [r for r in rows if _sort(r) in ("single", "direct")]
    hidden = sorted({r["hidden"][0] for r in some})
    firsts = [_first(r) or r["verdict"] for r in some]
    columns = hidden + sorted(set(firsts) - set(hidden))
    count = np.zeros((len(hidden), len(columns)))
    for r, first in zip(some, firsts, strict=True):
        count[hidden.index(r["hidden"][0]), columns.index(first)] += 1
    return hidden, columns, count


def failures(rows: Sequence[Row]) -> list[str]:
    """Every trial that missed, in words."""
    return [
        f"{r['key']}: {r['verdict']} {[(name, others) for name, others, _ in r['names']]}, goes with {r['where'][:2]}"
        for r in rows
        if misses(r)
    ]


def misses(r: Row) -> bool:
    """Whether the answer of a trial is not the right one."""
    missed: dict[str, Callable[[Row], bool]] = {
        "null": lambda r: bool(r["names"]),
        "coloured": lambda r: bool({name for name, _, _ in r["names"]} - NOISES),
        "single": lambda r: not _alone(r),
        "direct": lambda r: not _hit(r),
        "left-out": _misnamed,
        "stated": lambda r: not _alone(r),
        "outside": lambda r: r["verdict"] != Verdict.UNKNOWN or not _driver(r),
        "two": lambda r: len(_found(r)) < 2 or len(_claims(r)) > 2,
        "shifted": lambda r: bool(_driven(r)),
        "random": lambda r: bool(_driven(r)),
    }
    return missed[_sort(r)](r)


def _nulls(rows: Sequence[Row], allowed: set[str]) -> Row:
    named = [r for r in rows if {name for name, _, _ in r["names"]} - allowed]
    return {"runs": len(rows), "named": len(named) / len(rows), "verdicts": dict(Counter(r["verdict"] for r in rows))}


def _share(rows: Sequence[Row], holds: Callable[[Row], bool]) -> float:
    return float(np.mean([holds(r) for r in rows]))


def _single(rows: Sequence[Row]) -> Row:
    sizes = [1 + len(r["names"][0][1]) for r in rows if r["names"]]
    return {
        "runs": len(rows),
        "in_class": _share(rows, _hit),
        "first_right": _share(rows, _right),
        "class_size": float(np.mean(sizes)) if sizes else None,
        "one_name": _share(rows, _alone),
        "partial": _share(rows, lambda r: r["verdict"] == Verdict.PARTIAL),
        "extra_names": float(np.mean([max(0, len(_claims(r)) - 1) for r in rows])),
        "confidently_wrong": _share(rows, lambda r: r["verdict"] in CONFIDENT and not _hit(r)),
        "verdicts": dict(Counter(r["verdict"] for r in rows)),
        **({"white_rest": _white_rest(rows)} if any("colour" in r for r in rows) else {}),
    }


def _white_rest(rows: Sequence[Row]) -> Row:
    """The same of those whose rest is white."""
    white = [r for r in rows if not r.get("colour")]
    return {
        "runs": len(white),
        **({"in_class": _share(white, _hit), "one_name": _share(white, _alone)} if white else {}),
    }


def _measured_rests(rows: Sequence[Row]) -> Row:
    """Names for what was shifted or has random phases; what happens once, in time, may be in a log itself."""
    return {
        "runs": len(rows),
        "named": _share(rows, lambda r: bool(_driven(r))),
        "any_name": _share(rows, lambda r: bool(_of_data(r))),
        "of": dict(Counter(name for r in rows for name in _driven(r))),
        "verdicts": dict(Counter(r["verdict"] for r in rows)),
    }


def _white_nulls(rows: Sequence[Row]) -> Row:
    return _nulls(rows, allowed=set())


def _coloured_nulls(rows: Sequence[Row]) -> Row:
    return _nulls(rows, allowed=NOISES)


def _left_out(rows: Sequence[Row]) -> Row:
    wrong = [r for r in rows if _misnamed(r)]
    return {
        "runs": len(rows),
        "misnamed": len(wrong) / len(rows),
        "of": dict(Counter(f"{r['hidden'][0]} as {_first(r)}" for r in wrong)),
        "verdicts": dict(Counter(r["verdict"] for r in rows)),
    }


def _outside(rows: Sequence[Row]) -> Row:
    return {
        "runs": len(rows),
        "unknown": float(np.mean([r["verdict"] == Verdict.UNKNOWN for r in rows])),
        "driver_in_first_two": float(np.mean([_driver(r) for r in rows])),
        "confidently_wrong": float(np.mean([r["verdict"] in CONFIDENT for r in rows])),
        "verdicts": dict(Counter(r["verdict"] for r in rows)),
    }


def _two(rows: Sequence[Row]) -> Row:
    found = [len(_found(r)) for r in rows]
    extra = [max(0, len(_claims(r)) - n) for r, n in zip(rows, found, strict=True)]
    return {
        "runs": len(rows), "both": float(np.mean([n == 2 for n in found])), "extra_names": float(np.mean(extra)),
        "verdicts": dict(Counter(r["verdict"] for r in rows)),
    }  # fmt: skip


def _written(rows: Sequence[Row]) -> Row:
    """How far what the simulator leaves with the written model is from the rest that the diagnosis tells."""
    given = [r for r in rows if r.get("resimulated_nT") is not None]
    off = [abs(r["resimulated_nT"] / r["after_nT"] - 1) for r in given]
    some = {"within_5_percent": float(np.mean(np.array(off) < 0.05)), "most": max(off)} if off else {}
    return {"runs": len(given), **some}


def _parameters(rows: Sequence[Row]) -> Row:
    """Share of runs whose error is within the bar's limit, and the intervals' coverage."""
    found: dict[str, list[Sequence[Any]]] = {}
    for r in rows:
        for key, values in r["parameters"].items():
            found.setdefault(key, []).append(values)
    out = {key: _within(several, *WITHIN[name]) for key, several in found.items() if (name := _of(key)[1]) in WITHIN}
    inside = [hit for key, several in found.items() if _of(key)[0] in EXACT for one in several for hit in _covered(one)]
    if inside:
        out["interval_coverage"] = {"intervals": len(inside), "share": float(np.mean(inside))}
    return out


def _of(key: str) -> tuple[str, str]:
    """Effect and parameter of a key."""
    effect, _, parameter = key.partition(".")
    return effect, parameter


def _within(several: Sequence[Sequence[Any]], most: float, unit: str) -> Row:
    errors = np.array([_error(values, relative=not unit) for values in several])
    limit = f"within {most:g} {unit}" if unit else f"within {100 * most:g} %"
    return {"runs": len(errors), limit: float(np.mean(errors <= most))}


def _covered(values: Sequence[Any]) -> list[bool]:
    """Whether the interval of each component holds the truth; none where there is no interval."""
    _, low, high, true = values
    return [] if low is None else [a <= t <= b for a, b, t in zip(low, high, true, strict=True)]


def _error(values: Sequence[Any], *, relative: bool) -> float:
    found, true = np.array(values[0]), np.array(values[3])
    error = float(np.linalg.norm(found - true))
    return error / float(np.linalg.norm(true)) if relative else error


def _class(r: Row) -> set[str]:
    return {n for name, others, _ in r["names"] for n in (name, *others)}


def _same(truth: str) -> set[str]:
    return {truth} | EQUIVALENT.get(truth, set())


def _sort(r: Row) -> str:
    """The kind of a trial, whoever makes its truth."""
    return str(r["kind"].removeprefix("wide-").removeprefix("rest-"))


def _hit(r: Row) -> bool:
    """Whether the answer lists the truth; an iron that is of several kinds at once is any of them."""
    return bool(_class(r) & ({r["hidden"][0]} if _sort(r) in ("single", "stated") else _same(r["hidden"][0])))


def _alone(r: Row) -> bool:
    """Whether the truth, with its look-alikes, is all that the answer names."""
    return _hit(r) and len(_claims(r)) == 1


def _claims(r: Row) -> list[str]:
    """First names of an answer, without slow noise of the sensor where the rest has some: it is there too."""
    noisy = r.get("colour") in SLOW
    return [name for name, *_ in r["names"] if not (noisy and name in SLOW_NOISES and name not in r["hidden"])]


def _of_data(r: Row) -> set[str]:
    """Names that rest on held-out data."""
    return {name for name, _, how in r["names"] if how == EvidenceKind.HELD_OUT}


def _driven(r: Row) -> set[str]:
    """Those of them that are driven by what a log records."""
    return _of_data(r) - IN_TIME


def _first(r: Row) -> str:
    return r["names"][0][0] if r["names"] else ""


def _right(r: Row) -> bool:
    """Whether the truth is first; a declared equivalent is right only in an answer that lists the truth too."""
    return _first(r) in _same(r["hidden"][0]) and _hit(r)


def _misnamed(r: Row) -> bool:
    return r["verdict"] in CONFIDENT and not _class(r) & _same(r["hidden"][0])


def _found(r: Row) -> set[str]:
    return {truth for truth in r["hidden"] if truth in _class(r)}


def _driver(r: Row) -> bool:
    return bool(set(r["where"][:2]) & set(OUTSIDE[r["hidden"][0]][1]))


Score = Callable[[Sequence[Row]], Row]
GROUPS: tuple[tuple[str, str, bool, Score], ...] = (
    ("null", "null, white", False, _white_nulls),
    ("coloured", "null, coloured", False, _coloured_nulls),
    ("single", "single, {:g} sigma", True, _single),
    ("direct", "direct", False, _single),
    ("left-out", "left out", False, _left_out),
    ("stated", "in the model, {:g} times as large", True, _single),
    ("outside", "outside the library", False, _outside),
    ("two", "two effects, {:g} to 1", True, _two),
    ("wide-null", "wide null, white", False, _white_nulls),
    ("wide-coloured", "wide null, coloured", False, _coloured_nulls),
    ("wide-single", "wide single, {:g} sigma", True, _single),
    ("wide-direct", "wide direct", False, _single),
    ("wide-left-out", "wide left out", False, _left_out),
    ("wide-two", "wide two effects, {:g} to 1", True, _two),
    ("rest-shifted", "measured rest, shifted", False, _measured_rests),
    ("rest-random", "measured rest, random phases", False, _measured_rests),
)
"""Kind of trial, title, whether each strength of the first effect is a group of its own, score."""


def _parts(group: tuple[str, str, bool, Score], rows: Sequence[Row]) -> Iterator[tuple[str, list[Row], Score]]:
    kind, title, by_strength, score = group
    some = [r for r in rows if r["kind"] == kind]
    for strength in sorted({r["strengths"][0] for r in some}) if by_strength else [None] * bool(some):
        yield title.format(strength), [r for r in some if strength in (None, *r["strengths"][:1])], score
