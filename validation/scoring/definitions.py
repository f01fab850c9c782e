"""Definitions of all scores: name, unit, wording and meaning."""

from __future__ import annotations

from dataclasses import dataclass

from scenarios.errors import InputError
from scenarios.names import closest


@dataclass(frozen=True)
class ScoreDefinition:
    """Definition of a score: name and unit as in scores.json.

    short : title of a table column. setting : the wording after a value, "on a level survey". explained : the full
    definition. lower : whether a lower value is better, None for counts and claims. in_sample : computed on the
    fitted recording, so never used for ranking.
    """

    name: str
    unit: str
    short: str
    setting: str
    explained: str
    lower: bool | None = True
    in_sample: bool = False

    @property
    def column(self) -> str:
        """Column name in tables: name and unit."""
        return f"{self.name}_{self.unit}" if self.unit else self.name


SCORE_DEFINITIONS: dict[str, ScoreDefinition] = {
    one.name: one
    for one in (
        ScoreDefinition(
            "holdout_level_component_rms", "nT", "level survey", "on a level survey",
            "rms error of a component of the corrected field on a level survey: all headings, roll and pitch within 3°",
        ),
        ScoreDefinition(
            "holdout_sphere_component_rms", "nT", "all attitudes", "over all attitudes",
            "rms error of a component of the corrected field, 2000 attitudes over the whole sphere",
        ),
        ScoreDefinition(
            "heading_rms", "deg", "heading", "of the heading",
            "rms error of the heading on a level survey, from the corrected field with true tilt",
        ),
        ScoreDefinition(
            "anomaly_rms", "nT", "anomaly", "of an anomaly",
            "rms error of a dipole's total-field anomaly (peak 100 nT) along a wobbling survey line",
        ),
        ScoreDefinition(
            "figure_of_merit", "nT", "figure of merit", "of the figure of merit",
            "what twelve manoeuvres leave in the corrected total field, peak to peak, summed: roll, pitch and yaw "
            "on four headings",
        ),
        ScoreDefinition("offset_error", "nT", "offset", "of the offset", "length of the estimated offset's error"),
        ScoreDefinition(
            "offset_error_axis_rms", "nT", "offset, an axis", "of an axis' offset", "offset error over √3: an axis' rms"
        ),
        ScoreDefinition(
            "offset_inside_95", "", "offset inside claim", "of claims",
            "1 where the true offset lies in the claimed 95 % ellipsoid, else 0: 95 of 100 where claims are true; only "
            "for methods that claim one",
            None,
        ),
        ScoreDefinition(
            "offset_nees", "", "squared error by claim", "by the claim",
            "offset error squared in units of the claimed covariance: 3 on the average where claims are true",
            None,
        ),
        ScoreDefinition(
            "matrix_error", "", "matrix", "of the matrix",
            "size (Frobenius norm) of estimated matrix times true matrix minus identity",
        ),
        ScoreDefinition(
            "holdout_level_norm_rms", "nT", "strength, level survey", "of the strength on a level survey",
            "rms error of the corrected field's strength on a level survey: all headings, roll and pitch within 3°",
        ),
        ScoreDefinition(
            "holdout_sphere_norm_rms", "nT", "strength, all attitudes", "of the strength over all attitudes",
            "rms error of the corrected field's strength, 2000 attitudes over the whole sphere",
        ),
        ScoreDefinition("failure", "", "failures", "of trials", "1 where the status is not ok, else 0"),
        ScoreDefinition("iterations", "", "iterations", "rounds", "rounds that the method took", None),
        ScoreDefinition("wall_time", "s", "time", "a fit", "time of the fit"),
        ScoreDefinition(
            "in_sample_norm_rms", "nT", "in-sample", "in-sample",
            "rms of the corrected strength minus the field's on the recording that was fitted: small however wrong the "
            "parameters are, so that it ranks nothing",
            None,
            in_sample=True,
        ),
    )
}  # fmt: skip
"""Every score by name, in the order of tables."""


def score_definition(text: str, where: str = "score") -> ScoreDefinition:
    """Return the score of a name, with unit (`heading_rms_deg`) or without; InputError lists similar names."""
    for one in SCORE_DEFINITIONS.values():
        if text in (one.name, one.column):
            return one
    names = [one.column for one in SCORE_DEFINITIONS.values()]
    raise InputError(f"no score is called {text!r}", where=where, do=closest(text, names, most=len(names)))
