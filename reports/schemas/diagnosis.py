"""JSON of `magbench diagnose`: diagnosis.json, of one recording or of several."""

from __future__ import annotations

from typing import Any

from diagnosis.verdict import Verdict
from reports.schemas.base import IntervalJson, ResultTable, key, where_told
from reports.schemas.calibration import PartChangeJson

VERDICTS: dict[str, Any] = {"enum": [str(verdict) for verdict in Verdict]}
Numbers = float | list[Any] | str | None
"""A number, a vector or a matrix; a text for a name, such as a channel's."""


class ParameterJson(ResultTable):
    """A parameter of an effect with its 95 % interval; no interval where undetermined."""

    value: Numbers = key("estimate")
    low: Numbers = key("lower end")
    high: Numbers = key("upper end")
    unit: str = key("unit")


class FurtherEffectJson(ResultTable):
    """A further part of a cause, such as a second motor or a harmonic."""

    name: str = key("effect")
    parameters: dict[str, Any] = key("values by name")


class StretchJson(ResultTable):
    """A part of the run; all null for the whole run."""

    interval_s: list[float] | None = key("begin and end")
    phase: str | None = key("phase of the motion in this part")
    heading_deg: float | None = key("compass heading of the mean forward axis; null where the vehicle turns")


class NamedEffectJson(StretchJson):
    """An effect that the model lacks or has otherwise."""

    name: str = key("effect, see docs/effects.md")
    alternatives: list[str] = key("effects that the recording cannot tell from this one")
    rivals: list[str] = key("channels that may drive the effect as well")
    parameters: dict[str, ParameterJson] = key("parameters by name")
    also: list[FurtherEffectJson] = key("further parts of the cause")
    evidence: str = key("whether other recordings confirm the effect: single-run, transferred, not-transferred, some")
    how: str = key("kind of evidence: held-out, direct, base, spectrum or curve")
    evidence_nats: float | None = key("gain of log-likelihood on held-out data")
    needed_nats: float | None = key("gain that was required")
    strength_sigma: float | None = key("rms of the effect, in units of the noise")
    stated: dict[str, Any] | None = key("the model's own parameters of this effect; null where the model lacks it")
    corrected: dict[str, Any] | None = key("the parameters of this effect in the new model; null where it lacked it")
    only_in: str | None = where_told("the recording that alone shows the effect (of several recordings)")


class ChannelShareJson(ResultTable):
    """A channel that the gap follows."""

    channel: str = key("channel")
    frame: str = key("frame in which the gap follows: body or world")
    score: float | None = key("share of the gap, 0 to 1")


class GapPartJson(StretchJson):
    """A part of the run with a steady size of the gap."""

    rms_nT: float | None = key("rms of the residual")
    rms_sigma: float | None = key("the same in units of the noise")


class ResidualSizeJson(ResultTable):
    """Rms of measured minus simulated on held-out segments."""

    rms_nT: float | None = key("in nT")
    rms_sigma: float | None = key("in units of the noise")


class ResimulatedJson(ResultTable):
    """What the written model leaves of the whole recording, without any fit."""

    rms_nT: float = key("in nT")


class PooledGapJson(ResultTable):
    """Rms of the residual before and after the diagnosis."""

    before: ResidualSizeJson = key("of the model as given, iron refitted")
    after: ResidualSizeJson = key("with the named effects")
    explained: float | None = key("explained share of the gap's power beyond the noise; null where there is no gap")


class GapJson(PooledGapJson):
    """Rms of the residual before and after, and of the new model simulated anew."""

    resimulated: ResimulatedJson | None = key("rms that model.toml leaves of the whole recording; null where not run")


class CandidateJson(ResultTable):
    """An effect that was tried in the first round."""

    name: str = key("effect")
    evidence_nats: float | None = key("gain of log-likelihood on held-out data")
    needed_nats: float | None = key("gain that was required")
    strength_sigma: float | None = key("rms of the effect, in units of the noise")
    outcome: str = key("what became of the candidate, in words")


class NextFlightJson(ResultTable):
    """The next flight, which tells an effect from a look-alike."""

    tells: str = key("named effect")
    from_: str = key("look-alike", alias="from")
    leg: str = key("leg in words")
    leg_s: float = key("duration of the leg")
    nats: float | None = key("evidence that the leg gives")
    needed_s: float | None = key("flying time that separates both")
    scenario: str = key("file with the leg")


class ChangedIronJson(PartChangeJson):
    """A change of the stated calibration, with the effect that stands for it."""

    effect: str = key("effect")


