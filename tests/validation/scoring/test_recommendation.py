"""Which calibrator a run speaks for: worked out by hand on made-up scores."""

from __future__ import annotations

import pytest

from calib import Calibration, Status
from validation.scoring.evaluation import UNCORRECTED
from validation.scoring.outcome import RANKED_BY
from validation.scoring.recommendation import Recommendation, recommend
from validation.scoring.scores import Score

OK = Status("ok")
LOOSE = Status("not_converged", "the start still weighs: 0.4; record longer")
UNSEEN = Status("unobservable", "the offset along body z cannot be determined: level turns alone; pitch further")


def level(error_nT: float, heading_deg: float | None = None, turned: bool = False) -> list[Score]:
    heading = [] if heading_deg is None else [Score("heading_rms", heading_deg, "deg", rotation_removed=turned)]
    return [Score(RANKED_BY, error_nT, "nT", rotation_removed=turned), *heading]


def told(statuses: dict[str, Status], scores: dict[str, list[Score]]) -> Recommendation:
    fits = {name: Calibration(name=name, status=status) for name, status in statuses.items()}
    return recommend(fits, scores, RANKED_BY, list(fits))


def test_the_best_of_those_that_are_ok_is_to_be_used_and_what_to_expect_is_said() -> None:
    scores = {"kalman": level(4.0), "ellipsoid": level(1.3, 0.02, True), UNCORRECTED: level(2310.0, 7.0)}
    found = told({"kalman": OK, "ellipsoid": OK}, scores)
    assert found.use == "ellipsoid"
    assert found.sentence == (
        "use ellipsoid: 1.3 nT on a level survey, heading 0.02° after one alignment with the vehicle; "
        "without correction 2310 nT on a level survey, heading 7°"
    )
    assert found.failed == {}
    assert found.closer == ()


def test_a_failed_one_is_not_to_be_used_however_small_its_error_and_that_is_said() -> None:
    scores = {"vector_lm": level(104.0), "kalman": level(8.0), "sphere": level(3000.0), UNCORRECTED: level(3900.0)}
    found = told({"vector_lm": OK, "kalman": LOOSE, "sphere": UNSEEN}, scores)
    assert found.use == "vector_lm"
    assert list(found.failed) == ["kalman", "sphere"]
    assert found.closer == (
        "kalman has a smaller error here than vector_lm, 8 nT, but reports that it did not converge "
        '("the start still weighs"), so it cannot be known beforehand',
    )


def test_where_all_failed_none_can_be_used() -> None:
    found = told({"kalman": LOOSE, "sphere": UNSEEN}, {"kalman": level(8.0), "sphere": [], UNCORRECTED: level(3900.0)})
    assert found.use == ""
    assert found.plain()["use"] is None
    assert found.sentence == "none can be used here: all 2 failed; without correction 3900 nT on a level survey"
    assert [text.split(",")[0] for text in found.closer] == ["kalman has a smaller error here than no correction"]


def test_a_fit_that_makes_it_worse_is_not_to_be_used() -> None:
    found = told({"sphere": OK}, {"sphere": level(40.0), UNCORRECTED: level(12.0)})
    assert found.use == ""
    assert found.sentence.startswith("use none of them: sphere, the best, leaves 40 nT on a level survey; without")


def test_an_array_is_answered_for_by_its_worst_sensor() -> None:
    ok = {"sphere@1": OK, "sphere@2": OK, "kalman@1": OK, "kalman@2": LOOSE, "ellipsoid@1": OK, "ellipsoid@2": OK}
    errors = {
        "sphere@1": 1.0,
        "sphere@2": 9.0,
        "kalman@1": 2.0,
        "kalman@2": 2.0,
        "ellipsoid@1": 5.0,
        "ellipsoid@2": 4.0,
    }
    scores = {name: level(error) for name, error in errors.items()}
    found = told(ok, scores | {f"{UNCORRECTED}@{k}": level(100.0) for k in (1, 2)})
    assert found.use == "ellipsoid"
    assert found.sentence.startswith("use ellipsoid: 5 nT on a level survey (the worst of 2 sensors); without")
    assert list(found.failed) == ["kalman@2"]
    assert found.closer[0].startswith("kalman has a smaller error here than ellipsoid, 2 nT")


@pytest.mark.parametrize("scores", [{}, {UNCORRECTED: level(12.0)}])
def test_without_calibrators_there_is_nothing_to_use(scores: dict[str, list[Score]]) -> None:
    assert told({}, scores).sentence.startswith("no calibrator was asked for")


def test_a_fit_without_scores_is_named_and_nothing_is_promised() -> None:
    assert told({"mine": OK}, {}).sentence == "use mine"
