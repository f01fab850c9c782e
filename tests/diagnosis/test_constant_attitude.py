"""A log at one attitude, with the strength alone: an answer, and no error of the algebra."""

from __future__ import annotations

import numpy as np

import magbench


def test_a_log_at_constant_attitude_is_answered() -> None:
    t = np.arange(1500) * 0.1
    turned = np.column_stack([np.cos(0.6 * t), np.sin(0.6 * t) * np.cos(0.2 * t), np.sin(0.6 * t) * np.sin(0.2 * t)])
    level = np.tile([1.0, 0.0, 0.0, 0.0], (1500, 1))
    log = magbench.Recording(t, 40_000 * turned + [300.0, 0.0, 0.0], att_q=level)
    found = magbench.diagnose(log, field_strength_nT=40_000)
    assert found.verdict.value in ("none", "not observable", "unknown", "generic", "class", "named")
