"""Kinds of wrong answers that were seen once, each with recordings drawn anew: the share that is right now.

    python -m benchmarks.diagnosis.kinds --first 5000 --trials 20 -o out/kinds
    python -m benchmarks.diagnosis.kinds --only step,tone --trials 5

The trials `stated` of the bench measure one more kind: a wrong effect of the model. Trials land one by one; the same
command goes on where it was stopped.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # a trial a core; before numpy is imported
    os.environ.setdefault(_name, "1")

import argparse  # noqa: E402
from collections.abc import Callable, Iterator, Sequence  # noqa: E402
from dataclasses import dataclass, replace  # noqa: E402
from operator import attrgetter  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402

from benchmarks.diagnosis.motion import flown  # noqa: E402
from benchmarks.diagnosis.resumed import resumed  # noqa: E402
from benchmarks.diagnosis.trials import measured  # noqa: E402
from benchmarks.diagnosis.truth import BASE, NOISE_NT, Tables, beyond_base  # noqa: E402
from diagnosis.library.candidates import select_samples  # noqa: E402
from diagnosis.problem.formulation import pose_model  # noqa: E402
from diagnosis.result import Diagnosis, EvidenceKind  # noqa: E402
from diagnosis.several.workflow import diagnose_together  # noqa: E402
from diagnosis.workflow import diagnose  # noqa: E402
from recordings import Recording  # noqa: E402
from recordings.channels import TEMPERATURE  # noqa: E402
from scenarios.arrays import Array  # noqa: E402
from sim.effects import of_sign  # noqa: E402
from sim.rotation import to_body  # noqa: E402
from sim.scenario import ModelSpec  # noqa: E402
from sim.state import State  # noqa: E402
from validation.signals.amplitude import rms  # noqa: E402

VEHICLES = ("auv", "quadrotor")
LENGTH = 6000
"""Samples of a flight that a trial takes, from a start drawn for it."""
SAME = 0.05
"""Relative difference up to which two gaps are the same."""
FACTOR = 2.0
"""Ratio between a rate that is told and the true one, up to which it is right."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Flight:
    """A part of a vehicle's flight without errors, the true state along it, the field, and the trial's numbers."""

    recording: Recording
    state: State
    field_enu_nT: Array
    seed: int
    rng: np.random.Generator

    @classmethod
    def drawn(cls, kind: str, seed: int) -> Flight:
        """The flight of a trial, by its kind and seed."""
        rng = np.random.default_rng([seed, *kind.encode()])
        recording, state, field_enu_nT = flown(VEHICLES[seed % len(VEHICLES)])
        begin = int(rng.integers(0, max(1, len(recording) - LENGTH)))
        part = slice(begin, begin + LENGTH)
        chosen = np.zeros(len(recording), bool)
        chosen[part] = True
        return cls(recording.taken(chosen), select_samples(state, part), field_enu_nT, seed, rng)

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        return float(np.ptp(self.recording.time_s))

    def vector(self, size: float) -> Array:
        """A vector (3,) of a size in a direction drawn evenly."""
        way = self.rng.normal(size=3)
        return np.asarray(size * way / np.linalg.norm(way))

    def with_effects(self, tables: Tables, added_nT: Array | float = 0.0, seed: int | None = None) -> Recording:
        """The recording with the base's iron and noise, effects (tables), and a further disturbance (n, 3)."""
        mag_nT = measured(tables, self.state, self.seed if seed is None else seed) + added_nT
        return replace(self.recording, mag_nT=mag_nT)

    def model(self, tables: Tables | None = None) -> ModelSpec:
        """The model of the base, with effects that it states."""
        return ModelSpec.model_validate(
            {"effects": BASE | (tables or {}), "field": {"enu_nT": self.field_enu_nT.tolist()}}
        )

    def with_temperature(self) -> Flight:
        """The same with a temperature that goes up and down by some kelvins."""
        degC = 18.0 + self.course()
        state = replace(self.state, channels={**self.state.channels, TEMPERATURE: degC})
        return replace(self, state=state, recording=replace(self.recording, temperature_degC=degC))

    def course(self) -> Array:
        """A smooth course (n,) of no effect's form: waves of 40 to 200 s."""
        periods_s, phases = self.rng.uniform(40.0, 200.0, 4), self.rng.uniform(0.0, 2 * np.pi, 4)
        return np.asarray(np.sin(2 * np.pi * self.state.time_s[:, None] / periods_s + phases).sum(axis=1))


Measure = Callable[[Flight], tuple[bool, str]]
"""A trial -> whether the answer is right, and what it was."""


