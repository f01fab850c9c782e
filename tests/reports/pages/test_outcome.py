"""The report: complete, self-contained, safe to open, and small for long recordings."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import html
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from calib.result import Calibration, Status
from recordings.files import write_text
from reports.pages.outcome import SECTIONS, outcome_page
from reports.text.outcome import FAILED_LAST, notes_markdown, rms_length, scenario_description, score_table
from scenarios.errors import InputError
from scenarios.paths import Ability
from sim.vehicles import VEHICLES
from tests.reports import outcome_example as example
from tests.reports.page import figures, plain, plots, read, without_scripts
from validation.scoring.definitions import SCORE_DEFINITIONS
from validation.scoring.outcome import RANKED_BY, Outcome
from validation.scoring.scores import Score
from validation.text import digits, plainly


class Links(HTMLParser):
    """Every address that a page would load or go to."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value or "" for key, value in attrs if key in ("src", "href", "srcset", "action", "data")]


def write_report(outcome: Outcome, path: Path) -> None:
    write_text(path, outcome_page(outcome))


@pytest.fixture(scope="module")
def outcome() -> Outcome:
    return example.example_outcome(3000)


@pytest.fixture(scope="module")
def page(outcome: Outcome, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(outcome, path)
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
    return path.read_text(encoding="utf-8")


def test_needs_nothing_from_outside(page: str) -> None:
    assert all(link.startswith(("data:image/", "#")) for link in Links(page).found)
    assert not re.search(r"@import|url\(|<script src|<link", without_scripts(page))


def test_every_figure_is_there_to_zoom_or_as_an_image(page: str) -> None:
    pictures = [link for link in Links(page).found if link.startswith("data:")]
    assert figures(page) == len(SECTIONS)
    assert len(plots(page)) >= 5
    assert all(plot["data"] for plot in plots(page))
    for picture in pictures:
        head, data = picture.split(",", 1)
        raw = base64.b64decode(data, validate=True)
        assert raw.startswith(b"\x89PNG") if "png" in head else b"<svg" in raw[:1000]


def test_tells_everything(outcome: Outcome, page: str) -> None:
    text = html.unescape(re.sub(r"<style.*?</style>|data:image/[^\"]*", "", page, flags=re.DOTALL))
    names = ("Seed", "gyro_s", "gain_nT_A", outcome.scenario.name)
    for name in (*names, *outcome.calibrations, *outcome.truth.parameters["effects"][0]):
        assert name in text
    for effect in outcome.effects:
        assert effect.replace("_", " ") in text
    for score in (s for scores in outcome.scores.values() for s in scores if s.name not in ("failure", "wall_time")):
        assert SCORE_DEFINITIONS[score.name].short in text
        assert SCORE_DEFINITIONS[score.name].explained in text
        assert digits(score.value) in text or plainly(score.value) in text
    assert all(c.status.reason in text for c in outcome.calibrations.values())


def test_begins_with_what_to_use_then_who_failed(outcome: Outcome, page: str) -> None:
    text = read(html.unescape(page))
    order = [f"Use {outcome.ranking()[0][0]}: ", FAILED_LAST, "<li><b>psoga (not converged)</b>: ", "magbench compare"]
    places = [text.index(part) for part in (*order, plain(scenario_description(outcome)))]
    assert places == sorted(places)


def test_text_from_outside_is_escaped(page: str) -> None:
    assert "<b>steel</b>" not in page
    assert "&lt;b&gt;steel&lt;/b&gt;" in page
    assert "&lt;attitude&gt; &amp; rate" in page


def test_in_sample_scores_are_marked_and_never_order(outcome: Outcome) -> None:
    flattering = {n: [dataclasses.replace(s, value=-s.value) if s.in_sample else s for s in scores]
                  for n, scores in outcome.scores.items()}  # fmt: skip
    other = dataclasses.replace(outcome, scores=flattering)
    assert other.ranking() == outcome.ranking()
    heads = score_table(outcome)["heads"]
    assert [h["name"] for h in heads if h["in_sample"]] == [SCORE_DEFINITIONS["in_sample_norm_rms"].short]
    assert not any(h["ranks"] for h in heads if h["in_sample"])
    only = {n: [s for s in scores if s.in_sample] for n, scores in outcome.scores.items()}
    assert dataclasses.replace(outcome, scores=only).ranking()[1] == ""


def test_order_is_by_the_hold_out_and_failures_come_last(outcome: Outcome) -> None:
    ranked, by = outcome.ranking()
    value = {n: next((s.value for s in scores if s.name == by), np.inf) for n, scores in outcome.scores.items()}
    ok = [n for n in ranked if outcome.calibrations[n].status.kind == "ok"]
    assert by == RANKED_BY
    assert ranked[: len(ok)] == ok == sorted(ok, key=value.__getitem__)
    assert ranked[-2:] == ["psoga", "gyro_ml"]


@pytest.mark.slow
def test_long_recording_stays_small(tmp_path: Path) -> None:
    write_report(example.example_outcome(500_000, duration_s=4 * 3600.0), tmp_path / "long.html")
    assert len(without_scripts((tmp_path / "long.html").read_text(encoding="utf-8"))) < 5e6


@pytest.mark.parametrize("gap", [slice(1000, 1400), pytest.param(slice(None), marks=pytest.mark.slow)])
def test_gaps_and_missing_columns_are_drawn(outcome: Outcome, tmp_path: Path, gap: slice) -> None:
    mag_nT = outcome.recording.mag_nT.copy()
    mag_nT[gap] = np.nan
    recording = dataclasses.replace(outcome.recording, mag_nT=mag_nT, phase=None, temperature_degC=None, current_A=None)
    write_report(dataclasses.replace(outcome, recording=recording), tmp_path / "r.html")
    assert "motion" in (tmp_path / "r.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_without_calibrators_or_effects(outcome: Outcome, tmp_path: Path) -> None:
    truth = dataclasses.replace(outcome.truth, effects={}, parameters={})
    bare = dataclasses.replace(outcome, truth=truth, calibrations={}, scores={}, corrected={})
    write_report(bare, tmp_path / "r.html")
    assert "No effect was injected." in (tmp_path / "r.html").read_text(encoding="utf-8")


def test_when_every_calibrator_fails(outcome: Outcome, tmp_path: Path) -> None:
    failed = {"sphere": Calibration(name="sphere", status=Status("not_applicable", "no motion at all"))}
    alone = dataclasses.replace(outcome, calibrations=failed, scores={"sphere": []}, corrected={})
    write_report(alone, tmp_path / "r.html")
    assert "no motion at all" in (tmp_path / "r.html").read_text(encoding="utf-8")


@pytest.fixture
def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("reports.pages.outcome.SECTIONS", ())


@pytest.mark.usefixtures("without_pictures")
def test_an_array_says_that_it_shows_sensor_1(tmp_path: Path) -> None:
    array = example.example_outcome(500, sensors=4)
    write_report(array, tmp_path / "r.html")
    assert "every picture shows sensor 1" in (tmp_path / "r.html").read_text(encoding="utf-8")
    assert all(value.shape == (500, 3) for value in array.effects.values())
    assert "shows sensor 1" in notes_markdown(array)


@pytest.mark.usefixtures("without_pictures")
def test_refused_path_leaves_nothing(outcome: Outcome, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        write_report(outcome, tmp_path / "missing" / "r.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("without_pictures")
def test_same_outcome_gives_the_same_words(outcome: Outcome, tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_report(outcome, tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


@pytest.mark.parametrize("name", VEHICLES)
def test_every_vehicle_is_reported_and_one_that_stays_has_no_path(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("reports.pages.outcome.SECTIONS", [s for s in SECTIONS if s.key in ("path", "sizes")])
    write_report(example.example_outcome(200, vehicle=name), tmp_path / "r.html")
    text = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert ('id="path"' in text) is (Ability.TRAVEL in VEHICLES[name].abilities)
    assert VEHICLES[name].noun[1:] + " moved through" in text


def test_pictures_show_sensor_1_of_an_array() -> None:
    array = example.example_outcome(200, sensors=2)
    keys = {f"sphere@{k}": array.calibrations["sphere"] for k in (2, 1, 11)}
    corrected = dict.fromkeys(keys, array.corrected["sphere"])
    assert dataclasses.replace(array, calibrations=keys, corrected=corrected).shown() == ["sphere@1"]


def test_residual_leaves_out_only_an_unobservable_rotation(outcome: Outcome) -> None:
    truth = outcome.truth.field_nT
    turn = example._matrices(np.array([[np.cos(0.05), 0.03, np.sin(0.05), 0.0]]) / np.hypot(1, 0.03))[0]
    turned = dataclasses.replace(outcome, corrected={"sphere": truth @ turn.T, "kalman": 1.01 * truth @ turn.T})
    turned.corrected["sphere"][:5] = np.nan
    assert np.nanmax(np.abs(turned.residual_nT("sphere"))) < 1e-6
    assert rms_length(turned.residual_nT("kalman")) == pytest.approx(0.01 * outcome.field_strength_nT, rel=1e-6)
    fixed = {n: [dataclasses.replace(s, rotation_removed=False) for s in v] for n, v in outcome.scores.items()}
    assert rms_length(dataclasses.replace(turned, scores=fixed).residual_nT("sphere")) > 100


def test_rms_length_is_of_vector_lengths_and_skips_gaps() -> None:
    assert rms_length(np.array([[3.0, 4.0, 0.0], [np.nan, 0.0, 0.0], [0.0, 0.0, 5.0]])) == pytest.approx(5.0)
    assert np.isnan(rms_length(np.full(3, np.nan)))


def test_sentence_names_vehicle_phases_and_field(outcome: Outcome) -> None:
    text = scenario_description(outcome)
    assert text.startswith("An AUV moved through descent, spiral, comb in a given field of 1500, 27000")
    assert "sampled at 10 Hz" in text


def test_markdown_cells_cannot_break_the_table(outcome: Outcome) -> None:
    odd = {"a|b": Calibration(name="a|b", status=Status("ok"))}
    scores = {"a|b": [Score("offset_error", 1.0, "nT")]}
    text = notes_markdown(dataclasses.replace(outcome, calibrations=odd, scores=scores, corrected={}))
    table = [line for line in text.splitlines() if line.startswith("|")]
    assert "a\\|b" in table[0]
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in table} == {3}


def test_the_page_holds_its_library_in_a_tenth_of_its_size(page: str) -> None:
    """A page of five calibrators stays below 1.5 MB; plotly.js is in it once, whole."""
    (packed,) = re.findall(r'<script type="application/gzip" id="plotly">(.*?)</script>', page)
    assert gzip.decompress(base64.b64decode(packed)).decode().startswith("/**\n* plotly.js (basic - minified)")
    assert len(page) < 1_500_000


def test_the_raw_measurement_ranks_above_a_failed_fit_that_is_worse(outcome: Outcome) -> None:
    ranked, by = outcome.ranking()
    failed = ranked[-1]
    (score,) = (s for s in outcome.scores[ranked[0]] if s.name == by)

    def order(of_raw: float, of_failed: float) -> list[str]:
        values = {"uncorrected": of_raw, failed: of_failed}
        scores = {name: [dataclasses.replace(score, value=value)] for name, value in values.items()}
        rows = dataclasses.replace(outcome, scores={**outcome.scores, **scores}).rows()
        return [name for name in rows if name in values]

    assert order(2000.0, 9000.0) == ["uncorrected", failed]
    assert order(2000.0, 900.0) == [failed, "uncorrected"]
