"""Noise floor, slow changes and tones of what a base model leaves."""

from __future__ import annotations

import numpy as np

from calib.numerics.noise import white_noise_std
from validation.inspection.finding import Finding, Level
from validation.inspection.sensor_data import Look, Residual
from validation.signals.noise import BlockMeans, block_means
from validation.signals.tones import Tone, mains_aliases, mains_named, spectrum, tones
from validation.text import counted, figure, figures, listed

SECTION = "noise"
BASES = {
    "attitude": "what the attitude leaves unexplained",
    "strength": "the strength after the ellipsoid fit",
    "mean": "the measured field",
}
MOTION_RATIO = 10.0
"""Power over the noise floor that is motion's, not noise's."""
MOST_LISTED = 5


def noise_findings(look: Look) -> list[Finding]:
    """White noise, what is left of the field, block means, tones and where the mains would appear."""
    found = [_white(look)]
    if look.residual is not None:
        found += [_left(look, look.residual), *_slow(look, look.residual), *_tones(look, look.residual)]
    if look.rate_hz > 2 and look.even:
        found.append(_mains(look, look.rate_hz))
    return [finding for finding in found if finding is not None]


def _white(look: Look) -> Finding | None:
    if len(look.series) < 12:
        return None
    value, rate = look.white_nT.tolist(), look.rate_hz
    if not np.isfinite(look.white_nT).all():
        text = "Neighbouring samples differ by more than noise: it moved too far between them to tell the noise."
        return Finding(SECTION, "white", value, "nT", text, "note", look.sensor)
    steps = np.array([lattice.step if lattice else 0.0 for lattice in look.lattices])
    if np.any(look.white_nT < 0.3 * steps):
        text = "Most neighbouring samples are equal: the noise is below the least significant bit."
        return Finding(SECTION, "white", value, "nT", text, "note", look.sensor)
    density = figures(look.white_nT * np.sqrt(2 / rate), 2)
    text = f"White noise {figures(look.white_nT)} nT rms a sample ({density} nT/sqrt(Hz))"
    if not look.settled:
        text += " at most: the estimate falls with each further difference, so the noise is not white, "
        text += "or the motion is fast"
    return Finding(SECTION, "white", value, "nT", text + ".", "ok" if look.settled else "note", look.sensor)


def _left(look: Look, residual: Residual) -> Finding | None:
    """Rms of the residual, against the white noise in it."""
    if residual.base == "mean":
        return None
    rms = np.sqrt(np.mean(residual.values**2, axis=0))
    white = white_noise_std(residual.values)
    value = {"base": residual.base, "rms_nT": rms.tolist(), "white_nT": white.tolist()}
    ratio = float(np.max(rms / white)) if np.all(white > 0) else float("nan")
    text = f"{BASES[residual.base][0].upper()}{BASES[residual.base][1:]} is {figures(rms)} nT rms"
    text += f", {figure(ratio, 2)} times its white noise" if np.isfinite(ratio) else ""
    level: Level = "note" if ratio > 2 else "ok"
    return Finding(SECTION, "residual", value, "nT", text + ".", level, look.sensor)


def _slow(look: Look, residual: Residual) -> list[Finding]:
    """Block means against white noise, of everything but the bare field in motion."""
    if residual.base == "mean" and not _still(residual):
        return []
    found = block_means(residual.time_s, residual.values)
    return [_slow_finding(look, residual, found)] if found else []


def _slow_finding(look: Look, residual: Residual, found: list[BlockMeans]) -> Finding:
    lengths = listed([figure(blocks.length_s) for blocks in found])
    excess = listed([figure(float(np.max(blocks.excess)), 2) for blocks in found])
    coloured = any((blocks.excess > blocks.chance()).any() for blocks in found)
    text = f"Means over {lengths} s of {BASES[residual.base]} vary {excess} times as "
    text += "much as means of white noise" + (": slow changes are left." if coloured else ".")
    level: Level = "note" if coloured else "ok"
    return Finding(SECTION, "slow", [_as_value(blocks) for blocks in found], "", text, level, look.sensor)