def lot(flight: Flight) -> tuple[bool, str]:
    """One of three recordings has a cause of its own: never `none`."""
    kinds: tuple[Tables, ...] = (
        {"offset_jump": {"time_s": 0.5 * flight.duration_s, "step_nT": flight.vector(8.0).tolist()}},
        {"motor_current": {"gain_nT_A": flight.vector(6.0).tolist()}},
        {"hard_iron": {"offset_nT": flight.vector(30.0).tolist()}},
        {"spikes": {"rate_hz": 0.1, "amplitude_nT": 100.0}},
    )
    own = kinds[flight.seed // len(VEHICLES) % len(kinds)]
    recordings = [flight.with_effects({} if k else own, seed=10 * flight.seed + k) for k in range(3)]
    problems = [pose_model(one, flight.model(), None, None) for one in recordings]
    found = diagnose_together(["a", "b", "c"], problems, flight.model())
    return found.verdict != "none", f"{next(iter(own))}: {found.verdict}"


def body_beside_spikes(flight: Flight) -> tuple[bool, str]:
    """A strong body beside the path of a log with spikes: named, its moment to a fifth."""
    at = flight.state.pos_enu_m[len(flight.state) // 2] + np.array([3.0, 2.0, -4.0]) * flight.rng.uniform(0.8, 1.2)
    moment = flight.vector(20.0)
    found = _diagnosed(
        flight,
        {
            "local_dipole": {"position_enu_m": at.tolist(), "moment_A_m2": moment.tolist()},
            "spikes": {"rate_hz": 0.1, "amplitude_nT": 100.0},
        },
    )
    body = next((cause.effect for cause in found.named if cause.name == "local_dipole"), None)
    size = 0.0 if body is None else float(np.linalg.norm(body.coefficients()))
    return abs(size - 20.0) < 4.0, f"{_told(found)}, moment {size:.1f}"


def weak_driver(flight: Flight) -> tuple[bool, str]:
    """A logged channel that drives 0.15 to 0.3 sigma in no effect's way: at exit 0 no name without the channel."""
    u = flight.course()
    added_nT = np.outer(np.sign(u) * np.sqrt(np.abs(u)), flight.vector(1.0))
    added_nT *= flight.rng.uniform(0.15, 0.3) / beyond_base(flight.state.field_nT + added_nT, flight.state.field_nT)
    given = flight.with_effects({}, added_nT)
    found = diagnose(replace(given, channels={**given.channels, "pump": u}), flight.model())
    beside_it = any("pump" in cause.rivals for cause in found.named)
    return beside_it or not (found.verdict.explained and found.named), _told(found)


def step(flight: Flight) -> tuple[bool, str]:
    """A step of 3 to 10 times the whole noise in Gauss-Markov noise of 1 to 10 s: named."""
    slow_nT, tau_s = NOISE_NT * flight.rng.uniform(0.5, 2.0), flight.rng.uniform(1.0, 10.0)
    size_nT = flight.rng.uniform(3.0, 10.0) * float(np.hypot(NOISE_NT, slow_nT))
    when_s = flight.rng.uniform(0.2, 0.8) * flight.duration_s + float(flight.state.time_s[0])
    found = _diagnosed(
        flight,
        {
            "gauss_markov_noise": {"std_nT": [slow_nT] * 3, "correlation_time_s": tau_s},
            "offset_jump": {"time_s": when_s, "step_nT": flight.vector(size_nT).tolist()},
        },
    )
    return "offset_jump" in _names(found), f"{size_nT:.1f} nT in {slow_nT:.1f}: {_told(found)}"


def tone(flight: Flight) -> tuple[bool, str]:
    """A steady tone of half to twice the noise, below half the sample rate: named."""
    fastest_hz = 0.45 / flight.state.interval_s
    tables = {
        "steady_tone": {
            "amplitude_nT": flight.vector(NOISE_NT * flight.rng.uniform(0.5, 2.0) * 3**0.5).tolist(),
            "frequency_hz": float(flight.rng.uniform(0.3, fastest_hz)),
        }
    }
    found = _diagnosed(flight, tables)
    return "steady_tone" in _names(found), _told(found)


def leftover(flight: Flight) -> tuple[bool, str]:
    """A cause beside a trace of an error of the field (0.03 sigma): the right name, and exit 0."""
    tables = {
        "motor_current": {"gain_nT_A": flight.vector(6.0).tolist()},
        "regional_field": {"error_enu_nT": flight.vector(0.1).tolist()},
    }
    found = _diagnosed(flight, tables)
    return found.verdict.explained and "motor_current" in _names(found), _told(found)


def triangle(flight: Flight) -> tuple[bool, str]:
    """A triangle of the field as slow as a circle: no name without doubt but a change of the field in time."""
    x = 2 * np.abs((flight.state.time_s / flight.rng.uniform(250.0, 600.0)) % 1 * 2 - 1) - 1
    swing_nT = to_body(flight.state.R_wb, x[:, None] * flight.vector(2 * NOISE_NT))
    found = diagnose(flight.with_effects({}, swing_nT), flight.model())
    certain = found.verdict.explained and bool(found.named)
    return not certain or "diurnal_drift" in _names(found), _told(found)


def other_reference(flight: Flight) -> tuple[bool, str]:
    """A temperature with another reference than the library's: no change of the iron beside it."""
    flight, reference_degC = flight.with_temperature(), float(flight.rng.uniform(-10.0, 40.0))
    tables: tuple[Tables, ...] = (
        {"temperature_offset": {"slope_nT_K": flight.vector(5.0).tolist(), "reference_degC": reference_degC}},
        {"temperature_scale": {"slope_1_K": flight.vector(4e-4).tolist(), "reference_degC": reference_degC}},
    )
    own = tables[flight.seed // len(VEHICLES) % len(tables)]
    found = _diagnosed(flight, own)
    iron = [cause.name for cause in found.named if cause.kind is EvidenceKind.IRON]
    return not iron and next(iter(own)) in _names(found), _told(found)


def stated_values(flight: Flight) -> tuple[bool, str]:
    """Spikes, dropouts, rounding or full scale that the model states, and a motor that it lacks: the motor alone."""
    full_nT = 0.95 * float(np.abs(measured({}, flight.state, 0)).max())
    tables: tuple[Tables, ...] = (
        {"spikes": {"rate_hz": 0.2, "amplitude_nT": 50.0}},
        {"dropouts": {"rate_hz": 0.05, "mean_duration_s": 1.0}},
        {"quantisation": {"step_nT": 5.0}},
        {"saturation": {"full_scale_nT": full_nT}},
    )
    own = tables[flight.seed // len(VEHICLES) % len(tables)]
    given = flight.with_effects({**own, "motor_current": {"gain_nT_A": flight.vector(6.0).tolist()}})
    found = diagnose(given, flight.model(own))
    return [cause.name for cause in found.named] == ["motor_current"], f"{next(iter(own))}: {_told(found)}"


def rates(flight: Flight) -> tuple[bool, str]:
    """Rates of spikes and dropouts, small or short ones among them: to a factor of two."""
    rate_hz = float(flight.rng.uniform(0.1, 0.3))
    tables: tuple[Tables, ...] = (
        {"spikes": {"rate_hz": rate_hz, "amplitude_nT": float(flight.rng.uniform(6.0, 40.0) * NOISE_NT)}},
        {"dropouts": {"rate_hz": rate_hz, "mean_duration_s": float(flight.rng.uniform(0.15, 2.0))}},
    )
    own = tables[flight.seed // len(VEHICLES) % len(tables)]
    found = _diagnosed(flight, own)
    told = [getattr(cause.effect, "rate_hz", 0.0) for cause in found.named if cause.kind is EvidenceKind.DIRECT]
    right = len(told) == 1 and 1 / FACTOR < told[0] / rate_hz < FACTOR
    return right, f"{next(iter(own))} {rate_hz:.2f} Hz: {told}"


def pulses(flight: Flight) -> tuple[bool, str]:
    """A payload's magnet that is there twice for 10 to 60 s: iron in these parts, and no other name without doubt."""
    time_s = flight.state.time_s - flight.state.time_s[0]
    windows_s = pulse_windows_s(flight.duration_s, flight.rng)
    on = np.logical_or.reduce([(time_s >= begin_s) & (time_s < end_s) for begin_s, end_s in windows_s])
    found = diagnose(flight.with_effects({}, np.outer(on, flight.vector(8 * NOISE_NT))), flight.model())
    certain = found.verdict.explained and bool(found.named)
    return not certain or all("hard_iron" in (cause.name, *cause.alternatives) for cause in found.named), _told(found)


def pulse_windows_s(duration_s: float, rng: np.random.Generator) -> Array:
    """Begin and end (2, 2) of two pulses, with time between them and after the second.

    Pulses that overlap, and last to the end of the flight, are one jump.
    """
    lengths_s = rng.uniform(10.0, 60.0, 2)
    begins_s = np.array([0.2, 0.6]) * duration_s + rng.uniform(0.0, 30.0, 2)
    return np.column_stack([begins_s, np.minimum(begins_s + lengths_s, np.array([0.55, 0.95]) * duration_s)])


def switched(flight: Flight) -> tuple[bool, str]:
    """A current that is switched at random: the noise in the new model is the sensor's to a tenth."""
    on_A = 3.0 * (flight.rng.random(len(flight.state)) < 0.5)
    given = flight.with_effects({}, np.outer(on_A, flight.vector(10.0)))
    assert given.current_A is not None
    given = replace(given, current_A=np.column_stack([on_A, given.current_A[:, 1:]]))
    found = diagnose(
        given, ModelSpec.model_validate({"field": {"enu_nT": flight.field_enu_nT.tolist()}}), fitted_base=True
    )
    white = type(of_sign("white", (1.0, 1.0, 1.0)))
    written = next(np.array(effect.first_value) for effect in found.model.chain() if isinstance(effect, white))
    return bool(np.allclose(written, NOISE_NT, rtol=0.1)), f"{written.round(2).tolist()} {_told(found)}"


def time_by_strength(flight: Flight) -> tuple[bool, str]:
    """A field that bends in time by 3 to 10 sigma along itself, seen by the strength alone: among the causes."""
    along = flight.field_enu_nT / np.linalg.norm(flight.field_enu_nT)
    period_s, phase_deg = flight.rng.uniform(3.0, 10.0) * flight.duration_s, float(flight.rng.uniform(-180.0, 180.0))
    swing = np.ptp(np.sin(2 * np.pi * (flight.state.time_s / period_s) + np.radians(phase_deg)))
    size_nT = flight.rng.uniform(3.0, 10.0) * NOISE_NT / swing
    drift = {"amplitude_enu_nT": (size_nT * along).tolist(), "period_s": period_s, "phase_deg": phase_deg}
    found = diagnose(replace(flight.with_effects({"diurnal_drift": drift}), att_q=None), flight.model())
    return "diurnal_drift" in _names(found), _told(found)


KINDS: dict[str, tuple[Measure, float]] = {
    "lot": (lot, 1.0),
    "body-beside-spikes": (body_beside_spikes, 0.9),
    "weak-driver": (weak_driver, 0.99),
    "step": (step, 0.95),
    "tone": (tone, 0.95),
    "leftover": (leftover, 0.9),
    "triangle": (triangle, 0.95),
    "other-reference": (other_reference, 0.9),
    "stated-values": (stated_values, 0.9),
    "rates": (rates, 0.9),
    "switched": (switched, 0.95),
    "pulses": (pulses, 0.95),
    "time-by-strength": (time_by_strength, 0.9),
}
"""Each kind's trial, and the share that has to be right."""


def _diagnosed(flight: Flight, tables: Tables) -> Diagnosis:
    return diagnose(flight.with_effects(tables), flight.model())


def _names(found: Diagnosis) -> set[str]:
    return {name for cause in found.named for name in (cause.name, *cause.alternatives)}


def _told(found: Diagnosis) -> str:
    return f"{found.verdict} {[cause.name for cause in found.named]}{_off(found)}"


def _off(found: Diagnosis) -> str:
    """How far the written model is off what was said, where it is off."""
    if found.resimulated_nT is None or not found.named or not found.verdict.explained:
        return ""
    ratio = found.resimulated_nT / rms(found.after_nT[found.problem.usable > 0])
    return "" if abs(ratio - 1) < SAME else f" written model leaves {ratio:.2f} times"


@dataclass(frozen=True)
class Trial:
    """One recording, or lot, of a kind."""

    kind: str
    seed: int

    @property
    def key(self) -> str:
        """Tells it from every other."""
        return f"{self.kind}/{self.seed}"


def run(trial: Trial) -> Row:
    """The row of a trial; a failure is a wrong answer."""
    try:
        right, told = KINDS[trial.kind][0](Flight.drawn(trial.kind, trial.seed))
    except (ArithmeticError, AssertionError, LookupError, TypeError, ValueError) as error:
        right, told = False, repr(error)[:200]
    return {"key": trial.key, "kind": trial.kind, "right": right, "told": told}


def table(rows: Sequence[Row]) -> Iterator[str]:
    """Lines of the table: kind, right, of how many, bar; then every miss."""
    yield "| kind | right | bar |"
    yield "|---|---|---|"
    for kind in dict.fromkeys(row["kind"] for row in rows):
        measure, bar = KINDS[kind]
        own = [row for row in rows if row["kind"] == kind]
        words = (measure.__doc__ or "").split("\n")[0]
        yield f"| {kind}: {words} | {sum(row['right'] for row in own)} of {len(own)} | {100 * bar:.0f} % |"
    yield ""
    yield from (f"- {row['key']}: {row['told']}" for row in rows if not row["right"])


def main() -> None:
    """Run what is missing, and print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.diagnosis.kinds", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--trials", type=int, default=20, help="of each kind")
    parser.add_argument("--only", help="kinds, e.g. step,tone")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("-o", "--out", type=Path, default=Path("out/kinds"))
    given = parser.parse_args()
    kinds = given.only.split(",") if given.only else tuple(KINDS)
    wanted = [Trial(kind, seed) for kind in kinds for seed in range(given.first, given.first + given.trials)]
    print("\n".join(table(resumed(wanted, given.out, run, attrgetter("key"), given.jobs))))


if __name__ == "__main__":
    main()
