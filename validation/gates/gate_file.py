"""Gate file `gates.toml`: calibrators, scenarios, limits and error rates of the verdicts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from scenarios.errors import InputError
from scenarios.load import load as load_file
from scenarios.problems import misfit
from scenarios.spec import DIALECT
from scenarios.table import Table
from validation.calibrating.external_command import Need
from validation.calibrating.processes import LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S, TIME_LIMIT_S
from validation.gates.power import MOST_TRIALS, USUAL_SPREAD
from validation.scoring.definitions import ScoreDefinition, score_definition

FALSE_FAIL_RATE, POWER, QUANTILE, SMALLEST_DEFECT, MARGIN = 1e-4, 0.99, 0.5, 1.5, 1.1
"""Defaults of a gate file; FALSE_FAIL_RATE: a run of all gates in 10,000 fails without a defect."""
FAILURE = "failure"
BOUND = "bound"
"""Reference that is no calibrator: the Cramer-Rao bound on the rms of the score."""
NOT_REPEATED = "wall_time"
"""Score without limits, since the value is not reproducible."""

Positive = Annotated[float, Field(gt=0, le=1e12)]
Part = Annotated[float, Field(ge=0.5, lt=1)]


class Gate(Table):
    """Gate: a quantile over runs of a calibrator's score on a scenario must stay below a limit.

    The limit is absolute (`limit`), `ratio` times the score of `reference` in the trial (or times the bound), or
    `margin` times the calibrator's score in the trial recorded in `baseline`. A trial without an estimate exceeds any
    limit.
    """

    name: str = Field(pattern=r"^\S(.*\S)?$", max_length=100, description="name in reports")
    scenario: str = Field(
        min_length=1, description="name in the catalogue, or a file in the directory of the gate file"
    )
    set_: tuple[str, ...] = Field((), alias="set", description="overrides, as with --set: KEY=VALUE")
    calibrator: str = Field(min_length=1, description="registered name or module:object; for an array name@sensor")
    exec_: str | None = Field(None, alias="exec", description="command that runs the calibrator, as with --exec")
    needs: tuple[Need, ...] = Field((), description="signals that the command needs, as in NAME:gyro=...")
    score: str = Field(description="score of scores.json, with or without unit; less must be better")
    limit: Positive | None = Field(None, description="in the score's unit")
    ratio: Positive | None = Field(None, description="limit as a multiple of the reference's score in the same trial")
    reference: str | None = Field(None, description="calibrator that ratio refers to; bound: the Cramer-Rao bound")
    baseline: str | None = Field(
        None, description="file written by --write-baseline, in the directory of the gate file"
    )
    margin: Positive = Field(MARGIN, description="limit as a multiple of the baseline's score in the same trial")
    quantile: Part = Field(QUANTILE, description="quantile of the score that must keep the limit; 0.5: the median")
    max_trials: int | None = Field(None, ge=1, le=MOST_TRIALS, description="default: as smallest_defect takes")
    smallest_defect: float | None = Field(
        None, gt=1, le=1e6, description=f"multiple of the limit that must be detected [default: {SMALLEST_DEFECT}]"
    )
    power: Part = Field(POWER, description="probability of detecting the smallest defect")
    spread: float = Field(
        USUAL_SPREAD, gt=0, le=10, description="standard deviation of ln(score) from trial to trial, for planning"
    )

    @field_validator("name")
    @classmethod
    def _printable(cls, text: str) -> str:
        if not text.isprintable():
            raise misfit((), "holds a character that cannot be printed, which junit.xml cannot hold", "leave it out")
        return text

    @field_validator("score")
    @classmethod
    def _has_a_better_end(cls, text: str) -> str:
        try:
            meaning = score_definition(text)
        except InputError as error:
            raise misfit((), error.what, error.do) from None
        if not meaning.lower or meaning.in_sample or meaning.name == NOT_REPEATED:
            why = "is not the same twice" if meaning.name == NOT_REPEATED else "has no better end"
            raise misfit((), f"{meaning.name} {why}, so that no limit holds for it", "take another score")
        return text

    @model_validator(mode="after")
    def _one_limit(self) -> Self:
        stated = [key for key in ("limit", "ratio", "baseline") if getattr(self, key) is not None]
        if len(stated) != 1:
            found = " and ".join(stated) or "none"
            do = "give one of limit, ratio with reference, baseline with margin"
            raise misfit((), f"one limit is wanted, found {found}", do)
        if (self.ratio is None) != (self.reference is None):
            raise misfit((), "ratio and reference go together", "add the other")
        return self

    @model_validator(mode="after")
    def _needs_of_a_command(self) -> Self:
        if self.needs and self.exec_ is None:
            raise misfit(("needs",), "needs applies to a command only", "add exec, or leave needs out")
        return self

    @property
    def command(self) -> str | None:
        """Command in the form of --exec, NAME:NEEDS=WORDS; None without exec."""
        if self.exec_ is None:
            return None
        name = self.calibrator.partition("@")[0]
        return f"{':'.join(filter(None, (name, ','.join(self.needs))))}={self.exec_}"

    @property
    def kind(self) -> Literal["limit", "ratio", "baseline"]:
        """Kind of the limit."""
        if self.limit is not None:
            return "limit"
        return "ratio" if self.ratio is not None else "baseline"

    @property
    def factor(self) -> float:
        """Limit in the unit of the score, or as a multiple of the reference score of the trial."""
        return self.limit or self.ratio or self.margin

    @property
    def score_definition(self) -> ScoreDefinition:
        """Definition of the score."""
        return score_definition(self.score)

    @property
    def unit(self) -> str:
        """Unit of the limit and the measured value, "" for a multiple."""
        return self.score_definition.unit if self.kind == "limit" else ""


class GateFile(Table):
    """All gates of a file, and the probability that a run fails although every calibrator keeps the limit."""

    false_fail_rate: float = Field(FALSE_FAIL_RATE, gt=0, lt=0.5, description="of all gates together")
    seed: int | None = Field(None, ge=0, description="of all trials; default: each scenario's own")
    time_limit_s: float = Field(
        TIME_LIMIT_S,
        ge=LEAST_TIME_LIMIT_S,
        le=MOST_TIME_LIMIT_S,
        description="for one fit of a calibrator that is not magbench's",
    )
    gate: tuple[Gate, ...] = Field(description="each a table [[gate]]")

    @model_validator(mode="after")
    def _unique_names(self) -> Self:
        names = [gate.name for gate in self.gate]
        if not names:
            raise misfit(("gate",), "there is no gate", "add a table [[gate]]")
        for index, name in enumerate(names):
            if name in names[:index]:
                raise misfit(("gate", index, "name"), f"{name!r} is the name of another gate", "choose another")
        return self

    @property
    def rate(self) -> float:
        """Rate of false failures of each gate, so that all gates together keep false_fail_rate (Bonferroni)."""
        return self.false_fail_rate / len(self.gate)


def load_gates(path: Path) -> GateFile:
    """Read a gate file strictly; InputError names the invalid key."""
    return load_file(path, GateFile)


def json_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a gate file, for editors."""
    return {"$schema": DIALECT, **GateFile.model_json_schema(by_alias=True)}
