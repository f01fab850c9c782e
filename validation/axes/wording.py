"""Axes of a magnetometer in words, with the option that mends them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from validation.axes.estimate import Axes
from validation.axes.maps import TURNS, is_turn
from validation.text import listed

Kind = Literal["alone", "undetermined", "agree", "turned", "left_handed", "reversed", "contradiction", "gyro_reversed"]
MOST_LISTED = 4
"""Maps that are listed; more are counted."""


@dataclass(frozen=True)
class AxesVerdict:
    """Verdict on the axes of a magnetometer: one word for files, and a clause that says what to do."""

    kind: Kind
    text: str

    @property
    def harmless(self) -> bool:
        """Whether nothing speaks against the axes as logged."""
        return self.kind in ("alone", "undetermined", "agree")


def axes_verdict(axes: Axes) -> AxesVerdict:
    """Return the verdict on the axes as logged."""
    if axes.gyro is None and axes.accel is None and axes.attitude is None:
        return AxesVerdict("alone", "the magnetometer alone does not tell order, sense and handedness of its axes")
    if axes.gyro is not None and axes.gyro.reversed:
        text = "the gyro turns opposite to the field: --map gyro_x_rad_s=<column>,scale=-1, y and z alike, or an axis"
        return AxesVerdict("gyro_reversed", f"{text} of the gyro is mirrored")
    if not axes.speaking:
        return AxesVerdict("undetermined", "the motion does not tell the magnetometer's axes: turn about all axes")
    against = listed(list(axes.speaking))
    return _agreeing(axes, against) if axes.agree else _wrong(axes, against)


def _agreeing(axes: Axes, against: str) -> AxesVerdict:
    """Return the verdict on axes that every instrument allows as logged."""
    if axes.sign(0) < 0:
        known = "down" if axes.down else "up"
        text = f"the field is known to point {known}, and does not by the accelerometer: --axes -x,-y,-z, or where the"
        return AxesVerdict("reversed", f"{text} accelerometer has the opposite sign, --map accel_x_m_s2=...,scale=-1")
    text = f"the magnetometer's axes agree with the {against}"
    others = len(axes.turns) - 1
    if others:
        text += f", as {others} other turn{'s do' if others > 1 else ' does'} with this motion"
    elif axes.up(0) > 0 and axes.down is None:
        text += "; the field points up, as south of the magnetic equator (north of it: --axes -x,-y,-z)"
    return AxesVerdict("agree", text)


def _wrong(axes: Axes, against: str) -> AxesVerdict:
    """Return the verdict on axes that some instrument excludes as logged."""
    if not axes.turns:
        said = (f"{name}: --axes {axes.option(TURNS[one.best])}" for name, one in axes.speaking.items())
        return AxesVerdict("contradiction", f"the instruments contradict each other on the axes ({'; '.join(said)})")
    if list(axes.speaking) == ["attitude"]:
        against += " (or its quaternion is of another body frame or order)"
    if len(axes.turns) > 1:
        some = " or ".join(f"--axes {axes.option(one)}" for one in axes.maps[:MOST_LISTED])
        more = f", {len(axes.maps) - MOST_LISTED} more" if len(axes.maps) > MOST_LISTED else ""
        text = f"the magnetometer's axes are not those of the {against}, and the motion leaves several: {some}{more}"
        return AxesVerdict("turned", text)
    return _turned(axes, against)


def _turned(axes: Axes, against: str) -> AxesVerdict:
    """Return the verdict on a single turn other than the axes as logged."""
    kind: Kind = "left_handed" if axes.left_handed else "turned"
    turn = axes.turns[0]
    sign = axes.sign(turn)
    if sign == 0:
        text = f"the magnetometer's axes are not those of the {against}: --axes {axes.option(TURNS[turn])}, or if"
        return AxesVerdict("turned", f"{text} left-handed, an axis mirrored, --axes {axes.option(-TURNS[turn])}")
    right, other = sign * TURNS[turn], -sign * TURNS[turn]
    if kind == "left_handed":
        text = "the magnetometer's axes are left-handed: no turn makes it right, an axis is mirrored against the"
    else:
        text = "the magnetometer's axes are turned against the"
    text += f" {against}: --axes {axes.option(right)}"
    if axes.assumed:
        handed = "" if is_turn(other) else "left-handed, "
        text += f" (field downward; south of the magnetic equator {handed}--axes {axes.option(other)})"
    return AxesVerdict(kind, text)
