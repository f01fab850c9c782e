"""Damaged scenarios and overrides: refused in one line, or simulated to a whole dataset."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import strategies as st

from scenarios.errors import InputError
from sim.scenario import load
from tests.fuzz.contract import amounts, check_dataset, fuzz, hold
from tests.fuzz.material import SCENARIO, scenario_in

CASES = 200
MAX_ROWS = 3000
"""Longer ones are loaded and checked, and not simulated."""
LINES = SCENARIO.splitlines()
VALUES = (
    *("0", "-1", "1", "2", "0.5", "1e-9", "1e9", "1e300", "nan", "inf", "-inf", "9" * 5000, "true", '""', '"auv"'),
    *("[]", "[1.0]", "[0.0, 0.0, 0.0]", "[nan, 0.0, 0.0]", "[1e300, 1e300, 1e300]", '["a", "b", "c"]', "{}"),
    *("{ a = 1 }", "[{}, {}]", "2026-01-02", "12:00:00", "2026-01-02T03:04:05Z", '"\\u0000"', "[" * 3000, "5e-324"),
    *("[" * 90 + "1" + "]" * 90, "{ uniform = [0.0, 1.0] }", "{ normal = [0.0, -1.0] }", "[[1.0, 0.0, 0.0]]"),
)
HEADERS = (
    *("[effects.spikes]", "[effects.dropouts]", "[[effects.hard_iron]]", "[effects.soft_iron]", "[effects]"),
    *("[[phases]]", "[phases]", "[weather]", "[vehicle]", "[vary]", "[effects.saturation]", "[effects.quantisation]"),
)
KEYS = (
    *("seed", "name", "field", "field.enu_nT", "field.latitude_deg", "vehicle.kind", "sampling.rate_hz", "phases.0"),
    *("phases.0.kind", "phases.0.duration_s", "phases.0.run_in_s", "phases.1.kind", "sensors.0.position_m", "sensors"),
    *("effects.white_noise.std_nT", "effects.latency.delay_s", "effects.spikes.rate_hz", "effects.white_noise"),
    *("effects.temperature_offset.slope_nT_K", "effects", "vary", 'vary."effects.hard_iron.offset_nT"', "calibrators"),
    *("thermal.time_constant_s", "navigation.attitude_correlation_s", "effect_order", "a" + ".a" * 2000, "", ".", '"'),
    *("phases.-1.kind", "phases.99999999999999999999.kind", "phases.٣.kind", "x\ny", "\x00"),
)


@dataclass(frozen=True)
class Case:
    """Lines of the scenario that are replaced, and overrides."""

    lines: tuple[tuple[int, str], ...] = ()
    overrides: tuple[str, ...] = ()
    command: str = "simulate"


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """One to three lines changed, or one to three overrides."""

    def line() -> tuple[int, str]:
        at = draw(st.integers(0, len(LINES) - 1))
        key, equals, _ = LINES[at].partition(" = ")
        values, headers = st.sampled_from(VALUES), st.sampled_from(HEADERS)
        changed = st.one_of(values.map(lambda value: f"{key} = {value}"), st.just(""), st.just(f"{key}x{equals} 1"))
        inserted = st.tuples(headers, values).map(lambda two: f"{LINES[at]}\n{two[0]}\nrate_hz = {two[1]}")
        return at, draw(changed if equals and draw(st.integers(0, 4)) else inserted)

    def override() -> str:
        return f"{draw(st.sampled_from(KEYS))}={draw(st.sampled_from((*VALUES, '')))}"

    edit, amount = draw(st.integers(0, 2)), draw(st.integers(1, 3))
    lines = tuple(line() for _ in range(amount)) if edit != 0 else ()
    overrides = tuple(override() for _ in range(amount)) if edit != 1 else ()
    return Case(lines, overrides, draw(st.sampled_from(["simulate", "simulate", "run"])))


def check(place: Path, case: Case) -> int:
    """Write the scenario and simulate it; `run` is only let as far as its checks, since its output is a file."""
    out, file, taken = place / "out", place / "tiny.toml", place / "taken"
    shutil.rmtree(out, ignore_errors=True)
    text = list(LINES)
    for at, line in case.lines:
        text[at] = line
    file.write_text("\n".join(text))
    taken.write_text("a file")
    sets = [word for override in case.overrides for word in ("--set", override)]
    if case.command == "run" or is_long(file, case.overrides):
        assert hold(out, "run", str(file), "-o", str(taken), *sets) == 2
        return 2
    status = hold(out, "simulate", str(file), "-o", str(out), "--jobs", "1", *sets)
    if status == 0:
        check_dataset(out)
    else:
        assert not list(out.glob("*.parquet"))
    return status


def is_long(file: Path, overrides: tuple[str, ...]) -> bool:
    """Whether a scenario is valid, and its motion longer than a case may take."""
    try:
        scenario = load(file, overrides)
    except InputError:
        return False
    length_s = sum(phase.duration_s for phase in scenario.phases)
    return length_s > 600 or length_s * scenario.sampling.rate_hz * len(scenario.sensors) > MAX_ROWS


@amounts
def test_scenarios(tmp_path: Path, times: int) -> None:
    fuzz(cases(), lambda case: check(tmp_path, case), CASES, times)


def test_the_scenario_itself(tmp_path: Path) -> None:
    scenario_in(tmp_path)
    assert check(tmp_path, Case()) == 0


@pytest.mark.parametrize(
    "override",
    [
        "seed=" + "[" * 5000,
        "seed=" + "[" * 100_000,
        "seed=" + "{a=" * 5000,
        "seed=" + "9" * 5000,
        "a" + ".a" * 5000 + "=1",
        "a" + ".a" * 500_000 + "=1",
        "phases." + "9" * 5000 + ".kind=1",
        "effects.white_noise.std_nT=" + "[" * 90 + "1" + "]" * 90,
        "sampling.rate_hz=0",
        "sampling.rate_hz=nan",
        "effects.hard_iron.offset_nT=[inf, 0, 0]",
        "phases.0.run_in_s=5e-324",
        "thermal.time_constant_s=5e-324",
        "navigation.attitude_correlation_s=5e-324",
    ],
    ids=lambda text: text[:40],
)
def test_known_overrides(tmp_path: Path, override: str) -> None:
    assert check(tmp_path, Case(overrides=(override,))) in (0, 2)
