"""Files of gates: what is read, what is refused and where, and how many trials a gate is planned for."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import ValidationError

from scenarios.errors import InputError
from validation.calibrating.processes import LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S
from validation.gates.gate_file import Gate, GateFile, json_schema, load_gates
from validation.gates.gate_plan import plan_gate
from validation.gates.power import exceedance_of, verdict_probabilities

GATE = """
[[gate]]
name = "heading"
scenario = "auv-spiral"
calibrator = "ellipsoid"
score = "heading_rms"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "gates.toml"


def gate(**keys: object) -> Gate:
    base = {"name": "a", "scenario": "tumble", "calibrator": "ellipsoid", "score": "offset_error_nT", "limit": 2.0}
    return Gate.model_validate(base | keys)


def test_what_a_file_leaves_out_has_a_default(file: Path) -> None:
    file.write_text(GATE + "limit = 0.1\n" + GATE.replace('"heading"', '"other"') + 'ratio = 1.2\nreference = "sphere"')
    found = load_gates(file)
    assert found.false_fail_rate == 1e-4
    assert found.rate == 0.5e-4
    first, second = found.gate
    assert (first.kind, first.factor, first.unit) == ("limit", 0.1, "deg")
    assert (second.kind, second.factor, second.unit) == ("ratio", 1.2, "")
    assert first.score_definition.column == "heading_rms_deg"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "gate: missing"),
        ("gate = []", "there is no gate"),
        (GATE, "found none"),
        (GATE + "limit = 1\nratio = 2\nreference = 'sphere'", "found limit and ratio"),
        (GATE + "ratio = 2", "ratio and reference go together"),
        (GATE + "limit = 1\nreference = 'sphere'", "ratio and reference go together"),
        (GATE + "limit = '1'", r"gate\.0\.limit: must be a valid number"),
        (GATE + "limit = -1", r"gate\.0\.limit"),
        (GATE + "limit = 1\nquantile = 0.1", r"gate\.0\.quantile"),
        (GATE + "limit = 1\nlimitt = 1", r"gate\.0\.limitt: unknown key \(did you mean limit"),
        (GATE + "limit = 1\n" + GATE + "limit = 1", r"gate\.1\.name: 'heading' is the name of another gate"),
        (GATE.replace("heading_rms", "heading_rm") + "limit = 1", "did you mean heading_rms_deg"),
        (GATE.replace("heading_rms", "wall_time") + "limit = 1", "not the same twice"),
        (GATE.replace("heading_rms", "iterations") + "limit = 1", "no better end"),
        (GATE.replace("heading_rms", "in_sample_norm_rms") + "limit = 1", "no better end"),
        (GATE + "limit = 1\nneeds = ['gyro']", "needs: needs applies to a command only"),
        (GATE + "limit = 1\nexec = 'a {recording} {result}'\nneeds = ['compass']", "needs"),
        ("false_fail_rate = 0\n" + GATE + "limit = 1", "false_fail_rate"),
    ],
)
def test_a_mistake_is_one_line_that_names_its_place(text: str, says: str, file: Path) -> None:
    file.write_text(text)
    with pytest.raises(InputError, match=says) as error:
        load_gates(file)
    assert str(error.value).startswith(str(file))
    assert "\n" not in str(error.value)


def test_the_schema_names_the_keys_as_files_do() -> None:
    table = json_schema()["$defs"]["Gate"]
    assert {"set", "exec", "limit", "smallest_defect"} <= set(table["properties"])
    assert set(table["required"]) == {"name", "scenario", "calibrator", "score"}
    assert not table["additionalProperties"]


def test_without_max_trials_the_smallest_defect_is_caught_with_the_power() -> None:
    one = gate(smallest_defect=1.4, power=0.95, spread=0.4)
    plan = plan_gate(one, 1e-5, "gate.0")
    failed, _ = verdict_probabilities(plan.test, exceedance_of(1.4, 0.5, 0.4), plan.max_trials)
    assert failed[-1] >= 0.95
    assert failed[-2] < 0.95


