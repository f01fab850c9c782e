"""The diagnosis against hidden effects of known size: null runs, one effect, one effect missing from the library.

    python -m benchmarks.diagnosis --seeds 10 --jobs 2 -o out/diagnosis-bench

Motion is MuJoCo's. An effect's strength is its rms after the base is refitted, in units of the noise. Truth has another
form than the candidate where one is at hand: an eddy current with a time constant, a hysteresis of several plays, two
dipoles, a temperature that lags. Trials land one by one in trials.jsonl; the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

from scenarios.load import load
from scenarios.spec import ModelSpec
from sim import effects as effect_table
from sim.chain import Chain, apply_deterministic
from sim.dataset import Recording
from sim.dataset.assemble import recording_of
from sim.pool import each
from sim.rotation import matrix_from_q, to_body
from sim.simulate import blocks, plan
from sim.state import State
from validation.diagnosis.workflow import diagnose

NOISE_NT = 2.0
MOTIONS = {"auv": "auv-spiral-excited", "quadrotor": "quad-calibration"}
BASE: dict[str, Any] = {
    "soft_iron": {"matrix": [[0.05, 0.01, -0.02], [0.01, -0.03, 0.015], [0.0, 0.01, 0.02]]},
    "hard_iron": {"offset_nT": [500.0, -300.0, 800.0]},
    "white_noise": {"std_nT": [NOISE_NT] * 3},
}
SCORED, TUNED = 1000, 0
"""First seed of the scoring and of the tuning set."""


@dataclass(frozen=True)
class Trial:
    """One recording to diagnose: kind of test, motion, hidden effect, its strength, seed, attitude noise."""

    kind: str
    motion: str
    effect: str
    strength: float
    seed: int
    attitude_deg: float = 0.0

    @property
    def key(self) -> str:
        """What tells it from every other."""
        return "/".join(str(value) for value in asdict(self).values())


def trials(first_seed: int, seeds: int) -> Iterator[Trial]:
    """Every trial of the bench."""
    for seed in range(first_seed, first_seed + seeds):
        for motion in MOTIONS:
            yield Trial("null", motion, "", 0.0, seed)
            yield Trial("coloured", motion, "", 0.0, seed, 0.01)
            for effect in HIDDEN:
                for strength in (0.1, 0.3, 1.0):
                    yield Trial("single", motion, effect, strength, seed)
                yield Trial("left-out", motion, effect, 1.0, seed)


def run(trial: Trial) -> dict[str, Any]:
    """Make the recording, diagnose it, and compare with what was hidden."""
    recording, state, field = _motion(trial.motion, trial.attitude_deg, trial.seed if trial.attitude_deg else 0)
    hidden = _scaled(trial, state) if trial.effect else {}
    measured = Chain(effect_table.build({**BASE, **hidden}, None, "truth"), trial.seed).apply(_driven(trial, state))[0]
    without = frozenset({trial.effect}) if trial.kind == "left-out" else frozenset()
    begun = time.perf_counter()
    model = ModelSpec.model_validate({"effects": BASE, "field": {"enu_nT": field.tolist()}})
    found = diagnose(replace(recording, mag_nT=measured), model, without=without)
    names = [(one.name, list(one.alternatives)) for one in found.named]
    return {
        **asdict(trial), "key": trial.key, "verdict": found.verdict, "names": names,
        "explained": found.gap.explained, "seconds": time.perf_counter() - begun,
    }  # fmt: skip


def _draw(trial: Trial, state: State) -> dict[str, Any]:
    rng = np.random.default_rng([trial.seed, 7])
    return HIDDEN[trial.effect](rng, state)


def _three(rng: np.random.Generator) -> list[float]:
    return list(rng.normal(size=3))


def _dipoles(rng: np.random.Generator, state: State) -> Any:
    middle = state.pos_enu_m[int(rng.integers(len(state) // 4, 3 * len(state) // 4))] + np.array([4.0, 3.0, -6.0])
    moment = 50.0 * rng.normal(size=3)
    return [
        {"position_enu_m": (middle + shift).tolist(), "moment_A_m2": (share * moment).tolist()}
        for shift, share in ((np.zeros(3), 0.8), (np.array([0.6, 0.0, 0.0]), 0.2))
    ]


def _gradient(rng: np.random.Generator, state: State) -> Any:
    g = rng.normal(size=(3, 3)) * 0.1
    g = g + g.T
    return {"gradient_nT_m": (g - np.eye(3) * np.trace(g) / 3).tolist()}


HIDDEN: dict[str, Any] = {
    "diurnal_drift": lambda rng, state: {"amplitude_enu_nT": [50 * v for v in _three(rng)], "period_s": 43_200.0},
    "field_gradient": _gradient,
    "local_dipole": _dipoles,
    "attitude_misalignment": lambda rng, state: {"angles_deg": [0.02 * v for v in _three(rng)]},
    "hard_iron_drift": lambda rng, state: {"rate_nT_h": [10 * v for v in _three(rng)]},
    "eddy_current": lambda rng, state: {
        "matrix_s": (0.005 * (np.eye(3) + 0.2 * rng.normal(size=(3, 3)))).tolist(), "time_constant_s": 0.05,
    },
    "motor_current": lambda rng, state: {"gain_nT_A": _three(rng), "motor": int(rng.integers(0, 3))},
    "current_ripple": lambda rng, state: {
        "amplitude_nT_A": _three(rng),
        "frequency_hz": float(rng.uniform(0.5, 4.0)),
        "phase_deg": float(rng.uniform(-90, 90)),
    },
    "nonlinearity": lambda rng, state: {
        "second_order": [1e-3 * v for v in _three(rng)],
        "third_order": [1e-3 * v for v in _three(rng)],
    },
    "temperature_scale": lambda rng, state: {"slope_1_K": [1e-4 * v for v in _three(rng)]},
    "temperature_offset": lambda rng, state: {"slope_nT_K": _three(rng)},
    "hysteresis": lambda rng, state: {"gain": [2e-3, 3e-3, 2e-3], "threshold_nT": [800.0, 2000.0, 5000.0]},
    "bandwidth": lambda rng, state: {"cutoff_hz": 20.0},
    "latency": lambda rng, state: {"delay_s": 0.008},
    "offset_jump": lambda rng, state: {
        "time_s": float(rng.uniform(0.2, 0.8) * state.time_s[-1]),
        "step_nT": _three(rng),
    },
}  # fmt: skip
"""Hidden effects before they are scaled: name -> (rng, state) -> tables."""
EQUIVALENT = {"latency": {"bandwidth", "eddy_current"}, "bandwidth": {"latency", "eddy_current"}}
SCALE = {"cutoff_hz": -1.0}
"""Parameters that scale with a power of the strength; those that are linear, delays and angles with the first."""
SIZES = ("delay_s", "angles_deg", "cutoff_hz")


@lru_cache(maxsize=8)
def _motion(name: str, attitude_deg: float, seed: int) -> tuple[Recording, State, np.ndarray[Any, Any]]:
    """A vehicle's recording without magnetometer errors, the state along it, and the field."""
    quiet = [f"navigation.attitude_noise_std_deg={attitude_deg}", "navigation.position_noise_std_m=0"]
    scenario = load(MOTIONS[name], quiet).model_copy(update={"effects": {}, "effect_order": None, "vary": {}})
    made = plan(scenario, 0, seed)
    columns: dict[str, list[Any]] = {}
    for block in blocks(made):
        for key, values in block.items():
            columns.setdefault(key, []).append(values)
    whole = {key: np.concatenate(parts) for key, parts in columns.items()}
    truth_q = np.ascontiguousarray(np.stack([whole[f"true_q{a}"] for a in "wxyz"], axis=1))
    recording = recording_of({k: v for k, v in whole.items() if not k.startswith(("true_", "effect"))})
    R_wb = matrix_from_q(truth_q)
    body = to_body(R_wb, made.field_enu_nT[None])
    rate = recording.gyro_rad_s
    assert rate is not None
    clean = _rate(truth_q, recording.time_s)
    state = State(
        time_s=recording.time_s, interval_s=float(recording.time_s[1] - recording.time_s[0]),
        pos_enu_m=np.stack([whole[f"true_pos_{a}_m"] for a in ("east", "north", "up")], axis=1), R_wb=R_wb,
        rate_rad_s=clean, field_enu_nT=made.field_enu_nT, field_nT=body, field_rate_nT_s=-np.cross(clean, body),
        temperature_degC=whole["temperature_degC"], current_A=recording.current_A, attitude="navigation",
    )  # fmt: skip
    return recording, state, made.field_enu_nT


