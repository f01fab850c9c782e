"""Terms of inputs of an old calibration that a new log can check: motor currents, throttle, temperature."""

from __future__ import annotations

from dataclasses import replace

from calib import Calibration
from calib.input_terms import CURRENT_SUM, input_signal
from recordings import Recording
from recordings.channels import current_name
from validation.text import listed


def with_logged_inputs(old: Calibration, recording: Recording) -> tuple[Calibration, tuple[str, ...]]:
    """Return the calibration with the terms whose inputs the log has, and notes on each term.

    A change of a motor current's term is told as one of the motor currents; other terms are taken off alone.
    """
    logged = tuple(term for term in old.inputs if input_signal(recording, term.channel) is not None)
    gone = [f"{term.channel} (holds at {term.reference:g})" for term in old.inputs if term not in logged]
    currents = {CURRENT_SUM, *(current_name(motor) for motor in recording.motors)}
    blind = [term.channel for term in logged if term.channel not in currents]
    notes = []
    if gone:
        notes.append(f"the log has no {listed(gone)}: these terms of the old calibration could not be checked")
    if blind:
        notes.append(f"the field of {listed(blind)} is taken off as the old calibration states, and not fitted anew")
    return replace(old, inputs=logged), tuple(notes)