class StatedCalibrationJson(ResultTable):
    """Whether the iron of the calibration that the model states still holds."""

    recording: str = key("recording")
    verdict: str = key("valid, changed or cannot tell")
    sentence: str = key("in words")
    heading_error_deg: IntervalJson = key("heading error of the stated calibration")
    parts: list[PartChangeJson] = key("every part that the recording determines")
    notes: list[str] = key("how the calibration was read")
    changed: list[ChangedIronJson] = key("what changed, as effects")


class DiagnoseJson(ResultTable):
    """Diagnosis of a recording against a model."""

    verdict: str = key("the answer in one word, see docs/verdicts.md", json_schema_extra=VERDICTS)
    sentence: str = key("the answer in words")
    mode: str = key("what is compared: vector, or strength where the attitude is not known")
    reference: list[str] = key("corrections of the given field that were fitted, in words")
    effects: list[NamedEffectJson] = key("effects that the model lacks, strongest evidence first")
    where: list[ChannelShareJson] = key("channels that the gap follows")
    when: list[GapPartJson] = key("parts of the run with a steady size of the gap")
    gap: GapJson = key("the residual before and after")
    left: list[str] = key("structure left in the residual; empty where the residual is white")
    candidates: list[CandidateJson] = key("every effect tried in the first round, strongest first")
    not_observable: list[str] = key("effects that this recording cannot show, and why")
    advice: list[str] = key("what to do next")
    next: NextFlightJson | None = key("what to fly next; null where there is no look-alike")
    stated_calibration: list[StatedCalibrationJson] | None = where_told("where a calibration is stated")
    model_out: str | None = where_told("file with the new model (with --json)")


class AgreementJson(ResultTable):
    """Whether the coefficients of the recordings agree."""

    chi2: float | None = key("chi-squared")
    degrees: int | None = key("degrees of freedom")
    p: float | None = key("probability of such a difference by chance")


class InRecordingJson(ResultTable):
    """A common effect in one recording, or at one sensor."""

    name: str = key("recording or sensor")
    says: str = key("present, absent, cannot tell or causes not recorded")
    parameters: dict[str, ParameterJson] = key("parameters there; empty where the effect was not fitted")
    evidence_nats: float | None = key("gain of log-likelihood there")


class CommonEffectJson(ResultTable):
    """An effect of several recordings, or of several sensors of an array."""

    name: str = key("effect")
    alternatives: list[str] = key("effects that the recordings cannot tell from this one")
    rivals: list[str] = key("channels that may drive the effect as well")
    parameters: dict[str, ParameterJson] = key("common parameters by name")
    evidence: str = key("whether recordings confirm the effect: transferred, not-transferred, some, single-run")
    among_sensors: str | None = where_told("whether the sensors of an array agree")
    how: str = key("kind of evidence: held-out, direct, base, spectrum or curve")
    evidence_nats: float | None = key("gain of log-likelihood on held-out data")
    strength_sigma: float | None = key("rms of the effect, in units of the noise")
    agreement: AgreementJson = key("test of equal coefficients")
    recordings: list[InRecordingJson] | None = where_told("the effect in each recording")
    sensors: list[InRecordingJson] | None = where_told("the effect at each sensor of an array")


class RecordingDiagnosisJson(ResultTable):
    """The diagnosis of one of several recordings, or of one sensor."""

    name: str = key("recording or sensor")
    verdict: str = key("own verdict", json_schema_extra=VERDICTS)
    sentence: str = key("own answer in words")
    gap: GapJson = key("own gap")
    gap_together: PooledGapJson = key("gap with the common effects")
    effects: list[NamedEffectJson] = key("own effects")
    coefficients: dict[str, dict[str, ParameterJson]] = key("parameters of the common effects here")


class DiagnoseSeveralJson(ResultTable):
    """Diagnosis of several recordings, or of the sensors of an array, together."""

    verdict: str = key("the answer in one word, see docs/verdicts.md", json_schema_extra=VERDICTS)
    sentence: str = key("the answer in words")
    mode: str = key("what is compared: vector or strength")
    effects: list[NamedEffectJson | CommonEffectJson] = key("own effects with `only_in`, then common ones")
    not_borne_out: list[CommonEffectJson] = key("effects that a single recording shows and others contradict")
    where: list[ChannelShareJson] = key("channels that the gap follows")
    gap: PooledGapJson = key("the residual before and after, all recordings")
    left: list[str] = key("structure left in the residual")
    not_observable: list[str] = key("effects that these recordings cannot show")
    advice: list[str] = key("what to do next")
    recordings: list[RecordingDiagnosisJson] | None = where_told("each recording")
    sensors: list[RecordingDiagnosisJson] | None = where_told("each sensor of an array")
    worst: str | None = where_told("recording with the largest unexplained gap, where the recordings differ")
    stated_calibration: list[StatedCalibrationJson] | None = where_told("where a calibration is stated")
    model_out: str | None = where_told("file with the new model (with --json)")
