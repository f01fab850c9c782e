"""Searches for parameters that a short list of values cannot find: moments, places, frequencies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares, minimize_scalar

from sim.effects.kernels import kernel
from sim.state import Array
from validation.diagnosis.evidence.blocks import Cut
from validation.diagnosis.evidence.problem import Problem
from validation.diagnosis.library.candidates import Candidate

Search = Callable[[Problem, Array, Array, Candidate], list[Candidate]]
BEST_TONES, BEST_PLACES = 1, 4
MARGIN_M = 15.0
NEAR_M, FAR_M = 0.5, 60.0
COARSE = 7
SLOWEST_TONE_HZ = 0.1
"""A slower ripple is no ripple: with a steady current it would fit whatever comes round with the motion."""


def searched(problem: Problem, residual: Array, deflate: Array, members: list[Candidate]) -> list[Candidate]:
    """The members of a candidate after its search, if it has one, made with the first: what fits the residual best.

    residual (n, q): what the base and the effects already in leave.
    deflate (n, p): the base's columns, whose part of a candidate explains nothing.
    """
    search = SEARCHES.get(members[0].name)
    if search is None:
        return members
    found = search(problem, residual, deflate, members[0])
    return [
        _with(member, dict(one.nonlinear) | dict(member.nonlinear), one.tried) for one in found for member in members
    ]


def refined(member: Candidate, misfit: Callable[[Candidate], float]) -> Candidate | None:
    """A member with its one listed number moved between its neighbours in the list to where the misfit is least."""
    if len(member.effect.search) != 1 or member.name in SEARCHES:
        return None
    ((name, listed),) = member.effect.search.items()
    value = dict(member.nonlinear)[name]
    at = listed.index(value)
    low, high = listed[max(at - 1, 0)], listed[min(at + 1, len(listed) - 1)]
    floor = max(low, high * 1e-3)
    best = minimize_scalar(
        lambda x: misfit(_with(member, {name: float(np.exp(x))}, member.tried)),
        bounds=(np.log(floor), np.log(high)),
        method="bounded",
        options={"xatol": 0.01, "maxiter": 12},
    )
    return _with(member, {name: float(np.exp(best.x))}, max(member.tried, len(listed)))


def moments(problem: Problem, residual: Array, deflate: Array, member: Candidate) -> list[Candidate]:
    """Steps: every second's suffix sums against the base's complement; the best moment and, around it, each sample."""
    time = problem.state.time_s
    B = deflate * problem.usable[:, None]
    inverse = np.linalg.pinv(B.T @ B, rcond=1e-13, hermitian=True)
    beyond_B = np.cumsum(B[::-1], axis=0)[::-1]
    beyond_1 = np.cumsum(problem.usable[::-1])[::-1]
    y0 = residual - B @ (inverse @ (B.T @ residual))
    beyond_y = np.cumsum(y0[::-1], axis=0)[::-1]
    size = beyond_1 - np.einsum("np,pr,nr->n", beyond_B, inverse, beyond_B)
    if problem.mode == "strength":
        return _moments_of_strength(problem, y0, member)
    gain = (beyond_y**2).sum(axis=1) / np.maximum(size, 1e-9)
    gain[size < 0.02 * size.max()] = 0.0
    best = int(np.argmax(gain))
    return [_with(member, {"time_s": float(time[best])}, tried=len(time))]


def _moments_of_strength(problem: Problem, y0: Array, member: Candidate) -> list[Candidate]:
    """Steps seen through the direction: the sum of direction times residual beyond each moment."""
    columns = member.columns(problem)[:, 0, :]
    direction = np.where(columns != 0, columns, 0.0)
    beyond = np.cumsum((direction * y0)[::-1], axis=0)[::-1]
    count = np.arange(len(y0), 0, -1)
    gain = (beyond**2).sum(axis=1) / count / (1 - count / (len(y0) + 1))
    edge = max(2, len(y0) // 50)
    best = edge + int(np.argmax(gain[edge:-edge]))
    return [_with(member, {"time_s": float(problem.state.time_s[best])}, tried=len(y0))]


def tones(problem: Problem, residual: Array, deflate: Array, member: Candidate) -> list[Candidate]:
    """Frequencies: peaks of the spectrum of residual times current, refined between the lines; both phases."""
    interval = problem.state.interval_s
    motor = dict(member.nonlinear).get("motor", 0)
    current = problem.state.current_A
    drive = current[:, motor - 1] if motor else current.sum(axis=1)
    spectrum = (np.abs(np.fft.rfft(residual * drive[:, None], axis=0)) ** 2).sum(axis=1)
    f = np.fft.rfftfreq(len(drive), interval)
    spectrum[f < max(SLOWEST_TONE_HZ, 4 / (len(drive) * interval))] = 0.0
    lines = []
    for _ in range(BEST_TONES):
        k = int(np.argmax(spectrum))
        lines.append(_finer(residual, drive, problem.state.time_s, f[k], f[1]))
        spectrum[max(0, k - 3) : k + 4] = 0.0
    return [_with(member, {"frequency_hz": line}, tried=len(f)) for line in lines]


def _finer(residual: Array, drive: Array, time_s: Array, frequency_hz: float, line_hz: float) -> float:
    """The strongest frequency within a line of the spectrum, to a hundredth of a line."""
    weighted = residual * drive[:, None]
    centre, step = frequency_hz, line_hz / 2
    for _ in range(4):
        tried = centre + step * np.linspace(-1, 1, 9)
        turn = np.exp(-2j * np.pi * tried[:, None] * time_s)
        power = (np.abs(turn @ weighted) ** 2).sum(axis=1)
        centre, step = float(tried[int(np.argmax(power))]), step / 4
    return max(centre, 1e-6)


def places(problem: Problem, residual: Array, deflate: Array, member: Candidate) -> list[Candidate]:
    """Positions of a dipole: a coarse grid about the path on thinned samples, then the best few refined."""
    thin = _thinned(problem, residual, deflate)
    path = thin.path
    low, high = path.min(axis=0) - MARGIN_M, path.max(axis=0) + MARGIN_M
    axes = [
        np.linspace(a, b, max(COARSE, min(2 * COARSE, round((b - a) / 10)))) for a, b in zip(low, high, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    near = np.array([np.sqrt(((path - p) ** 2).sum(axis=1).min()) for p in grid])
    grid = grid[(near > NEAR_M) & (near < FAR_M)]
    if not len(grid):
        return []
    gains = np.array([thin.gain(place) for place in grid])
    found = []
    for start in grid[np.argsort(-gains)[:BEST_PLACES]]:
        place = thin.refined(start)
        if not NEAR_M < np.sqrt(((path - place) ** 2).sum(axis=1).min()) < FAR_M:
            continue  # on the sensor, or so far that its field is a gradient
        found.append(_with(member, {"position_enu_m": tuple(float(v) for v in place)}, tried=len(grid)))
    return found


class _Thin:
    """A problem on thinned samples for the search of a place.

    path (n, 3); to_sensor (n, 3, 3) turns a field to the sensor, in units of the noise; y (3 n,) is the residual less
    its base part; Q (n, p) are the base's orthonormal columns.
    """

    def __init__(self, path: Array, to_sensor: Array, y: Array, Q: Array) -> None:
        self.path, self.to_sensor, self.y, self.Q = path, to_sensor, y.ravel(), Q

    def left(self, place: Array) -> Array:
        """What the residual keeps (3 n,) after the best moment at a place."""
        E = _unit_dipoles(self.path, place, self.to_sensor).reshape(len(self.path), 9)
        flat = (E - self.Q @ (self.Q.T @ E)).reshape(-1, 3)
        c = np.linalg.lstsq(flat.T @ flat, flat.T @ self.y, rcond=1e-12)[0]
        return np.asarray(self.y - flat @ c)

    def gain(self, place: Array) -> float:
        """Squares that a dipole at a place explains."""
        left = self.left(place)
        return float(self.y @ self.y - left @ left)

    def refined(self, start: Array) -> Array:
        """The place of least squares near a start (variable projection)."""
        return np.asarray(least_squares(self.left, start, x_scale=5.0, max_nfev=25, diff_step=1e-4).x)


@kernel
def _unit_dipoles(path: Array, place: Array, to_sensor: Array) -> Array:
    """Field (n, 3, 3) of unit moments east, north, up: 100 (3 r r^T / r^5 - I / r^3) nT, as the sensor sees it."""
    out = np.empty((len(path), 3, 3))
    for i in range(len(path)):
        x, y, z = path[i, 0] - place[0], path[i, 1] - place[1], path[i, 2] - place[2]
        r = max(np.sqrt(x * x + y * y + z * z), 0.3)
        far, near = 300.0 / r**5, 100.0 / r**3
        for a in range(3):
            T = to_sensor[i, a]
            along = far * (T[0] * x + T[1] * y + T[2] * z)
            out[i, a, 0] = along * x - near * T[0]
            out[i, a, 1] = along * y - near * T[1]
            out[i, a, 2] = along * z - near * T[2]
    return out


def _thinned(problem: Problem, residual: Array, deflate: Array) -> _Thin:
    """Means over about half a second, at most 3000 of them, as samples of a smaller problem."""
    n = len(residual)
    length = max(1, round(0.5 / problem.state.interval_s), -(-n // 3000))
    cut = Cut(length, n // length)
    middle = np.arange(cut.m) * length + length // 2
    R_bw = problem.state.R_wb[middle].transpose(0, 2, 1)
    to_sensor = np.ascontiguousarray((problem.turn / problem.sigma_nT[:, None]) @ R_bw)
    Q = np.linalg.qr(cut.blocks(deflate).mean(axis=1))[0]
    y = cut.blocks(residual).mean(axis=1)
    return _Thin(problem.state.pos_enu_m[middle], to_sensor, y - Q @ (Q.T @ y), Q)


def _with(member: Candidate, values: dict[str, object], tried: int) -> Candidate:
    return replace(member, nonlinear=tuple((dict(member.nonlinear) | values).items()), tried=max(1, tried))


SEARCHES: dict[str, Search] = {"offset_jump": moments, "current_ripple": tones, "local_dipole": places}
"""The searches by effect; an effect without one is tried at the values of its `search`."""
