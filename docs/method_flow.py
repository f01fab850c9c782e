"""The flow of a diagnosis for `diagnosis-method.md`: a box a step, what goes in at its left, what comes out."""

from __future__ import annotations

from typing import Any, NamedTuple

from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from diagnosis.policy import STANDARD
from reports.palette import AFTER, BEFORE, INK, SOFT
from sim.effects import EFFECTS

WIDTH_IN, ROW_IN, BOX_IN, HEAD_IN = 7.0, 0.82, 0.56, 0.62
LEFT_IN, RIGHT_IN, GAP_IN = 1.62, 5.38, 0.16
"""Ends of a box over the whole width, and what lies between two boxes of a row."""
PALE = "#eef3f8"


class Step(NamedTuple):
    """A box in a row of the picture: side 0 is the whole width, 1 and 2 its halves."""

    row: int
    title: str
    text: str
    given: str = ""
    found: str = ""
    side: int = 0

    @property
    def ends_in(self) -> tuple[float, float]:
        """Left and right end of the box."""
        half = (RIGHT_IN - LEFT_IN - GAP_IN) / 2
        left = RIGHT_IN - half if self.side == 2 else LEFT_IN
        return left, RIGHT_IN if self.side != 1 else LEFT_IN + half


def steps() -> tuple[Step, ...]:
    """The nine steps with the limits of the standard policy."""
    policy = STANDARD
    white, coloured, apart = policy.accepted(len(EFFECTS)), policy.coloured_nats, policy.apart
    share = 100 * policy.same_coloured
    return (
        Step(0, "1  Direct evidence", "steps, full scale, repeats, spikes: samples left out", "the values", "faults"),
        Step(
            *(1, "2  Iron and reference", "least squares: free matrix, offset; noise of a sample"),
            *("attitude, field,\nmodel", "the gap; a wrong\nreference"),
        ),
        Step(
            *(2, "3  Candidates", "each effect with a recorded cause becomes columns"),
            *("motion, currents,\ntemperature, ...", "columns E"),
        ),
        Step(3, "4  White", f"> {white:.0f} nats held out", "is the gap white?", side=1),
        Step(3, "5  Coloured", f"> {coloured:.0f} nats, beats rivals", "", "the best\ncandidate", 2),
        Step(
            *(
                4,
                "6  One cause",
                f"within {apart:.1f} nats or {share:.0f} % of the best, of no use beside it",
            ),
            *("", "its class of\nlook-alikes"),
        ),
        Step(5, "7  Residual", f"means, tones, tails, rise: chance below {policy.test_alarm:g}", "", "slow noise"),
        Step(
            *(6, "8  Change of the iron", "fitted against stated iron; stated errors are no gap"),
            *("the model's iron", "the verdict"),
        ),
        Step(
            *(7, "9  Check by the simulator", "model.toml run along the recorded motion, no fit"),
            *("the verdict's model", "the gap that\nis left"),
        ),
    )


def draw_flow() -> Figure:
    """Draw the steps from top to bottom, and the way back from a residual that is not clean."""
    drawn = steps()
    height_in = HEAD_IN + ROW_IN * (1 + max(step.row for step in drawn))
    figure = Figure(figsize=(WIDTH_IN, height_in))
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0, WIDTH_IN), ylim=(-height_in, 0))
    axis.set_axis_off()
    for step in drawn:
        _box(axis, step)
    for above in drawn:
        for below in drawn:
            if below.row == above.row + 1:
                _arrow(axis, _middle(above, below), (_middle(below, above), _top(below)), _top(above) - BOX_IN)
    _sources(axis, drawn[0])
    _back(axis, drawn[6], drawn[3])
    return figure


def _top(step: Step) -> float:
    return -HEAD_IN - ROW_IN * step.row


def _middle(step: Step, other: Step) -> float:
    """Where an arrow between two boxes meets the first: above or below the narrower one."""
    left, right = step.ends_in if step.side or not other.side else other.ends_in
    return (left + right) / 2


def _box(axis: Any, step: Step) -> None:
    (left, right), top = step.ends_in, _top(step)
    shape = {"boxstyle": "round,pad=0,rounding_size=0.07", "facecolor": PALE, "edgecolor": AFTER, "linewidth": 0.9}
    axis.add_patch(FancyBboxPatch((left, top - BOX_IN), right - left, BOX_IN, **shape))
    axis.text(left + 0.1, top - 0.17, step.title, va="center", fontsize=9.5, fontweight="bold", color=INK)
    axis.text(left + 0.1, top - 0.39, step.text, va="center", fontsize=8.8, color=INK)
    level = top - BOX_IN / 2
    if step.given:
        axis.text(LEFT_IN - 0.3, level, step.given, va="center", ha="right", fontsize=8.8, color=SOFT)
        _arrow(axis, LEFT_IN - 0.26, (left, level), level)
    if step.found:
        axis.text(RIGHT_IN + 0.3, level, step.found, va="center", fontsize=8.8, color=SOFT)
        _arrow(axis, right, (RIGHT_IN + 0.26, level), level)


def _arrow(axis: Any, x: float, end: tuple[float, float], y: float, colour: str = SOFT) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8}
    axis.annotate("", end, (x, y), arrowprops=style)


def _sources(axis: Any, first: Step) -> None:
    """The recording and the model above the first step."""
    middle = _middle(first, first)
    axis.text(middle, -0.2, "recording  and  model", ha="center", va="center", fontsize=9.5, fontweight="bold")
    _arrow(axis, middle, (middle, _top(first)), -0.32)


def _back(axis: Any, residual: Step, choice: Step) -> None:
    """From a residual that is not clean back to the choice, with the accepted effects fitted."""
    x, low, high = LEFT_IN - 0.14, _top(residual) - BOX_IN / 2, _top(choice) + 0.13
    axis.plot([LEFT_IN, x, x], [low, low, high], color=BEFORE, linewidth=0.9)
    _arrow(axis, x, (_middle(choice, choice), high), high, BEFORE)
    most = STANDARD.most_effects
    words = f"not clean:\nfit again with the\nnext effect, at\nmost {most} in all"
    axis.text(x - 0.06, (low + high) / 2 - 0.25, words, va="center", ha="right", fontsize=8.8, color=BEFORE)
