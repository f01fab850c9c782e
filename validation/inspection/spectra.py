"""Noise floor, slow changes and tones of the residual of a simple model."""

from __future__ import annotations

import numpy as np

from calib.numerics.noise import LEAST_SAMPLES, white_noise_std
from scenarios.arrays import Array
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import Residual, SensorData
from validation.policy import POLICY
from validation.signals.noise import BlockMeans, block_means
from validation.signals.tones import Tone, mains_aliases, mains_named, spectrum, tones
from validation.text import counted, figure, figures, listed

SECTION = "noise"
BASES = {
    "attitude": "the residual of the attitude fit",
    "strength": "the residual strength after the ellipsoid fit",
    "mean": "the measured field",
}
MOST_LISTED = 5
"""Tones that are listed."""


def noise_findings(data: SensorData) -> list[Finding]:
    """Return findings on white noise, residual, block means, tones and aliases of the mains."""
    found = [_white(data)]
    if data.residual is not None:
        found += [_residual(data, data.residual), *_slow(data, data.residual), *_tones(data, data.residual)]
    if data.rate_hz > POLICY.least_mains_rate_hz and data.even:
        found.append(_mains(data, data.rate_hz))
    return [finding for finding in found if finding is not None]


def _white(data: SensorData) -> Finding | None:
    if len(data.series) < LEAST_SAMPLES:
        return None
    value, rate = data.white_nT.tolist(), data.rate_hz
    if not np.isfinite(data.white_nT).all():
        text = "The noise cannot be determined: the sensor moved too far between neighbouring samples."
        return Finding(SECTION, "white", value, "nT", text, "note", data.sensor)
    steps = np.array([lattice.step if lattice else 0.0 for lattice in data.lattices])
    if np.any(data.white_nT < POLICY.hidden_noise * steps):
        text = "Most neighbouring samples are equal: the noise is below the least significant bit."
        return Finding(SECTION, "white", value, "nT", text, "note", data.sensor)
    noise_nT, of = _beside_motion(data)
    density = figures(noise_nT * np.sqrt(2 / rate), 2)
    text = f"White noise {figures(noise_nT)} nT rms per sample ({density} nT/√Hz){of}"
    if not (data.settled or of):
        text += " at most: the estimate falls with each further difference, so the noise is not white, "
        text += "or the motion is fast"
    level: Level = "ok" if data.settled or of else "note"
    return Finding(SECTION, "white", noise_nT.tolist(), "nT", text + ".", level, data.sensor)


def _beside_motion(data: SensorData) -> tuple[Array, str]:
    """Return the noise, of the residual where differences leave motion in the measurements, and then so in words."""
    residual = data.residual
    if data.settled or residual is None or residual.base == "mean":
        return data.white_nT, ""
    below_nT = white_noise_std(residual.values)
    if not np.max(below_nT) < np.max(data.white_nT):
        return data.white_nT, ""
    return below_nT, f", of {BASES[residual.base]}: the sensor moves more between neighbouring samples"


def _residual(data: SensorData, residual: Residual) -> Finding | None:
    """Return the rms of the residual, compared with the white noise of the residual."""
    if residual.base == "mean":
        return None
    rms = np.sqrt(np.mean(residual.values**2, axis=0))
    white = white_noise_std(residual.values)
    value = {"base": residual.base, "rms_nT": rms.tolist(), "white_nT": white.tolist()}
    ratio = float(np.max(rms / white)) if np.all(white > 0) else float("nan")
    text = f"{BASES[residual.base][0].upper()}{BASES[residual.base][1:]} is {figures(rms)} nT rms"
    text += f", {figure(ratio, 2)} times its white noise" if np.isfinite(ratio) else ""
    level: Level = "note" if ratio > POLICY.residual_ratio else "ok"
    return Finding(SECTION, "residual", value, "nT", text + ".", level, data.sensor)


def _slow(data: SensorData, residual: Residual) -> list[Finding]:
    """Return block means compared with white noise, except of a measured field in motion."""
    if residual.base == "mean" and not _still(residual):
        return []
    found = block_means(residual.time_s, residual.values)
    return [_slow_finding(data, residual, found)] if found else []


