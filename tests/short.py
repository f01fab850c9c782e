"""The catalogue's scenarios, cut to a few seconds of motion."""

from __future__ import annotations

from sim.scenario import Scenario, load

SHORT = {
    "descent": {"to_depth_m": 8.0},
    "ascent": {"to_depth_m": 3.0},
    "spiral": {"run_in_s": 10.0, "duration_s": 40.0, "turns": None},
    "comb": {"lines": 2, "line_length_m": 30.0, "run_in_s": 5.0},
    "hover": {"run_in_s": 2.0, "duration_s": 10.0},
    "rotate": {"run_in_s": 2.0, "duration_s": 40.0},
    "turntable_stops": {"dwell_s": 2.0, "move_s": 2.0},
    "turntable_turns": {"rate_deg_s": 40.0},
    "tumble": {"duration_s": 40.0},
}


def short(name: str, *overrides: str) -> Scenario:
    """A catalogue scenario with its phases cut short, and with more overrides after that."""
    return load(name, [*cuts(name), *overrides])


def cuts(name: str) -> list[str]:
    """The overrides that cut a scenario's phases short."""
    return [
        f"phases.{i}.{key}={'' if value is None else value}"
        for i, phase in enumerate(load(name).phases)
        for key, value in SHORT[phase.kind].items()
        if value is not None or getattr(phase, key) is not None
    ]