def _still(residual: Residual) -> bool:
    """Whether the field varies little more than its noise."""
    return bool(np.all(residual.values.std(axis=0) < 3 * white_noise_std(residual.values)))


def _as_value(blocks: BlockMeans) -> dict[str, object]:
    return {"length_s": blocks.length_s, "blocks": blocks.blocks, "std_nT": blocks.std, "excess": blocks.excess}


def motion_edge_hz(look: Look) -> float:
    """The highest frequency at which the measured field is far above its noise floor: there the vehicle moves."""
    found = spectrum(look.fresh_s, look.series.mag_nT[look.fresh])
    if found is None or not np.isfinite(look.white_nT).all():
        return float("inf")
    floor = 2 * look.white_nT**2 / look.rate_hz
    above = np.any(found.background > MOTION_RATIO * floor, axis=1)
    return float(found.frequency_hz[np.flatnonzero(above)[-1]]) if above.any() else 0.0


def _tones(look: Look, residual: Residual) -> list[Finding]:
    if not look.even:
        return []
    found = tones(residual.time_s, residual.values)
    if not found:
        text = f"No tone stands out of {BASES[residual.base]}."
        return [Finding(SECTION, "tones", [], "Hz", text, "ok", look.sensor)]
    edge_hz = motion_edge_hz(look)
    resolution = 2.0 / float(np.ptp(residual.time_s))
    value = [_tone_value(tone, edge_hz, look.rate_hz, resolution) for tone in found]
    clear = [one for one in value if not one["motion"]]
    listed = clear or value
    text = f"{counted(len(listed), 'tone')} in {BASES[residual.base]}: {_list_of(listed)}."
    text += _in_motion(len(clear), len(value) - len(clear), edge_hz)
    return [Finding(SECTION, "tones", value, "Hz", text, "note", look.sensor)]


def _list_of(listed: list[dict[str, object]]) -> str:
    """The strongest tones, and how many more there are."""
    more = f" and {len(listed) - MOST_LISTED} more" if len(listed) > MOST_LISTED else ""
    return ", ".join(_tone_text(one) for one in listed[:MOST_LISTED]) + more


def _in_motion(clear: int, moving: int, edge_hz: float) -> str:
    """What is said of tones at frequencies at which the vehicle moves."""
    if not clear:
        return " All are at frequencies of the motion and may belong to it."
    return f" {moving} more below {figure(edge_hz, 2)} Hz may belong to the motion." if moving else ""


def _tone_value(tone: Tone, edge_hz: float, rate: float, resolution: float) -> dict[str, object]:
    mains = mains_named(tone, rate, resolution)
    motion = tone.frequency_hz <= edge_hz
    return {"frequency_hz": tone.frequency_hz, "amplitude_nT": tone.amplitude, "mains": list(mains), "motion": motion}


def _tone_text(one: dict[str, object]) -> str:
    mains, amplitude = one["mains"], np.asarray(one["amplitude_nT"])
    text = f"{figure(float(str(one['frequency_hz'])), 4)} Hz ({figure(float(np.linalg.norm(amplitude)), 2)} nT)"
    return f"{text}, where {' or '.join(mains)} would appear" if isinstance(mains, list) and mains else text


def _mains(look: Look, rate: float) -> Finding:
    aliases = mains_aliases(rate)
    fifty, sixty = aliases["50 Hz"], aliases["60 Hz"]
    text = f"At {figure(rate, 4)} Hz the mains of 50 Hz appear at {figure(fifty)}, of 60 Hz at {figure(sixty)} Hz"
    hidden = [name for name in ("50 Hz", "60 Hz") if aliases[name] < 0.002 * rate]
    text += f": {' and '.join(hidden)} look like a slow change of the offset" if hidden else ""
    return Finding(SECTION, "mains", aliases, "Hz", text + ".", "note" if hidden else "ok", look.sensor)
