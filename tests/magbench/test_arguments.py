"""Arguments in words, before anything is computed."""

from __future__ import annotations

from magbench.arguments import drawn_anew


def test_a_set_value_that_vary_draws_anew_is_told() -> None:
    varied = {"effects.white_noise.std_nT": object()}
    told = drawn_anew(["sampling.rate_hz=5", "effects.white_noise.std_nT = 3"], varied)
    assert told.startswith("--set effects.white_noise.std_nT: ")
    assert drawn_anew(["sampling.rate_hz=5"], varied) == ""
