"""AUV: what the step of its integration costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.paths import Start
from sim.engine import ReferenceTrack, advance, log_of
from sim.plant import plant_of
from sim.vehicles.base import STEP_S
from sim.vehicles.free_body_control import follow
from tests.sim.test_auv import COMB, SPIRAL, TILT, auv, phase
from tests.sim.test_engine import hold


class TestIntegration:
    """The step of 20 ms against a hundredth of it, the control held for 20 ms in both."""

    @staticmethod
    def apart(table: dict[str, Any], seconds: float) -> tuple[float, float]:
        """Largest distance, m, and largest angle, degrees, between the two runs."""
        n, ways = round(seconds / STEP_S), []
        reference = phase(table).reference(Start((0.0, 0.0, 0.0), 0.3), STEP_S * np.arange(n))
        for parts in (1, 100):
            vehicle, model, data = auv(heading_deg=np.degrees(0.3))
            gains, memory, added = vehicle.gains(model, phase(table)), np.zeros(43), vehicle.added_mass(model)
            model.opt.timestep = STEP_S / parts
            plant = plant_of(model, data, vehicle.body, added)
            held = ReferenceTrack(np.zeros((parts, 18)), np.zeros((parts, 3)), gains, memory, parts)
            way, log = np.empty((n, 7)), log_of(model, 1)
            for i in range(n):
                follow(data.qpos, data.qvel, reference[i], gains, memory, data.ctrl)
                advance(hold, plant, held, log)
                way[i] = data.qpos
            ways.append(way)
        turns = [Rotation.from_quat(w[:, 3:], scalar_first=True) for w in ways]
        angle = np.degrees((turns[0].inv() * turns[1]).magnitude().max())
        return float(np.linalg.norm(ways[0][:, :3] - ways[1][:, :3], axis=1).max()), float(angle)

    def test_fifteen_seconds_of_tilting_spiral(self) -> None:
        metres, degrees = self.apart(SPIRAL | TILT, 15.0)
        assert metres < 1e-6
        assert degrees < 1e-5

    @pytest.mark.slow
    @pytest.mark.parametrize("table", [SPIRAL, SPIRAL | TILT, COMB], ids=["spiral", "tilting spiral", "comb"])
    def test_whole_path(self, table: dict[str, Any]) -> None:
        metres, degrees = self.apart(table, phase(table).duration_s)
        assert metres < 1e-4
        assert degrees < 1e-3