def _rate(q: Any, time_s: Any) -> Any:
    from calib.rates import body_rate

    return body_rate(Recording(time_s=time_s, mag_nT=np.zeros((len(q), 3)), att_q=q))


def _driven(trial: Trial, state: State) -> State:
    """The state with a temperature that the sensor feels a little late."""
    if not trial.effect.startswith("temperature"):
        return state
    p = np.exp(-state.interval_s / 10.0)
    late, _ = lfilter([1 - p], [1, -p], state.temperature_degC, zi=[p * state.temperature_degC[0]])
    return replace(state, temperature_degC=np.asarray(late))


def _scaled(trial: Trial, state: State) -> dict[str, Any]:
    """The hidden effect's tables at the trial's strength: rms after the base, over the noise; three secant steps."""
    tables, factor = _draw(trial, state), 1.0
    for _ in range(3):
        now = {trial.effect: _times(trial.effect, tables, factor)}
        factor *= trial.strength / max(_strength(now, _driven(trial, state)), 1e-12)
    return {trial.effect: _times(trial.effect, tables, factor)}


def _times(name: str, table: Any, factor: float) -> Any:
    if isinstance(table, list):
        return [_times(name, one, factor) for one in table]
    linear = effect_table.BY_NAME[name].linear
    return {
        key: (np.array(value) * factor ** SCALE.get(key, 1.0)).tolist() if key in linear or key in SIZES else value
        for key, value in table.items()
    }


