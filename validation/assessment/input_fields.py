"""Fields of currents and temperature that a calibration leaves: what they add to the heading error."""

from __future__ import annotations

import numpy as np

from calib import Calibration
from scenarios.arrays import Array
from validation.assessment.level_flight import LevelFlight
from validation.assessment.posterior import Posterior
from validation.assessment.sensor_model import MOTORS, WARMTH, group_of


def moved_rms_deg(fit: Calibration, posterior: Posterior, flight: LevelFlight) -> Array:
    """Return the rms (m,) of the heading error that follows the inputs as they were logged, for each draw.

    e = A (sum_j t_j x_j - sum_k g_k p_k) across the heading, x and p less their means; rms over headings and log.
    """
    vectors, C = _left(fit, posterior)
    rows = flight.across @ fit.matrix
    across = np.einsum("hi,mqi->mhq", rows, vectors)
    return np.asarray(np.sqrt(np.einsum("mhq,qr,mhr->m", across, C, across) / len(rows)).clip(0.0))


def _left(fit: Calibration, posterior: Posterior) -> tuple[Array, Array]:
    """Return vectors (m, q, 3), nT, of the drawn disturbances and less those of the fit, and moments C (q, q)."""
    drawn_nT = posterior.drawn.moved_nT
    gains_nT = np.array([term.gain_nT for term in fit.inputs]).reshape(-1, 3)
    taken = np.broadcast_to(-gains_nT, (len(drawn_nT), *gains_nT.shape))
    signals = [one.change for one in posterior.model.signals] + [term.moved(posterior.recording) for term in fit.inputs]
    series = np.array(signals).reshape(len(signals), len(posterior.recording))
    off = series - series.mean(axis=1, keepdims=True)
    return np.concatenate((drawn_nT, taken), axis=1), np.asarray(off @ off.T / max(1, off.shape[1]))


def unmodelled(fit: Calibration, posterior: Posterior) -> tuple[str, ...]:
    """Return the groups of inputs, motors and temperature, whose field the recording shows and the fit leaves."""
    own = {group_of(term.channel) for term in fit.inputs}
    spreads = posterior.likeliest.spreads
    return tuple(name for name in (MOTORS, WARMTH) if spreads.get(name, 0.0) > 0 and name not in own)
