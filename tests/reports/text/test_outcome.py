"""An outcome in words: what was simulated, and the table of scores."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from reports.text.outcome import (
    compare_command,
    duration_s,
    notes_markdown,
    rms_length,
    scenario_description,
    score_table,
)
from tests.reports.outcome_example import example_outcome


@pytest.fixture(scope="module")
def outcome():
    return example_outcome(900)


def test_the_rms_of_vectors_is_that_of_their_lengths_and_gaps_do_not_count():
    assert rms_length(np.array([3.0, -4.0, np.nan])) == pytest.approx(math.sqrt(12.5))
    assert rms_length(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 5.0]])) == pytest.approx(5.0)
    assert math.isnan(rms_length(np.full((2, 3), np.nan)))


def test_one_sensor_is_one_and_four_are_counted(outcome):
    assert "carrying one three-axis magnetometer sampled" in scenario_description(outcome)
    assert "carrying 4 three-axis magnetometers sampled" in scenario_description(example_outcome(900, sensors=4))


def test_the_sentence_tells_phases_field_length_and_effects(outcome):
    text = scenario_description(outcome).replace("\u2009", "").replace("\u2212", "-")
    assert "moved through descent, spiral, comb in a given field of 1500, 27000, -41000 nT (east, north, up)" in text
    assert duration_s(outcome) == 900.0
    assert "for 15 min" in text
    assert f"Effects injected ({len(outcome.effects)}): " in text


def test_in_sample_scores_stand_last_and_the_ranking_one_is_marked(outcome):
    table = score_table(outcome)
    in_sample = [head["in_sample"] for head in table["heads"]]
    assert in_sample == sorted(in_sample)
    assert sum(head["ranks"] for head in table["heads"]) == 1
    assert [row["name"] for row in table["rows"]] == outcome.ranking()[0]
    assert {len(row["cells"]) for row in table["rows"]} == {len(table["heads"])}


def test_the_notes_hold_every_calibrator_once_and_every_reason(outcome):
    lines = notes_markdown(outcome).splitlines()
    heads = [line for line in lines if line.startswith("|  |")]
    assert [name.strip() for line in heads for name in line.strip("|").split("|")[1:]] == outcome.ranking()[0]
    reasons = [name for name, fit in outcome.calibrations.items() if fit.status.reason]
    assert [name for name in reasons if any(line.startswith(f"- {name} (") for line in lines)] == reasons


def test_the_notes_begin_with_what_to_use_and_how_to_be_surer(outcome):
    text = notes_markdown(outcome)
    assert text.startswith(f"# {outcome.scenario.name}\n\nUse {outcome.ranking()[0][0]}: ")
    assert text.index("Failed and ranked last") < text.index("magbench compare") < text.index("An AUV moved")


def test_a_table_sorts_by_numbers_without_their_marks(outcome):
    table = score_table(outcome)
    ranked = next(k for k, head in enumerate(table["heads"]) if head["ranks"])
    cells = [row["cells"][ranked] for row in table["rows"]]
    assert all(cell.value is None or f"{cell.text[:-1]}†" == cell.text for cell in cells)
    assert [cell.value for cell in cells if cell.text == "–"] == [None]


def test_every_score_of_the_table_is_explained(outcome):
    table = score_table(outcome)
    assert {head["name"] for head in table["heads"]} <= {one.short for one in table["meanings"]}
    assert table["heads"][0]["ranks"]
    assert [head["unit"] for head in table["heads"] if head["name"] == "heading"] == ["°"]


def test_the_command_that_compares_names_what_was_run(outcome):
    outcome = replace(outcome, asked=("my flights/one.toml", "sampling.rate_hz=5"))
    assert compare_command(outcome) == "magbench compare 'my flights/one.toml' --trials 100 --set sampling.rate_hz=5"


def test_an_effect_without_contribution_is_not_counted(outcome):
    idle = np.zeros_like(outcome.truth.field_nT)
    truth = replace(outcome.truth, effects={**outcome.truth.effects, "attitude_misalignment": idle})
    text = scenario_description(replace(outcome, truth=truth))
    assert f"Effects injected ({len(outcome.effects)})" in text
    assert "Without a contribution to the field: attitude misalignment." in text
