"""The measured recording beside what the model says along the same motion: the two sides of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from calib import Reference, get
from calib.numerics.noise import SECOND, clipped_mean, white_noise_std
from calib.numerics.rates import body_rate, smoothed_derivative
from scenarios.errors import InputError
from scenarios.spec import Model, Scenario
from sim import effects as effect_table
from sim.chain import apply_deterministic
from sim.dataset import Recording
from sim.effects.base import Effect
from sim.field import earth_field_enu_nT
from sim.rotation import cross, matrix_from_q, to_body
from sim.state import Array, State

Mode = Literal["vector", "strength"]
LEAST_SAMPLES = 200
LEAST_NOISE = 1e-6
"""What a residual that vanishes is measured by, nT."""


@dataclass(frozen=True)
class Problem:
    """A recording and a model, as the linear problem ``y = B beta + E c + noise`` of q outputs a sample.

    mode "vector": q = 3, y the measured axes less a first fit of B = [predicted field, 1] on each axis: hard and soft
    iron fitted anew, which also takes up a fixed turn of the sensor. mode "strength": q = 1, y = |h| - F of the
    calibrated field h, B the nine changes of offset and symmetric matrix. y (n, q) is divided by the noise of a
    sample, `sigma_nT` (q,); `base` B (n, p); `usable` (n,) is 0 where a sample is no measurement (repeated, clipped, a
    spike), else 1.
    `turn` (3, 3): from the undisturbed to the measured field; `clean_nT` (n, 3): what the fitted base predicts;
    `predicted_nT` (n, 3): what the model as given predicts. `attitude_std_rad`: the error of navigation's attitude
    that the model states, 0 if none.
    """

    recording: Recording
    state: State
    effects: tuple[Effect, ...]
    mode: Mode
    base: Array
    target: Array
    sigma_nT: Array
    usable: Array
    turn: Array
    clean_nT: Array
    predicted_nT: Array
    has: frozenset[str]
    attitude_std_rad: float = 0.0

    def whitened(self, contribution_nT: Array, stage: str) -> Array:
        """Columns E (n, q, k) of contributions (n, 3, k) that enter at a stage of the chain, in units of the noise."""
        early = stage in ("field", "vehicle")
        if self.mode == "vector":
            columns = self.turn @ contribution_nT if early else contribution_nT.copy()
            columns *= (self.usable[:, None] / self.sigma_nT)[:, :, None]
            return columns
        direction = self.state.field_nT / np.linalg.norm(self.state.field_nT, axis=1, keepdims=True)
        inward = direction if early else direction @ np.linalg.inv(self.turn)
        scalar = np.einsum("ni,nik->nk", inward, contribution_nT)[:, None, :]
        return np.asarray(scalar / self.sigma_nT * self.usable[:, None, None])

    def without(self, samples: NDArray[np.bool_]) -> Problem:
        """The same problem with some samples (n,) left out."""
        keep = self.usable * ~samples
        return replace(self, base=self.base * keep[:, None], target=self.target * keep[:, None], usable=keep)


def pose(recording: Recording, field_enu_nT: Array | None, strength_nT: float, effects: tuple[Effect, ...]) -> Problem:
    """The problem of a recording; with attitude and the field's vector in vector mode, else with its strength only.

    Raises InputError for a recording too short to cut into training and held-out segments, and in strength mode for
    one whose motion does not determine an ellipsoid.
    """
    if len(recording) < LEAST_SAMPLES:
        what = f"{len(recording)} samples, at least {LEAST_SAMPLES} are needed"
        raise InputError(what, where="recording", do="give a longer recording")
    if recording.att_q is not None and field_enu_nT is not None:
        return _vector(recording, field_enu_nT, effects)
    return _strength(recording, strength_nT, effects)


def posed(recording: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None) -> Problem:
    """The problem of a recording and a model, with the model's field where no other is given.

    Raises InputError as `pose` does, and for a bad effect table of the model.
    """
    effects = effect_table.build(model.effects, model.effect_order, "model")
    if field_enu_nT is None and model.field is not None:
        field_enu_nT = earth_field_enu_nT(model.field)
    strength = float(np.linalg.norm(field_enu_nT)) if field_enu_nT is not None else strength_nT or 5e4
    problem = pose(recording, field_enu_nT, strength, effects)
    stated_deg = model.navigation.attitude_noise_std_deg if isinstance(model, Scenario) else 0.0
    return replace(problem, attitude_std_rad=float(np.radians(stated_deg)))


def sample_noise(residual: Array) -> Array:
    """White noise (q,) of a residual (n, q) in which no motion is left; that of rounding at the least."""
    return np.maximum(white_noise_std(residual, orders=SECOND, pooled=clipped_mean), LEAST_NOISE)


def _quieter_rate(recording: Recording) -> Array:
    """Body rate (n, 3): the gyro's or the derivative of an attitude that is not held, whichever is less noisy."""
    derived = body_rate(replace(recording, gyro_rad_s=None))
    assert derived is not None
    gyro, q = recording.gyro_rad_s, recording.att_q
    assert q is not None
    held = np.mean((np.diff(q, axis=0) == 0).all(axis=1)) > 0.1
    if gyro is not None and (held or sample_noise(gyro).sum() < sample_noise(derived).sum()):
        return gyro
    return derived