def test_max_trials_stands_where_it_is_enough() -> None:
    assert plan_gate(gate(max_trials=700, smallest_defect=1.4), 1e-5, "gate.0").max_trials == 700
    assert plan_gate(gate(max_trials=30), 1e-5, "gate.0").max_trials == 30


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"max_trials": 20}, r"within 20 trials nothing fails at a rate .* 1e-5 \(allow 21 or more"),
        ({"max_trials": 100, "smallest_defect": 1.1}, r"1.1 times the limit takes [\d,]+ trials, max_trials is 100"),
        ({"smallest_defect": 1.001}, "takes more than 5000 trials"),
    ],
)
def test_what_the_trials_cannot_show_is_refused_before_any_is_run(keys: dict[str, float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        plan_gate(gate(**keys), 1e-5, "gate.0")


@pytest.mark.parametrize(
    ("key", "held", "refused"),
    [
        ("name", ("a", "x" * 100), ("", "x" * 101, " a", "a ")),
        ("scenario", ("t",), ("",)),
        ("calibrator", ("c",), ("",)),
        ("limit", (1e-9, 0.5, 1e12), (0.0, 1.5e12)),
        ("quantile", (0.5, 0.999), (0.49, 1.0)),
        ("power", (0.5, 0.999), (0.49, 1.0)),
        ("max_trials", (1, 5000), (0, 5001)),
        ("smallest_defect", (1.01, 1e6), (1.0, 1.5e6)),
        ("spread", (0.01, 10.0), (0.0, 10.5)),
        ("margin", (0.5, 1e12), (0.0, 1.5e12)),
    ],
)
def test_the_values_of_a_gate_have_ends(key: str, held: tuple[object, ...], refused: tuple[object, ...]) -> None:
    for value in held:
        assert getattr(gate(**{key: value}), key) == value
    for value in refused:
        with pytest.raises(ValidationError, match=key):
            gate(**{key: value})


@pytest.mark.parametrize(
    ("key", "held", "refused"),
    [
        ("false_fail_rate", (1e-9, 0.49), (0.0, 0.5)),
        ("seed", (0, 7), (-1,)),
        ("time_limit_s", (LEAST_TIME_LIMIT_S, MOST_TIME_LIMIT_S), (0.9 * LEAST_TIME_LIMIT_S, 1.1 * MOST_TIME_LIMIT_S)),
    ],
)
def test_the_values_of_a_file_have_ends(key: str, held: tuple[object, ...], refused: tuple[object, ...]) -> None:
    for value in held:
        assert getattr(GateFile.model_validate({"gate": (gate(),), key: value}), key) == value
    for value in refused:
        with pytest.raises(ValidationError, match=key):
            GateFile.model_validate({"gate": (gate(),), key: value})


def test_a_gate_is_of_the_median_and_sees_half_more_in_99_of_100_runs_unless_it_says_otherwise() -> None:
    one = gate()
    assert (one.quantile, one.power, one.margin, one.spread, one.max_trials) == (0.5, 0.99, 1.1, 0.5, None)
    usual, stated = (plan_gate(each, 1e-5, "gate.0") for each in (one, gate(smallest_defect=1.5)))
    assert usual.max_trials == stated.max_trials
    assert (usual.test.allowed, usual.test.false_fail_rate) == (0.5, 1e-5)
    assert usual.test.false_pass_rate == pytest.approx(0.01)
    assert plan_gate(gate(quantile=0.9, power=0.95), 1e-5, "gate.0").test.allowed == pytest.approx(0.1)
    assert one.command is None
    held = gate(calibrator="mine@2", exec="fit {recording} {result}", needs=["gyro"])
    assert held.command == "mine:gyro=fit {recording} {result}"
    assert gate(calibrator="mine", exec="fit {recording} {result}").command == "mine=fit {recording} {result}"
