"""The reproduction of [Zhou2012]: its simulated turn, its bound, and its rows."""

from __future__ import annotations

import numpy as np
import pytest

from papers.zhou2012.paper import Zhou2012
from papers.zhou2012.separate import corrections
from papers.zhou2012.trials import NOISE_NT, PRINTED, STOPS, bound, recording, stops


@pytest.fixture(scope="module")
def run():
    """What six seeds find, and the pieces of work that were told."""
    told = []
    return Zhou2012(seeds=6).run(progress=lambda done, total: told.append((done, total))), told


def test_the_stops_are_a_clockwise_turn_of_a_level_sensor():
    state = stops()
    assert len(state) == STOPS
    assert np.ptp(state.field_nT[:, 2]) < 1e-9
    np.testing.assert_allclose(np.linalg.norm(state.field_nT, axis=1), np.linalg.norm(state.field_enu_nT))
    # turned clockwise, the sensor sees the horizontal field turn counter-clockwise
    azimuth = np.unwrap(np.arctan2(state.field_nT[:, 1], state.field_nT[:, 0]))
    np.testing.assert_allclose(np.diff(azimuth), np.radians(30.0))


def test_the_sensor_measures_through_the_paper_s_matrix():
    state = stops()
    a1, b1, b2, c1, c2 = PRINTED
    rows = [(np.sqrt(1 - a1**2), 0, a1), (b1, np.sqrt(1 - b1**2 - b2**2), b2), (c1, c2, np.sqrt(1 - c1**2 - c2**2))]
    noise_nT = recording(state, 0).mag_nT - state.field_nT @ np.array(rows).T
    assert noise_nT.std() == pytest.approx(NOISE_NT, rel=0.4)


def test_the_bound_has_the_size_of_the_harmonics():
    state, limit = stops(), bound(stops())
    assert limit.shape == (5,)
    level = np.hypot(*state.field_enu_nT[:2])
    # c1 moves z by H in the first harmonic; b1 moves the horizontal length by H / 2 in the second
    assert limit[3] == pytest.approx(NOISE_NT * np.sqrt(2 / STOPS) / level, rel=0.05)
    assert limit[1] == pytest.approx(NOISE_NT * np.sqrt(2 / STOPS) * 2 / level, rel=0.05)


def test_every_claim_holds_and_each_piece_of_work_is_told(run):
    found, told = run
    verdicts = {row.what: row.verdict for row in found.rows if "flown" not in row.what}
    assert "does not hold" not in verdicts.values()
    assert sum(verdict == "holds" for verdict in verdicts.values()) == 8
    assert told[-1] == (30, 30)
    assert all(row.note for row in found.rows)
    table = {"0.013572", "0.000115", "-0.006312", "-0.021201", "-0.003657"}  # the paper's a1, b1, b2, c1, c2
    assert table <= {row.paper for row in found.rows}


def test_separate_corrections_leave_the_other_error():
    state = stops()
    a1, b1, b2, c1, c2 = PRINTED
    x, y, z = (np.sqrt(1 - a1**2), 0, a1), (b1, np.sqrt(1 - b1**2 - b2**2), b2), (c1, c2, np.sqrt(1 - c1**2 - c2**2))
    left = {n: h - state.field_nT for n, h in corrections(state.field_nT @ np.array((x, y, z)).T).items()}
    assert np.abs(left["one after the other"]).max() < 1e-3
    level, up = np.hypot(*state.field_enu_nT[:2]), state.field_enu_nT[2]
    # without levelness z still holds the level field's share: rms of H (c1 cos p + c2 sin p)
    rms_z = level * np.hypot(c1, c2) / np.sqrt(2)
    assert left["non-orthogonality alone"][:, 2].std() == pytest.approx(rms_z, rel=0.02)
    # without orthogonality x and y still hold the vertical field's share: (a1 + c1) V and (b2 + c2) V
    mean = left["non-levelness alone"].mean(axis=0)
    assert tuple(mean[:2]) == pytest.approx(((a1 + c1) * up, (b2 + c2) * up), rel=0.03)
    assert np.abs(left["both, separately"]).max() < 2 * np.hypot(level, up) * max(map(abs, PRINTED)) ** 2


@pytest.mark.slow
def test_the_rows_are_the_same_on_two_processes():
    assert Zhou2012(seeds=4).run(jobs=2).rows == Zhou2012(seeds=4).run(jobs=1).rows


def test_pictures(run):
    found, _ = run
    assert set(found.figures) == {"objective", "parameters", "z"}
    for draw in found.figures.values():
        assert draw().axes[0].get_title()
