"""Physics: geomagnetic field, vehicles in MuJoCo, the magnetometer chain with its effects, the dataset."""

from sim.compiled import keep_somewhere

keep_somewhere()
