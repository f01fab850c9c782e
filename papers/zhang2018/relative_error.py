"""Row of [Zhang2018]'s figure 11: relative error against iterations, by search."""

from __future__ import annotations

import numpy as np

from papers.base import PaperRow
from papers.judgement import claim
from papers.zhang2018.trials import MAIN, METHODS, ZhangTrial, rms_nT, spiral, strength_nT
from validation.text import figure

ITERATIONS = (10, 50, 100, 200)


def relative_error_rows(trials: list[ZhangTrial]) -> list[PaperRow]:
    """Return the two claims of figure 11: the error falls with the iterations, and PSOGA's is the lowest."""
    F = strength_nT(spiral(False))
    share = {name: rms_nT(trials, MAIN, name)[:, [n - 1 for n in ITERATIONS]] / F for name in METHODS}
    falls = float(np.mean([np.all(np.diff(values, axis=1) <= 0, axis=1) for values in share.values()]))
    others = np.minimum(share["pso"], share["ga"])
    lowest = np.mean(share["psoga"] < others, axis=0)
    medians = "; ".join(
        f"{name} {', '.join(figure(1e6 * v) for v in np.median(values, axis=0))}" for name, values in share.items()
    )
    at = ", ".join(map(str, ITERATIONS))
    return [
        PaperRow(
            f"figure 11: relative error of the total field falls with the iterations ({at})",
            "falls",
            f"falls throughout in {100 * falls:.0f} % of the searches",
            claim(falls > 0.5, "more than half of the searches", "the figure shows one run of each"),
            f"median rms over F, 1e-6: {medians}",
        ),
        PaperRow(
            f"figure 11: PSOGA's relative error is the lowest at equal iterations ({at})",
            "lowest at all",
            f"lowest in {', '.join(f'{100 * v:.0f}' for v in lowest)} % of the seeds",
            claim(lowest.min() > 0.95, "95 % of the seeds at each", "an order claimed without exception"),
            "one of three by chance is 33 %",
        ),
    ]
