"""Assessment in words and as plain values."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from scenarios.plain import json_ready
from validation.assessment.assessment import Assessment
from validation.assessment.evidence import CalibrationAssessment
from validation.assessment.heading_error import HeadingError
from validation.assessment.judgement import ToleranceAnswer
from validation.text import figure, sentence

Plain = dict[str, Any]


def verdict(found: Assessment) -> str:
    """Return the verdict in a sentence: heading error, use, quality and trust of the recommended calibration."""
    best = found.best
    if best is None or best.heading is None:
        return f"no calibration can be used; trust {found.trust.word}: {'; '.join(found.trust.doubts)}"
    use = f"; {found.use.sentence}" if found.use else ""
    axes = ", once the axes are the vehicle's" if best.wrong_axes else ""
    return f"{heading_text(best.heading)}{axes}{use}; quality {best.quality}, {trust_text(best)}"


def heading_text(error: HeadingError) -> str:
    """Return "heading within 1.2 deg [0.9, 1.7] on a level survey", with the dip where it was assumed."""
    ends = ", ".join(figure(end, 2) for end in (error.low, error.high))
    assumed = f" at a dip of {figure(error.dip_deg)} deg, which is assumed" if error.flight.source == "assumed" else ""
    return f"heading within {figure(error.value, 2)} deg [{ends}] on a level survey{assumed}"


def trust_text(one: CalibrationAssessment) -> str:
    """Return "trust high: 3 of 4 legs agree", or what speaks against it."""
    agree = (one.agreement.sentence,) if one.agreement else ()
    why = one.trust.doubts or agree
    return f"trust {one.trust.word}" + (f": {'; '.join(why)}" if why else "")


def lines(found: Assessment) -> list[str]:
    """Return the verdict, what it leaves out, strength before and after, coverage, and the answer to a tolerance."""
    best = found.best
    told = [sentence(verdict(found))]
    if best is not None:
        told += [sentence(text) for text in _beside(best)]
    if found.tolerance is not None:
        told += [sentence(text) for text in tolerance_texts(found.tolerance)]
    return told


def _beside(best: CalibrationAssessment) -> list[str]:
    told = [f"these figures are of {best.name}"]
    if best.heading is not None and not best.heading.turn_included:
        told.append("a yaw misalignment of the sensor in the vehicle is not included: the strength does not tell it")
    if best.strength is not None:
        before, after = (figure(one) for one in (best.strength.before_nT, best.strength.after_nT))
        told.append(f"the strength deviates by {before} nT rms as measured, by {after} nT on held-out legs after")
    missing = f"; hardly met: {', '.join(best.coverage.missing)}" if best.coverage.missing else ""
    told.append(f"the directions cover {100 * best.coverage.share:.0f} % of the sphere{missing}")
    return told


def tolerance_texts(found: ToleranceAnswer) -> list[str]:
    """Return the answer to a tolerance, its causes and the next leg, as clauses."""
    limit = f"a heading error below {figure(found.tolerance_deg)} deg"
    probability = f"probability {figure(100 * found.probability, 2)} %"
    told = [f"{limit}: {found.answer} ({probability})"]
    if found.causes is not None:
        parts = [f"{_called(name)} {figure(value, 2)} deg" for name, value in asdict(found.causes).items() if value > 0]
        told.append(f"what makes the error: {', '.join(parts)}")
    if found.wrong_axes:
        told.append(f"mend the axes first: {found.wrong_axes}")
    elif found.next_leg is not None:
        told.append(found.next_leg.sentence)
    elif found.answer == "undecidable" and found.causes is None:
        told.append("no calibration can be judged: do what their reasons say, and record again")
    elif found.answer == "undecidable":
        told.append("no leg by hand of ten minutes would decide: reduce the largest cause")
    return told


def _called(name: str) -> str:
    return name.replace("_", " ")


def calibration_summary(one: CalibrationAssessment) -> Plain:
    """Return the keys that an assessment adds to a calibration's JSON."""
    heading, strength = one.heading, one.strength
    plain: Plain = {
        "heading_error_deg": None
        if heading is None
        else {
            "value": heading.value,
            "low": heading.low,
            "high": heading.high,
            "dip_deg": heading.dip_deg,
            "dip_from": heading.flight.source,
            "yaw_misalignment_included": heading.turn_included,
        },
        "strength_rms": None
        if strength is None
        else {"before": strength.before_nT, "after_held_out": strength.after_nT},
        "coverage": one.coverage.share,
        "missing_faces": list(one.coverage.missing),
        "legs": None if one.agreement is None else asdict(one.agreement),
        "quality": one.quality,
        "trust": one.trust.word,
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def summary(found: Assessment) -> Plain:
    """Return the top-level keys of the JSON: verdict, use, quality, trust and tolerance."""
    plain: Plain = {
        "verdict": verdict(found),
        "recommended": found.recommended or None,
        "use": found.use and found.use.kind,
        "quality": found.quality,
        "trust": found.trust.word,
        "doubts": list(found.trust.doubts),
        "tolerance": None if found.tolerance is None else _tolerance(found.tolerance),
    }
    return json_ready(plain)  # type: ignore[no-any-return]


def _tolerance(found: ToleranceAnswer) -> Plain:
    leg = found.next_leg
    return {
        "tolerance_deg": found.tolerance_deg,
        "answer": found.answer,
        "probability": found.probability,
        "causes": None if found.causes is None else {_called(k): v for k, v in asdict(found.causes).items()},
        "next_leg": None if leg is None else {"sentence": leg.sentence, "duration_s": leg.duration_s},
    }
