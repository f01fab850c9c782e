"""Numbers that decide in the assessment of calibrations: value, meaning, and origin of each."""

from __future__ import annotations

from dataclasses import dataclass

from validation.policy import number

RUN = "benchmarks/assessment"


@dataclass(frozen=True)
class AssessmentPolicy:
    """Limits that `validation.assessment` applies; shares lie between 0 and 1."""

    # posterior of offset, matrix and disturbances
    soft_iron: float = number(0.05, "standard deviation of S, over its scale, where the motion does not determine S")
    spreads: tuple[float, ...] = number(
        (1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2),
        "tried standard deviations of a disturbance's coefficients, in parts of the field",
        run=RUN,
    )
    absent: float = number(0.5, "probability beforehand that a disturbance is absent", run=RUN)
    least_weight: float = number(0.02, "probability below which a spread is left out of the mixture", run=RUN)
    least_scatter: float = number(
        1.0, "scatter of the legs over white noise at least: noise of instruments is not bluer than white", run=RUN
    )
    draws: int = number(3000, "draws of offset and matrix from which the intervals are taken")
    varies: float = number(1e-6, "rms change of a current or temperature below which no disturbance follows")

    # heading error
    sure: float = number(0.95, "probability of the intervals, and of an answer to a tolerance", run=RUN)
    tolerance_deg: float = number(2.0, "heading error that a compass may have, where no tolerance is asked for")
    dip_deg: float = number(60.0, "dip of the field where neither a vector nor an accelerometer tells: mid latitudes")
    lean_deg: float = number(2.0, "standard deviation of a vehicle's mean tilt in a level turn, where nothing tells it")
    attitude_deg: float = number(0.5, "standard deviation of a mean tilt that the attitude tells", run=RUN)
    level: float = number(0.5, "probability beforehand that a vehicle turns without a mean tilt", run=RUN)
    least_level: float = number(0.05, "horizontal part of the unit field below which there is no heading")
    model_std_nT: float = number(150.0, "standard deviation of a world model's components: magnetised rocks beneath")

    # trust
    leg_worse: float = number(1.5, "rms of a held-out leg over the median leg's above which the leg disagrees")
    most_agree: float = number(0.75, "share of agreeing legs from which on legs speak for the calibration")
    least_agree: float = number(0.5, "share of agreeing legs below which a calibration is not trusted")
    least_face: float = number(0.2, "share of a face's directions that the recording shows, below which one is missing")
    least_coverage: float = number(0.3, "share of the sphere that the recording shows, below which trust is lowered")
    most_scatter: float = number(9.0, "scatter of the legs over white noise above which trust is lowered")

    # next leg
    longest_s: float = number(600.0, "time that the leg to be flown next may last")
    decided: float = number(0.5, "share of the tolerance that the error after the next leg should be, to answer yes")


ASSESSMENT = AssessmentPolicy()
"""The limits in use."""
