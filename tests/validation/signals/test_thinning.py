"""Thinned series: nothing that stands out is lost."""

from __future__ import annotations

import numpy as np

from validation.signals.thinning import envelope, every_nth


def test_envelope_keeps_spikes_order_and_gaps() -> None:
    time_s, values = np.arange(100_000) / 50, np.zeros((100_000, 3))
    values[54_321, 1], values[77_777, 2] = 1e4, -1e4
    values[10_000:40_000, 0] = np.nan
    thin_s, thin = envelope(time_s, values, 500)
    assert len(thin_s) <= 1000
    assert np.all(np.diff(thin_s) >= 0)
    assert np.nanmax(thin[:, 1]) == 1e4
    assert np.nanmin(thin[:, 2]) == -1e4
    assert abs(thin_s[np.nanargmax(thin[:, 1])] - time_s[54_321]) < 2 * 200 / 50
    assert 0.28 < np.isnan(thin[:, 0]).mean() < 0.31
    same_s, same = envelope(time_s[:900], values[:900], 500)
    assert same_s is not thin_s
    assert np.shares_memory(same, values)


def test_stride_keeps_at_most_so_many() -> None:
    for n in (1, 10, 11, 99, 1000):
        assert 1 <= len(range(n)[every_nth(n, 10)]) <= 10
