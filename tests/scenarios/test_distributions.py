"""Every distribution draws what its name says, by scipy's own; what cannot be drawn is told when it is loaded."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from scenarios.distributions import Distribution
from scenarios.errors import InputError
from scenarios.varied import Vary
from scenarios.vary import apply_vary, check_vary, values_at
from sim.scenario import Scenario, load

OFFSET = "effects.hard_iron.offset_nT"
MATRIX = "effects.soft_iron.matrix"
ALPHA = 1e-4
"""Chance of a sound distribution to fail a test; the seeds are fixed, so it fails always or never."""


def scenario(how: str, key: str = OFFSET) -> Scenario:
    return load("auv-spiral", [f'vary."{key}"={how}'])


def _drawn(given: Scenario, key: str, rng: np.random.Generator) -> Any:
    return values_at(apply_vary(given, rng), [key])[key]


def offsets(how: str, count: int = 1000) -> Any:
    """Hard irons (count, 3) drawn one after another."""
    given, rng = scenario(how), np.random.default_rng(11)
    return np.array([_drawn(given, OFFSET, rng) for _ in range(count)])


def matrices(how: str, count: int = 300) -> Any:
    given, rng = scenario(how, MATRIX), np.random.default_rng(12)
    return np.array([_drawn(given, MATRIX, rng) for _ in range(count)])


@pytest.mark.parametrize(
    ("how", "expected"),
    [
        ("{uniform=[-400, 100]}", stats.uniform(-400, 500)),
        ("{normal=[50, 200]}", stats.norm(50, 200)),
        ("{log_uniform=[1, 1000]}", stats.loguniform(1, 1000)),
        ("{log_normal=[100, 0.7]}", stats.lognorm(0.7, scale=100)),
        ("{normal=[50, 200], truncated=[-100, 300]}", stats.truncnorm(-0.75, 1.25, 50, 200)),
    ],
    ids=lambda value: str(value)[:30],
)
def test_components_follow_the_law(how: str, expected: Any) -> None:
    drawn = offsets(how)
    for axis in drawn.T:
        assert stats.kstest(axis, expected.cdf).pvalue > ALPHA
    assert np.abs(np.corrcoef(drawn.T) - np.eye(3)).max() < 0.15


def test_a_relative_change_is_of_each_components_own_size() -> None:
    ratio = offsets("{relative_normal=0.05}") / [1200.0, 800.0, -2000.0]
    for axis in ratio.T:
        assert stats.kstest(axis, stats.norm(1, 0.05).cdf).pvalue > ALPHA


def test_means_and_deviations_may_be_given_by_component() -> None:
    drawn = offsets("{normal=[[100, 200, 300], [1, 10, 100]]}")
    for axis, mean, std in zip(drawn.T, (100, 200, 300), (1, 10, 100), strict=True):
        assert stats.kstest(axis, stats.norm(mean, std).cdf).pvalue > ALPHA


def many(how: dict[str, Any], count: int = 20_000) -> Any:
    """Vectors (count, 3) of the distribution alone: enough to see a direction or a correlation that is off by 10 %."""
    distribution, rng = Vary.model_validate(how).distribution, np.random.default_rng(13)
    assert isinstance(distribution, Distribution)
    return np.array([distribution.draw(np.zeros(3), rng) for _ in range(count)])


def test_directions_are_uniform_on_the_sphere() -> None:
    """Each component of a uniform direction is uniform (Archimedes), along any axis: the space diagonal, for one."""
    drawn = many({"on_sphere": 500.0})
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 500, rtol=1e-14)
    for axis in (*np.eye(3), np.ones(3) / np.sqrt(3)):
        assert stats.kstest(drawn @ axis, stats.uniform(-500, 1000).cdf).pvalue > ALPHA
    lengths = np.linalg.norm(offsets("{on_sphere=[200, 300]}"), axis=1)
    assert stats.kstest(lengths, stats.uniform(200, 100).cdf).pvalue > ALPHA


def test_correlated_components_have_their_covariance() -> None:
    """Whitened, they are independent standard normals."""
    mean, covariance = np.array([100.0, -50.0, 0.0]), np.array([[400.0, 300, 0], [300, 900, -60], [0, -60, 25]])
    drawn = many({"correlated": {"mean": mean.tolist(), "covariance": covariance.tolist()}})
    variances, axes = np.linalg.eigh(covariance)
    white = (drawn - mean) @ axes / np.sqrt(variances)
    np.testing.assert_allclose(np.cov(white.T), np.eye(3), atol=5 * np.sqrt(2 / len(white)))
    for axis in white.T:
        assert stats.kstest(axis, stats.norm(0, 1).cdf).pvalue > ALPHA
    assert offsets("{correlated={mean=[1, 2, 3], covariance=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}", 1).shape == (1, 3)


def test_a_symmetric_matrix_stays_symmetric() -> None:
    drawn = matrices("{normal=[0, 0.03], symmetric=true}")
    np.testing.assert_array_equal(drawn, drawn.transpose(0, 2, 1))
    for i, j in zip(*np.triu_indices(3), strict=True):
        assert stats.kstest(drawn[:, i, j], stats.norm(0, 0.03).cdf).pvalue > ALPHA


def test_a_choice_is_of_whole_values_and_of_text() -> None:
    drawn = offsets("{choice=[[1, 2, 3], [4, 5, 6]]}", 400)
    assert {tuple(one) for one in drawn} == {(1, 2, 3), (4, 5, 6)}
    assert stats.binomtest(int((drawn[:, 0] == 1).sum()), 400).pvalue > ALPHA
    turns = scenario('{choice=["2018-01-01", "2024-06-30"]}', "field.date")
    dates = {str(apply_vary(turns, np.random.default_rng(seed)).field.date) for seed in range(20)}
    assert dates == {"2018-01-01", "2024-06-30"}


def test_uniform_and_normal_draw_component_by_component() -> None:
    """As they always did: data sets of old scenarios keep their bytes."""
    rng = np.random.default_rng(11)
    expected = [float(rng.uniform(-400, 100)) for _ in range(3)]
    assert offsets("{uniform=[-400, 100]}", 1)[0].tolist() == expected
    rng = np.random.default_rng(11)
    expected = [float(rng.normal(50, 200)) for _ in range(3)]
    assert offsets("{normal=[50, 200]}", 1)[0].tolist() == expected


BAD = {
    "{uniform=[5, 1]}": "low above high",
    "{normal=[0, -1]}": "standard deviation is negative",
    "{normal=[[0, 0], [1, 1]]}": "found 2 numbers where the value needs one, or 3 numbers",
    "{normal=[true, 1]}": "expected numbers, found True",
    "{normal=[[0, [1], 2], 1]}": "not equally long",
    "{normal=[0, 1], uniform=[0, 1]}": "one of them, found uniform, normal",
    "{}": "one of them, found none",
    "{log_uniform=[0, 1]}": "low must be above zero",
    "{log_normal=[-5, 1]}": "median must be above zero",
    "{on_sphere=-1}": "the radius is negative",
    "{on_sphere=[1, 2, 3]}": r"expected a radius, or \[low, high\]",
    "{log_normal=[1e300, 100]}": "hard_iron.offset_nT",
    "{normal=[1e308, 1e308]}": "hard_iron.offset_nT",
    "{correlated={mean=[0, 0, 0], covariance=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]}}": "not positive definite",
    "{correlated={mean=[0, 0, 0], covariance=[[1, 2, 0], [1, 5, 0], [0, 0, 1]]}}": "not symmetric",
    "{correlated={mean=[0, 0], covariance=[[1, 0], [0, 1]]}}": "the mean has the shape",
    "{normal=[0, 1], symmetric=true}": "square matrix",
    "{choice=[]}": "at least 1",
    "{choice=[[1, 2]]}": r"hard_iron\.offset_nT: expected three numbers",
    '{choice=["a"]}': r"hard_iron\.offset_nT: expected three numbers",
    "{choice=[[1, 2, 3]], truncated=[0, 1]}": "neither truncated nor symmetric",
    "{normal=[0, 1], truncated=[50, 60]}": "none of 1000 draws lies between the bounds",
    "{normal=[0, 500000]}": r"hard_iron\.offset_nT.*outside -1e\+06 to 1e\+06.*add truncated = \[low, high\]",
    "{relative_normal=500}": r"outside -1e\+06 to 1e\+06",
}


@pytest.mark.parametrize("how", BAD)
def test_what_cannot_be_drawn_is_told_when_it_is_loaded(how: str) -> None:
    with pytest.raises(InputError, match=BAD[how]) as caught:
        scenario(how)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("key", ["vehicle", "sensors", "effects.hard_iron"])
def test_tables_do_not_vary_as_a_whole(key: str) -> None:
    """Another vehicle or sensor would give a run other columns than the others have."""
    with pytest.raises(InputError, match=r"tables cannot vary as a whole"):
        scenario('{choice=[{kind="quadrotor"}]}', key)


def test_a_sphere_needs_a_vector_of_three() -> None:
    with pytest.raises(InputError, match=r"on_sphere draws a vector of three numbers"):
        scenario("{on_sphere=1}", "phases.0.radius_m")


def test_truncation_lets_a_wide_distribution_in() -> None:
    given = scenario("{normal=[0, 500000], truncated=[-900000, 900000]}")
    check_vary(given, "")
    draws = [_drawn(given, OFFSET, np.random.default_rng(seed)) for seed in range(30)]
    assert np.abs(draws).max() <= 900_000


def test_what_varies_is_written_and_read_back(tmp_path: Path) -> None:
    from scenarios.toml import as_dict, to_toml

    given = load("auv-spiral", [f'vary."{MATRIX}"={{normal=[0, 0.01], symmetric=true, truncated=[-0.02, 0.02]}}'])
    path = tmp_path / "again.toml"
    path.write_text(to_toml(given))
    assert load(path) == given
    assert Scenario.model_validate(as_dict(given)) == given
