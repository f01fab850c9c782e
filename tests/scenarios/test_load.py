"""Loading: strict, one clear line for every mistake; overrides; text."""

import copy
import re
from pathlib import Path
from typing import Any

import pytest
import tomlkit

from scenarios.errors import InputError
from scenarios.toml import as_dict, to_toml
from sim.effects.faults import Spikes
from sim.effects.noise import WhiteNoise
from sim.scenario import Scenario, load, load_model

GOOD = """
name = "test"
summary = "a test"

[field]
enu_nT = [1000, 20000, -40000]

[vehicle]
kind = "auv"

[[phases]]
kind = "hover"

[[phases]]
kind = "spiral"
radius_m = 20
turn_rate_deg_s = 2.0
turns = 2

[effects.white_noise]
std_nT = [1, 1, 1]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "test.toml"
    path.write_text(GOOD)
    return path


def message(path: Path | str, *overrides: str) -> str:
    with pytest.raises(InputError) as caught:
        load(path, overrides)
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < 500
    return text


BAD = {
    "not TOML": ("radius_m = 20", "radius_m 20", r"not TOML.*line 16"),
    "unknown key": ("radius_m = 20", "radius_n = 20", r"phases\.1\.radius_n: unknown key.*did you mean radius_m"),
    "unknown table": ("[field]", "[feild]", r"feild: unknown key.*did you mean field"),
    "unknown vehicle key": ('kind = "auv"', 'kind = "auv"\nheading = 1', r"vehicle\.heading: .*heading_deg"),
    "unknown field key": ("enu_nT", "enu_nt", r"field\.enu_nt: .*enu_nT"),
    "unknown phase kind": ('"spiral"', '"sprial"', r"phases\.1: unknown kind \"sprial\".*spiral"),
    "no phase kind": ('kind = "spiral"', "", r"phases\.1: kind is missing.*comb"),
    "unknown vehicle": ('"auv"', '"auw"', r"vehicle: unknown kind \"auw\".*auv"),
    "missing parameter": ("radius_m = 20", "", r"phases\.1\.radius_m: missing"),
    "text for a number": ("radius_m = 20", 'radius_m = "20"', r"phases\.1\.radius_m: .*valid number; found '20'"),
    "truth for a number": ("radius_m = 20", "radius_m = true", r"phases\.1\.radius_m: .*valid number"),
    "out of range": ("radius_m = 20", "radius_m = -20", r"phases\.1\.radius_m: .*greater than 0; found -20"),
    "not a number": ("radius_m = 20", "radius_m = nan", r"phases\.1\.radius_m: .*finite"),
    "infinite": ("radius_m = 20", "radius_m = inf", r"phases\.1\.radius_m: .*finite"),
    "vector too short": ("[1000, 20000, -40000]", "[1000, 20000]", r"field\.enu_nT\.2: missing"),
    "vector of text": ("[1000, 20000, -40000]", '"north"', r"field\.enu_nT: .*found 'north'"),
    "two of one": ("turns = 2", "turns = 2\nduration_s = 300", r"phases\.1: give either duration_s or turns"),
    "none of one": ("turns = 2", "", r"phases\.1: give either duration_s or turns"),
    "no phases": (GOOD[GOOD.index("[[phases]]") : GOOD.index("[effects")], "", r"phases: missing"),
    "wrong vehicle": ('"auv"', '"turntable"', r"phases\.0\.kind: the turntable cannot do a \"hover\".*auv.*quadrotor"),
    "wrong phase": ('kind = "hover"', 'kind = "tumble"', r"phases\.0\.kind: the auv cannot do a \"tumble\".*turntable"),
    "name": ('"test"', '"Test 1"', r"name: .*pattern"),
    "effect is no table": ("[effects.white_noise]", "[effects]", r"effects\.std_nT: an effect is a table"),
    "sample rate": ("[field]", "[sampling]\nrate_hz = 7\n[field]", r"sampling: rate_hz must divide 50"),
    "place and vector": ("enu_nT", "latitude_deg = 3\nenu_nT", r"field: give either enu_nT"),
    "ten years": ("turns = 2", "turns = 10000\nrun_in_s = 20", r"the phases last .* s together, at most 864000 s"),
    "storm": ('kind = "auv"', 'kind = "auv"\ncurrent_enu_m_s = [1e6, 0, 0]', r"current_enu_m_s\.0: .*equal to 10"),
    "field of a star": ("1000, 20000", "1e300, 20000", r"field\.enu_nT\.0: "),
    "lost attitude": ("[field]", "[navigation]\nattitude_noise_std_deg = 1e300\n[field]", r"attitude_noise_std_deg"),
    "hardly a sample": ("[field]", "[sampling]\nrate_hz = 1e-300\n[field]", r"rate_hz: .*equal to 0\.01"),
    "seed too long": ('"test"', '"test"\nseed = 9223372036854775808', r"seed: "),
    "number too long": ("radius_m = 20", "radius_m = " + 5000 * "2", r"number too long"),
    "arrays too deep": ('"test"', '"test"\nx = ' + 5000 * "[" + 5000 * "]", r"nested too deep"),
    "tables too deep": ("[field]", "[" + ".".join(3000 * "a") + "]\n[field]", r"nested too deep"),
    "vary unknown": ("[field]", '[vary]\n"phases.1.radius" = {uniform=[1,2]}\n[field]', r"phases\.1\.radius.*radius_m"),
    "vary no number": ("[field]", "[vary]\nname = {uniform=[1,2]}\n[field]", r"vary\.name: not a number"),
    "vary out of range": ("[field]", '[vary]\n"phases.1.radius_m" = {uniform=[-9,2]}\n[field]', r"vary: phases\.1\."),
    "vary both": ("[field]", '[vary]\n"seed" = {uniform=[1,2], normal=[1,2]}\n[field]', r"vary\.seed: give uniform"),
    "vary reversed": ("[field]", '[vary]\n"phases.1.radius_m" = {uniform=[9,2]}\n[field]', r"low above high"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_file_is_told_in_one_line(case: str, file: Path) -> None:
    old, new, expected = BAD[case]
    assert old in GOOD
    file.write_text(GOOD.replace(old, new, 1))
    text = message(file)
    assert text.startswith(str(file))
    assert re.search(expected, text), text


BAD_OVERRIDES = {
    "phases.1.radius=3": r"phases\.1\.radius: unknown key.*radius_m",
    "phases.7.radius_m=3": r"phases is an array and has no entry 7.*0 to 1",
    "phases.first.radius_m=3": r"no entry first",
    "phases.1.radius_m=-3": r"phases\.1\.radius_m: .*greater than 0",
    "phases.1.radius_m=wide": r"phases\.1\.radius_m: .*valid number; found 'wide'",
    "phases.1.radius_m.x=1": r"phases\.1\.radius_m is a value and has no key x",
    "phases.1.duration_s=300": r"phases\.1: give either duration_s or turns",
    "phases.0.kind=tumble": r"phases\.0\.kind: the auv cannot",
    "vehicle.current_enu_m_s=[0.1,0,": r"the value is not TOML",
    "vehicle.current_enu_m_s=[0.1,0]": r"vehicle\.current_enu_m_s\.2: missing",
    "seed=1\nname='x'": r"more than one value",
    "sed=1": r"sed: unknown key.*seed",
    "seed": r"not a dotted key and a value",
    "=1": r"not a dotted key and a value",
    "a..b=1": r"not a dotted key and a value",
    "field.date=": r"nothing to remove",
    "phases.1.radius_m=": r"phases\.1\.radius_m: missing",
    "effects.spikes=3": r"effects\.spikes: an effect is a table",
}


@pytest.mark.parametrize("override", BAD_OVERRIDES)
def test_bad_override_is_told_in_one_line(override: str, file: Path) -> None:
    text = message(file, override)
    assert text.startswith("--set " + " ".join(override.split())), text
    assert re.search(BAD_OVERRIDES[override], text), text


JUNK: tuple[Any, ...] = (3, -1.5, "junk", True, [], [1], [{}], {}, {"kind": "spiral"}, {"junk": 1}, [[1, 2]])


def _places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [place for key, value in items for place in ((*path, key), *_places(value, (*path, key)))]


@pytest.mark.parametrize("name", ["auv-dive", pytest.param("gradiometer-turntable", marks=pytest.mark.slow)])
def test_junk_in_any_place_loads_or_is_told(name: str, tmp_path: Path) -> None:
    path, told, whole = tmp_path / "junk.toml", list[str](), as_dict(load(name))
    for count, place in enumerate(_places(whole)):
        data = copy.deepcopy(whole)
        node = data
        for key in place[:-1]:
            node = node[key]
        for junk in JUNK[count % 6 :: 6]:
            node[place[-1]] = junk
            path.write_text(tomlkit.dumps(data))
            try:
                load(path)
            except InputError as error:
                told.append(str(error))
    assert len(told) > 75
    assert not any("\n" in text for text in told)


def test_unreadable_files_are_told(tmp_path: Path) -> None:
    assert "no such file" in message(tmp_path / "missing.toml")
    assert "did you mean auv-spiral" in message("auv-spirl")
    assert "is a directory" in message(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe9"')
    assert "not UTF-8" in message(tmp_path / "latin.toml")


def test_marks_and_line_ends_of_other_systems_do_not_matter(file: Path) -> None:
    plain = load(file)
    file.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert load(file) == plain


def test_overrides_replace_values(file: Path) -> None:
    overrides = (
        *("phases.1.turns=", "phases.1.duration_s=300", "vehicle.current_enu_m_s=[0.1, 0, 0]"),
        *("effects.white_noise.std_nT=[5, 5, 5]", "effects.spikes.rate_hz=0.1", "name=other", "sampling.rate_hz=5"),
        '"effects".white_noise.std_nT.1=6',
    )
    scenario = load(file, overrides)
    assert scenario.phases[1].duration_s == 300
    assert scenario.vehicle.model_dump()["current_enu_m_s"] == (0.1, 0, 0)
    assert scenario.effects.written == {"white_noise": {"std_nT": [5, 6, 5]}, "spikes": {"rate_hz": 0.1}}
    assert scenario.chain() == (WhiteNoise((5, 6, 5)), Spikes(0.1))
    assert (scenario.name, scenario.sampling.rate_hz) == ("other", 5)


def test_quoted_keys_reach_vary(file: Path) -> None:
    scenario = load(file, ['vary."phases.1.radius_m".uniform=[10, 30]'])
    assert scenario.vary["phases.1.radius_m"].uniform == (10, 30)


def test_as_dict_validates_back(file: Path) -> None:
    assert Scenario.model_validate(as_dict(load(file))) == load(file)


def test_to_toml_loads_back_equal(file: Path, tmp_path: Path) -> None:
    scenario = load(file, ["effects.bandwidth={}", "thermal.deep_degC=4", "summary='a \"b\"'"])
    again = tmp_path / "again.toml"
    again.write_text(to_toml(scenario))
    assert load(again) == scenario


def test_model_of_a_scenario_or_of_two_tables(file: Path, tmp_path: Path) -> None:
    tables = tmp_path / "model.toml"
    tables.write_text("[field]\nenu_nT = [1000, 20000, -40000]\n[effects.white_noise]\nstd_nT = [1, 1, 1]\n")
    whole, part = load_model(file), load_model(tables)
    assert (whole.field, whole.effects) == (part.field, part.effects)
    tables.write_text(to_toml(part))
    assert load_model(tables) == part
    with pytest.raises(InputError, match=r"efects: unknown key.*effects"):
        load_model(tables, ["efects.white_noise.std_nT=1"])