def _slow_finding(data: SensorData, residual: Residual, found: list[BlockMeans]) -> Finding:
    lengths = listed([figure(blocks.length_s) for blocks in found])
    excess = listed([figure(float(np.max(blocks.excess)), 2) for blocks in found])
    coloured = any((blocks.excess > blocks.chance()).any() for blocks in found)
    text = f"Means over {lengths} s of {BASES[residual.base]} vary {excess} times as "
    text += "much as means of white noise" + (": slow changes remain." if coloured else ".")
    level: Level = "note" if coloured else "ok"
    return Finding(SECTION, "slow", [_as_value(blocks) for blocks in found], "", text, level, data.sensor)


def _still(residual: Residual) -> bool:
    """Return whether the field varies little more than the noise."""
    return bool(np.all(residual.values.std(axis=0) < POLICY.still_noise * white_noise_std(residual.values)))


def _as_value(blocks: BlockMeans) -> dict[str, object]:
    return {"length_s": blocks.length_s, "blocks": blocks.blocks, "std_nT": blocks.std, "excess": blocks.excess}


def motion_edge_hz(data: SensorData) -> float:
    """Return the highest frequency of the motion: the measured field is ten times above the noise floor."""
    found = spectrum(data.fresh_s, data.series.mag_nT[data.fresh])
    if found is None or not np.isfinite(data.white_nT).all():
        return float("inf")
    floor = 2 * data.white_nT**2 / data.rate_hz
    above = np.any(found.background > POLICY.motion_ratio * floor, axis=1)
    return float(found.frequency_hz[np.flatnonzero(above)[-1]]) if above.any() else 0.0


def _tones(data: SensorData, residual: Residual) -> list[Finding]:
    if not data.even:
        return []
    found = tones(residual.time_s, residual.values)
    if not found:
        text = f"No tone in {BASES[residual.base]}."
        return [Finding(SECTION, "tones", [], "Hz", text, "ok", data.sensor)]
    edge_hz = motion_edge_hz(data)
    resolution = 2.0 / float(np.ptp(residual.time_s))
    value = [_tone_value(tone, edge_hz, data.rate_hz, resolution) for tone in found]
    clear = [one for one in value if not one["motion"]]
    listed = clear or value
    text = f"{counted(len(listed), 'tone')} in {BASES[residual.base]}: {_list_of(listed)}."
    text += _in_motion(len(clear), len(value) - len(clear), edge_hz)
    return [Finding(SECTION, "tones", value, "Hz", text, "note", data.sensor)]


def _list_of(listed: list[dict[str, object]]) -> str:
    """Return the strongest tones in words, and the number of further tones."""
    more = f" and {len(listed) - MOST_LISTED} more" if len(listed) > MOST_LISTED else ""
    return ", ".join(_tone_text(one) for one in listed[:MOST_LISTED]) + more


def _in_motion(clear: int, moving: int, edge_hz: float) -> str:
    """Return a remark on tones at frequencies of the motion."""
    if not clear:
        return " All may belong to the motion, which has these frequencies."
    return f" {moving} more below {figure(edge_hz, 2)} Hz may belong to the motion." if moving else ""


def _tone_value(tone: Tone, edge_hz: float, rate: float, resolution: float) -> dict[str, object]:
    mains = mains_named(tone, rate, resolution)
    motion = tone.frequency_hz <= edge_hz
    return {"frequency_hz": tone.frequency_hz, "amplitude_nT": tone.amplitude, "mains": list(mains), "motion": motion}


def _tone_text(one: dict[str, object]) -> str:
    mains, amplitude = one["mains"], np.asarray(one["amplitude_nT"])
    text = f"{figure(float(str(one['frequency_hz'])), 4)} Hz ({figure(float(np.linalg.norm(amplitude)), 2)} nT)"
    return f"{text}, where {' or '.join(mains)} would appear" if isinstance(mains, list) and mains else text


def _mains(data: SensorData, rate: float) -> Finding:
    aliases = mains_aliases(rate)
    fifty, sixty = aliases["50 Hz"], aliases["60 Hz"]
    text = f"At {figure(rate, 4)} Hz, mains of 50 Hz appear at {figure(fifty)} Hz and of 60 Hz at {figure(sixty)} Hz"
    hidden = [name for name in ("50 Hz", "60 Hz") if aliases[name] < POLICY.slow_mains * rate]
    text += f": {' and '.join(hidden)} look like a slow change of the offset" if hidden else ""
    return Finding(SECTION, "mains", aliases, "Hz", text + ".", "note" if hidden else "ok", data.sensor)
