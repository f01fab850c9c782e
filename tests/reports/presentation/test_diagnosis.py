"""What is shown of a diagnosis: computed once for all views; the tiles say what the finding rests on."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import magbench
from diagnosis.result import Diagnosis
from diagnosis.workflow import diagnose
from magbench.api.diagnosis_results import DiagnosisResult
from magbench.diagnosis_tables import show_answer
from reports.presentation import series
from reports.presentation.diagnosis import PresentedDiagnosis
from scenarios.toml import to_toml
from sim.chain import apply_deterministic
from sim.effects.currents import MotorCurrent
from sim.effects.electronics import Quantisation
from sim.effects.faults import Spikes
from sim.effects.noise import WhiteNoise
from sim.scenario import ModelSpec
from tests.diagnosis.synthetic import FIELD_ENU_NT, NOISE_NT, recording

BARE = {"field": {"enu_nT": FIELD_ENU_NT.tolist()}, "effects": {"white_noise": {"std_nT": [NOISE_NT] * 3}}}
CASES: dict[str, tuple[float, dict[str, Any], tuple[str, str, str]]] = {
    "nothing": (NOISE_NT, {}, ("nothing", "", "no gap beyond the noise")),
    "fitted": (
        NOISE_NT,
        {MotorCurrent.name: {"gain_nT_A": [20.0, -10.0, 40.0]}},
        (MotorCurrent.name, "nats on held-out data, of 8.07 needed", "% removed"),
    ),
    "faults": (
        NOISE_NT,
        {Spikes.name: {"rate_hz": 0.1, "amplitude_nT": 300.0}},
        (Spikes.name, "evidence", "affected samples are left out"),
    ),
    "rounding": (
        NOISE_NT,
        {Quantisation.name: {"step_nT": 2 * NOISE_NT}},
        (Quantisation.name, "evidence", "no gap beyond the noise"),
    ),
    "noise": (3 * NOISE_NT, {}, (WhiteNoise.name, "evidence", "noise cannot be predicted")),
}


@cache
def diagnosed(case: str) -> Diagnosis:
    """The diagnosis of a case's recording by the bare model."""
    noise_nT, hidden, _ = CASES[case]
    return diagnose(recording(2000, noise_nT=noise_nT, hidden=hidden), ModelSpec.model_validate(BARE))


@pytest.mark.parametrize("case", CASES)
def test_the_tiles_say_what_the_finding_rests_on(case: str) -> None:
    found, said = diagnosed(case), CASES[case][2]
    (missing, _), *sure, (_, share) = tiles = PresentedDiagnosis.of(found).tiles
    assert missing == said[0]
    assert [said[1] in label for _, label in sure[:1]] == [True] * bool(said[1])
    assert said[2] in share
    assert all(value not in ("", "–") for value, _ in tiles)


def test_the_tile_says_whether_a_second_recording_was_asked() -> None:
    found = diagnosed("fitted")
    assert "confirm with a second" in PresentedDiagnosis.of(found).tiles[1][1]
    asked = replace(found, has_second=True)
    assert "the second recording does not confirm it" in PresentedDiagnosis.of(asked).tiles[1][1]
    switched = replace(found.named[0], effect=replace(found.named[0].effect, active_s=(10.0, 20.0)))
    assert "a second cannot confirm it" in PresentedDiagnosis.of(replace(asked, named=(switched,))).tiles[1][1]


def test_page_viewer_terminal_and_notebook_show_a_single_simulation(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[object] = []

    def counted(effects: Any, state: Any) -> Any:
        asked.append(effects)
        return apply_deterministic(effects, state)

    monkeypatch.setattr(series, "apply_deterministic", counted)
    given = recording(2000, hidden={MotorCurrent.name: {"gain_nT_A": [20.0, -10.0, 40.0]}})
    (tmp_path / "model.toml").write_text(to_toml(ModelSpec.model_validate(BARE)))
    found = magbench.diagnose(given, tmp_path / "model.toml", out=tmp_path / "out")
    assert isinstance(found, DiagnosisResult)
    show_answer(found.presented)
    found.plot()
    assert (tmp_path / "out" / "report.html").exists()
    assert len(found.to_frame()) > 0
    assert len(asked) == 1


@pytest.mark.parametrize("length", [1, 7, 50])
def test_block_means_of_a_gap_keep_its_mean_square_apart_from_the_scatter_within_blocks(length: int) -> None:
    """Total variance: mean square = mean square of the block means + mean variance within blocks."""
    gap_nT = np.random.default_rng(3).normal(size=(700, 3)) * [1.0, 5.0, 2.0]
    whole = series.GapSeries(np.arange(700.0), np.ones(700), gap_nT, 2 * gap_nT)
    within = gap_nT.reshape(-1, length, 3).var(axis=1).mean()
    thin = whole.in_blocks(length)
    assert thin.rms_nT()[0] ** 2 + within == pytest.approx(whole.rms_nT()[0] ** 2)
    assert thin.after_nT == pytest.approx(2 * thin.before_nT)
    assert whole.largest == 1


def test_a_tone_stands_in_the_spectrum_at_its_frequency_with_its_power() -> None:
    """Parseval: the density squared, integrated over frequency, is the mean square of a component."""
    found = diagnosed("nothing")
    tone_nT = np.sqrt(2) * 30.0 * np.sin(2 * np.pi * 1.0 * found.problem.recording.time_s)[:, None] * np.ones(3)
    density = series.DiagnosisSeries.of(replace(found, before_nT=tone_nT)).spectrum
    assert density.frequency_Hz[np.argmax(density.before)] == pytest.approx(1.0, abs=0.05)
    edges_Hz = np.concatenate([[0.0], (density.frequency_Hz[1:] + density.frequency_Hz[:-1]) / 2])
    assert np.sqrt(np.sum(density.before[:-1] ** 2 * np.diff(edges_Hz))) == pytest.approx(30.0, rel=0.1)
