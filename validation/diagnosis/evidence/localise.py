"""Where the gap is: two-fold held-out share of the residual that a binned channel explains, body and earth frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from sim.rotation import matrix_from_q
from sim.state import Array
from validation.diagnosis.evidence.problem import Problem

BINS = 24
SEGMENTS = 40
LEAST = 0.003
MOST = 8


def localise(problem: Problem, residual: Array) -> tuple[tuple[str, str, float], ...]:
    """Channels in order of the share of the residual's slow power (n, q) that their bins explain on held-out data."""
    n = len(residual)
    length = max(1, min(round(0.5 / problem.state.interval_s), n // 400))
    m = n // length
    mean = residual[: m * length].reshape(m, length, -1).mean(axis=1)
    frames = {"body" if problem.mode == "vector" else "strength": mean}
    if problem.mode == "vector":
        R = problem.state.R_wb[: m * length : length]
        frames["earth"] = np.einsum("nij,nj->ni", R, mean)
    found = [
        (name, frame, _held_out(values[: m * length].reshape(m, length).mean(axis=1), left))
        for name, values in channels(problem)
        for frame, left in frames.items()
    ]
    best: dict[str, tuple[str, str, float]] = {}
    for one in sorted(found, key=lambda f: -f[2]):
        best.setdefault(one[0], one)
    return tuple(one for one in best.values() if one[2] > LEAST)[:MOST]


def channels(problem: Problem) -> Iterator[tuple[str, Array]]:
    """Every channel (n,) that may drive a disturbance, by name."""
    recording, state = problem.recording, problem.state
    yield "time_s", state.time_s
    for i, axis in enumerate("xyz"):
        yield f"field_{axis}", state.field_nT[:, i]
    if "rate" in problem.has:
        for i, axis in enumerate("xyz"):
            yield f"rate_{axis}", state.rate_rad_s[:, i]
    if recording.att_q is not None:
        R = matrix_from_q(np.ascontiguousarray(recording.att_q))
        yield "heading", np.arctan2(R[:, 1, 0], R[:, 0, 0])
        yield "pitch", np.arcsin(np.clip(-R[:, 2, 0], -1, 1))
        yield "roll", np.arctan2(R[:, 2, 1], R[:, 2, 2])
    if recording.pos_enu_m is not None:
        for i, axis in enumerate(("east", "north", "up")):
            yield f"pos_{axis}_m", recording.pos_enu_m[:, i]
    if recording.temperature_degC is not None:
        yield "temperature_degC", recording.temperature_degC
    if recording.current_A is not None:
        for i, column in enumerate(recording.current_A.T):
            yield f"current_{i + 1}_A", column
    yield from recording.channels.items()


def _held_out(channel: Array, left: Array) -> float:
    """Share of the squares of left (m, q) that bin means of a channel (m,), learnt on other segments, explain."""
    edges = np.unique(np.quantile(channel, np.linspace(0, 1, BINS + 1)[1:-1]))
    if not np.isfinite(channel).all() or len(edges) < 2:
        return 0.0
    place = np.searchsorted(edges, channel)
    fold = np.arange(len(channel)) * SEGMENTS // len(channel) % 2
    after = 0.0
    for held in (0, 1):
        train = fold != held
        count = np.bincount(place[train], minlength=len(edges) + 1)
        total = np.stack([np.bincount(place[train], c, minlength=len(edges) + 1) for c in left[train].T], axis=1)
        guess = total / np.maximum(count, 1)[:, None]
        after += float(((left[~train] - guess[place[~train]]) ** 2).sum())
    before = float((left**2).sum())
    return 1 - after / before if before > 0 else 0.0