def _strength(tables: dict[str, Any], state: State) -> float:
    base = {key: value for key, value in BASE.items() if key != "white_noise"}
    with_it = apply_deterministic(effect_table.build({**base, **tables}, None, ""), state)[0]
    without = apply_deterministic(effect_table.build(base, None, ""), state)[0]
    design = np.column_stack([without / 5e4, np.ones(len(state))])
    left = with_it - design @ np.linalg.lstsq(design, with_it, rcond=None)[0]
    return float(np.sqrt((left**2).mean()) / NOISE_NT)


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The bar's figures: false names, truth in the class, first choice, class size, confidently wrong, explained."""
    out: dict[str, Any] = {}
    for kind in ("null", "coloured"):
        some = [r for r in rows if r["kind"] == kind]
        out[kind] = {"runs": len(some), "named": sum(bool(r["names"]) for r in some)}
    for strength in (0.1, 0.3, 1.0):
        some = [r for r in rows if r["kind"] == "single" and r["strength"] == strength]
        if some:
            out[f"single at {strength:g} sigma"] = _single(some)
    left = [r for r in rows if r["kind"] == "left-out"]
    if left:
        wrong = [r for r in left if r["verdict"] == "named" and r["names"][0][0] not in EQUIVALENT.get(r["effect"], ())]
        out["left out"] = {"runs": len(left), "misnamed": len(wrong), "of": sorted({r["effect"] for r in wrong})}
    out["slowest_s"] = max((r["seconds"] for r in rows), default=0.0)
    return out


def _single(rows: list[dict[str, Any]]) -> dict[str, Any]:
    classes = [{n for name, others in r["names"] for n in (name, *others)} for r in rows]
    first = [r["names"][0][0] if r["names"] else "" for r in rows]
    hit = [r["effect"] in c for r, c in zip(rows, classes, strict=True)]
    right = [f == r["effect"] or f in EQUIVALENT.get(r["effect"], set()) for r, f in zip(rows, first, strict=True)]
    wrong = [r["verdict"] == "named" and not h for r, h in zip(rows, hit, strict=True)]
    sizes = [1 + len(r["names"][0][1]) for r in rows if r["names"]]
    explained = [r["explained"] for r in rows if r["explained"] is not None]
    return {
        "runs": len(rows), "in_class": float(np.mean(hit)), "first_right": float(np.mean(right)),
        "class_size": float(np.mean(sizes)) if sizes else None, "confidently_wrong": float(np.mean(wrong)),
        "explained_median": float(np.median(explained)) if explained else None,
        "explained_10_percent": float(np.quantile(explained, 0.1)) if explained else None,
        "missed": sorted(f"{r['effect']}/{r['motion']}" for r, h in zip(rows, hit, strict=True) if not h),
    }  # fmt: skip


def main() -> None:
    """Run what is missing and print the figures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--tuning", action="store_true", help="the tuning seeds instead of the scoring ones")
    parser.add_argument("-o", "--out", type=Path, default=Path("out/diagnosis-bench"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    log = given.out / "trials.jsonl"
    done = {row["key"]: row for row in map(json.loads, log.read_text().splitlines())} if log.exists() else {}
    wanted = list(trials(TUNED if given.tuning else SCORED, given.seeds))
    open_trials = [trial for trial in wanted if trial.key not in done]
    with log.open("a") as file:
        for count, (trial, row) in enumerate(each(run, open_trials, given.jobs), 1):
            done[trial.key] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            if count % 20 == 0:
                print(f"{count} of {len(open_trials)}", flush=True)
    figures = summary([done[trial.key] for trial in wanted])
    (given.out / "figures.json").write_text(json.dumps(figures, indent=1) + "\n")
    print(json.dumps(figures, indent=1))


if __name__ == "__main__":
    main()
