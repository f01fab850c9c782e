"""The limit holds within and is taken back after."""

from __future__ import annotations

from threadpoolctl import threadpool_info, threadpool_limits

from calib.numerics.threads import one_thread


def test_one_thread_within_and_as_many_as_before_after() -> None:
    with threadpool_limits(limits=2):
        with one_thread():
            within = {one["num_threads"] for one in threadpool_info()}
        after = {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}
    assert within == {1}
    assert after == {2}
