"""Values that stand out from their neighbours in a series, compiled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

Mask = NDArray[np.bool_]


@njit(cache=True, fastmath={"reassoc", "contract", "nnan"})
def changes(columns: Array, sampled: int) -> tuple[Array, Array]:
    """Largest change (k,) from row to row of columns (n, k), and the median change (k,) of about `sampled` rows."""
    n, k = columns.shape
    largest, median = np.zeros(k), np.zeros(k)
    step = max((n - 1) // sampled, 1)
    some = np.empty((n - 2) // step + 1)
    for j in range(k):
        most = 0.0
        for i in range(n - 1):
            most = max(most, abs(columns[i + 1, j] - columns[i, j]))
        for i in range(len(some)):
            some[i] = abs(columns[i * step + 1, j] - columns[i * step, j])
        largest[j], median[j] = most, np.median(some)
    return largest, median


@njit(cache=True)
def away_from_median(columns: Array, half: int) -> Array:
    """Difference (n, k) of columns (n, k) from the running median over 2 half + 1 values, fewer at the ends.

    The window is kept sorted: each step takes out the oldest value and puts in the newest.
    """
    n, k = columns.shape
    out = np.empty((n, k))
    window = np.empty(2 * half + 2)
    for j in range(k):
        count = 0
        for i in range(-half, n):
            if i + half < n:
                count = _put(window, count, columns[i + half, j])
            if i - half - 1 >= 0:
                count = _take(window, count, columns[i - half - 1, j])
            if i >= 0:
                middle = 0.5 * (window[(count - 1) // 2] + window[count // 2])
                out[i, j] = columns[i, j] - middle
    return out


@njit(cache=True)
def _put(window: Array, count: int, value: float) -> int:
    """Insert a value into the first `count` sorted values."""
    place = count
    while place > 0 and window[place - 1] > value:
        window[place] = window[place - 1]
        place -= 1
    window[place] = value
    return count + 1


@njit(cache=True)
def _take(window: Array, count: int, value: float) -> int:
    """Remove a value from the first `count` sorted values."""
    place = 0
    while place < count - 1 and window[place] != value:
        place += 1
    for i in range(place, count - 1):
        window[i] = window[i + 1]
    return count - 1


@njit(cache=True)
def away_from_line(columns: Array, nearest: int, pairs: int) -> Array:
    """Difference (n, k) of columns (n, k) from the median of `pairs` estimates of a straight line beside each row.

    (v_i-k + v_i+k) / 2,  k = nearest ... nearest + pairs - 1;  2 v_i+k - v_i+2k in place of those beyond the end
    """
    n, k = columns.shape
    out, line = np.zeros((n, k)), np.empty(pairs + 1)
    for j in range(k):
        for i in range(n):
            count = 0
            for lag in range(nearest, nearest + pairs):
                if lag <= i < n - lag:
                    count = _put(line, count, 0.5 * (columns[i - lag, j] + columns[i + lag, j]))
                elif i < n - 2 * lag:
                    count = _put(line, count, 2.0 * columns[i + lag, j] - columns[i + 2 * lag, j])
                elif i >= 2 * lag:
                    count = _put(line, count, 2.0 * columns[i - lag, j] - columns[i - 2 * lag, j])
            if count:
                out[i, j] = columns[i, j] - 0.5 * (line[(count - 1) // 2] + line[count // 2])
    return out


@njit(cache=True)
def bridged(columns: Array, away: Array, limit: Array, half: int, share: float) -> tuple[Array, int]:
    """Columns (n, k) with the highest peaks of away (n, k) bridged by a line between their neighbours; number bridged.

    A peak is beyond limit (n, k) and beyond a share of the largest away within `half` rows.
    """
    n, k = columns.shape
    out, count = columns.copy(), 0
    for j in range(k):
        last = -1  # row before the peak
        for i in range(n):
            largest = limit[i, j] / share
            for row in range(max(i - half, 0), min(i + half + 1, n)):
                largest = max(largest, abs(away[row, j]))
            if abs(away[i, j]) > share * largest:
                count += 1
                if i < n - 1:
                    continue
                for row in range(last + 1, n):
                    out[row, j] = columns[max(last, 0), j]
            for row in range(last + 1, i):
                before = columns[last, j] if last >= 0 else columns[i, j]
                out[row, j] = before + (columns[i, j] - before) * (row - last) / (i - last)
            last = i
    return out, count


@njit(cache=True)
def short_runs(columns: Array, smooth: Array, limit: Array, longest: int, half: int, most: int, edge: float) -> Mask:
    """Rows (n,) in which a column (n, k) leaves the smooth one by more than the limit, in runs of at most `longest`.

    A run begins and ends at an edge; beside the run columns change by less than `edge` of this, or the run is the top
    or the beginning of a longer disturbance. Edges cut a longer run into several. No row of which more than `most` of
    the rows within `half` on either side are beyond the limit.
    """
    n, k = columns.shape
    far, total = np.zeros(n, np.bool_), np.zeros(n + 1, np.int64)
    for i in range(n):
        for j in range(k):
            far[i] |= abs(columns[i, j] - smooth[i, j]) > limit[i, j]
        total[i + 1] = total[i] + far[i]
    out, first = np.zeros(n, np.bool_), 0
    while first < n:
        last = first + 1
        if far[first]:
            while last < n and far[last]:
                last += 1
            begins = first < 2 or _is_edge(columns, smooth, limit, first, first - 1, first - 2, edge)
            ends = last > n - 2 or _is_edge(columns, smooth, limit, last - 1, last, last + 1, edge)
            if begins and ends and _longest_piece(columns, smooth, first, last, edge) <= longest:
                for i in range(first, last):
                    out[i] = total[min(i + half + 1, n)] - total[max(i - half, 0)] <= most
        first = last
    return out


@njit(cache=True)
def _is_edge(columns: Array, smooth: Array, limit: Array, inside: int, beside: int, beyond: int, edge: float) -> bool:
    """Whether a column beyond the limit inside changes by more to the row beside than that to the row beyond."""
    for j in range(columns.shape[1]):
        away = abs(columns[inside, j] - smooth[inside, j])
        change = abs(columns[inside, j] - columns[beside, j])
        if away > limit[inside, j] and abs(columns[beside, j] - smooth[beyond, j]) < edge * change:
            return True
    return False


@njit(cache=True)
def _longest_piece(columns: Array, smooth: Array, first: int, last: int, edge: float) -> int:
    """Most rows of a run between changes of a column by more than `edge` of the larger deviation."""
    most, begin = 0, first
    for i in range(first + 1, last):
        cut = False
        for j in range(columns.shape[1]):
            before, after = columns[i - 1, j] - smooth[i - 1, j], columns[i, j] - smooth[i, j]
            cut |= abs(after - before) > edge * max(abs(before), abs(after))
        if cut:
            most, begin = max(most, i - begin), i
    return max(most, last - begin)