def _has(recording: Recording) -> frozenset[str]:
    present = {
        "attitude": recording.att_q is not None,
        "rate": recording.gyro_rad_s is not None or recording.att_q is not None,
        "position": recording.pos_enu_m is not None,
        "temperature": recording.temperature_degC is not None,
        "current": recording.current_A is not None and recording.current_A.shape[1] > 0,
    }
    return frozenset(name for name, there in present.items() if there)


def _common(recording: Recording) -> dict[str, Any]:
    n = len(recording)
    time_s = recording.time_s - recording.time_s[0]
    zero = np.zeros((n, 3))
    temperature = recording.temperature_degC
    current = recording.current_A
    return {
        "time_s": time_s,
        "interval_s": float(time_s[-1] / (n - 1)),
        "pos_enu_m": zero if recording.pos_enu_m is None else recording.pos_enu_m,
        "temperature_degC": np.zeros(n) if temperature is None else temperature,
        "current_A": np.zeros((n, 0)) if current is None else current,
        "attitude": "navigation",
    }


def _vector(recording: Recording, field_enu_nT: Array, effects: tuple[Effect, ...]) -> Problem:
    assert recording.att_q is not None
    R_wb = matrix_from_q(np.ascontiguousarray(recording.att_q))
    rate = _quieter_rate(recording)
    field = to_body(R_wb, field_enu_nT[None])
    state = State(
        R_wb=R_wb,
        rate_rad_s=rate,
        field_enu_nT=field_enu_nT,
        field_nT=field,
        field_rate_nT_s=-cross(rate, field),
        **_common(recording),
    )
    predicted, _ = apply_deterministic(effects, state)
    scale = float(np.linalg.norm(field_enu_nT))
    base = np.column_stack([predicted / scale, np.ones(len(recording))])
    beta = _robust_fit(base, recording.mag_nT)
    clean = base @ beta
    sigma = sample_noise(recording.mag_nT - clean)
    return Problem(
        recording=recording, state=state, effects=effects, mode="vector", base=base,
        target=(recording.mag_nT - clean) / sigma, sigma_nT=sigma, usable=np.ones(len(recording)),
        turn=_carried(field, clean), clean_nT=clean,
        predicted_nT=predicted, has=_has(recording),
    )  # fmt: skip


def _strength(recording: Recording, strength_nT: float, effects: tuple[Effect, ...]) -> Problem:
    fit = get("ellipsoid").fit(recording, Reference(strength_nT, None), np.random.default_rng(0))
    if not np.isfinite(fit.matrix).all() or fit.status.kind == "not_applicable":
        do = "give a recording with attitude, or one that turns the sensor in all directions"
        raise InputError(f"no attitude, and no ellipsoid fits: {fit.status.reason}", where="recording", do=do)
    h = (recording.mag_nT - fit.offset_nT) @ fit.matrix.T
    size = np.linalg.norm(h, axis=1, keepdims=True)
    direction = h / size
    field = direction * strength_nT
    rate = body_rate(recording)
    field_rate = smoothed_derivative(field, recording.time_s) if rate is None else -cross(rate, field)
    n = len(recording)
    state = State(
        R_wb=np.tile(np.eye(3), (n, 1, 1)),
        rate_rad_s=np.zeros((n, 3)) if rate is None else rate,
        field_enu_nT=np.array([0.0, strength_nT, 0.0]),
        field_nT=field,
        field_rate_nT_s=field_rate,
        **_common(recording),
    )
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    base = np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])
    residual = size - strength_nT
    sigma = sample_noise(residual)
    turn: Array = np.asarray(np.linalg.inv(fit.matrix), dtype=np.float64)
    clean = field @ turn.T + fit.offset_nT
    return Problem(
        recording=recording, state=state, effects=effects, mode="strength", base=base, target=residual / sigma,
        sigma_nT=sigma, usable=np.ones(n), turn=turn, clean_nT=clean,
        predicted_nT=clean, has=_has(recording),
    )  # fmt: skip


def _carried(field: Array, clean: Array) -> Array:
    """Matrix (3, 3) that carries the undisturbed field (n, 3) to the predicted measurement (n, 3)."""
    design = np.column_stack([field, np.full(len(field), np.linalg.norm(field[0]))])
    return np.asarray(np.linalg.lstsq(design, clean, rcond=1e-6)[0][:3].T)


def _robust_fit(base: Array, measured: Array) -> Array:
    """Least squares (p, q), repeated once without what lies far off: rare failures must not decide the base."""
    beta = np.linalg.lstsq(base, measured, rcond=None)[0]
    off = np.abs(measured - base @ beta)
    far = (off > 8.0 * np.maximum(np.median(off, axis=0), 1e-9)).any(axis=1)
    if 0 < np.count_nonzero(far) < 0.2 * len(far):
        beta = np.linalg.lstsq(base[~far], measured[~far], rcond=None)[0]
    return np.asarray(beta)
