"""Values that one of a scenario's takes: found by any ending of the key, put in as written."""

from __future__ import annotations

import pytest

from scenarios.errors import InputError
from scenarios.sweep import parse_sweep, points, swept
from scenarios.toml import as_dict
from sim.scenario import load

SCENARIO = load("auv-spiral")
NOISE = "effects.white_noise.std_nT"


@pytest.mark.parametrize("name", [NOISE, "white_noise.std_nT", "noise_std_nT", "std_nT"])
def test_a_key_is_found_by_an_ending_that_no_other_has(name: str) -> None:
    sweep = parse_sweep(f"{name}=1,5,1e1", SCENARIO)
    assert (sweep.key, sweep.values) == (NOISE, (1, 5, 10.0))


def test_a_number_fills_a_vector_and_leaves_the_rest() -> None:
    changed = swept(SCENARIO, {NOISE: 3.0, "effects.hard_iron.offset_nT.1": 7.0})
    before, after = as_dict(SCENARIO), as_dict(changed)
    assert after["effects"].pop("white_noise") == {"std_nT": [3.0, 3.0, 3.0]}
    assert after["effects"].pop("hard_iron") == {"offset_nT": [1200.0, 7.0, -2000.0]}
    del before["effects"]["white_noise"], before["effects"]["hard_iron"]
    assert after == before


@pytest.mark.parametrize(
    ("text", "values"),
    [("0:30:10", (0, 10, 20, 30)), ("0.1:0.45:0.1", (0.1, 0.2, 0.3, 0.4)), ("3:-1:-2", (3, 1, -1)), ("5:5:1", (5,))],
)
def test_a_range_holds_both_ends(text: str, values: tuple[float, ...]) -> None:
    assert parse_sweep(f"vertical_speed_m_s={text}", SCENARIO).values == values


@pytest.mark.parametrize("text", ["5:1:1", "1:5:0", "0:1:0.0001"])
def test_a_range_that_leads_nowhere(text: str) -> None:
    with pytest.raises(InputError, match="--what-if radius_m"):
        parse_sweep(f"radius_m={text}", SCENARIO, "--what-if")


def test_words_too() -> None:
    sweep = parse_sweep("field.date=2018-01-01,2020-01-01", SCENARIO)
    assert [str(swept(SCENARIO, values).field.date) for values in points([sweep])] == list(sweep.values)


def test_points_are_all_combinations_and_the_last_key_changes_fastest() -> None:
    sweeps = [parse_sweep("noise_std_nT=1,2", SCENARIO), parse_sweep("radius_m=20,30", SCENARIO)]
    assert [tuple(point.values()) for point in points(sweeps)] == [(1, 20), (1, 30), (2, 20), (2, 30)]
    assert points([]) == [{}]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("noise_std_nT", "not a key and its values"),
        ("noise_std_nT=", "not a key and its values"),
        ("noise_std_nT=1,,2", "not a key and its values"),
        ("noise_std_nT=1,1.0", "twice"),
        ("noise_std=1,2", "or effects.white_noise.std_nT"),
        ("correlation_s=1", "navigation.attitude_correlation_s"),
        ("name=a,b", "no value name"),
        ("effects.soft_iron.matrix=1,2", "effects.soft_iron.matrix.0.0"),
        ("radius_m=20,-5", "phases.0.radius_m"),
        ("noise_std_nT=[1;2],2", "the value is not TOML"),
    ],
)
def test_what_cannot_be_swept_is_one_line_with_what_to_do(text: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        _all_of(text)


def test_a_key_twice() -> None:
    with pytest.raises(InputError, match="swept twice"):
        points([parse_sweep("noise_std_nT=1", SCENARIO), parse_sweep("std_nT=2", SCENARIO)])


def test_what_varies_from_run_to_run_cannot_be_swept() -> None:
    drawn = load("auv-spiral", [f'vary."{NOISE}".uniform=[1,5]'])
    with pytest.raises(InputError, match=r"draws .* anew in each run"):
        parse_sweep("noise_std_nT=1,2", drawn)


def _all_of(text: str) -> list[object]:
    return [swept(SCENARIO, values) for values in points([parse_sweep(text, SCENARIO)])]
