"""Physics: geomagnetic field, vehicles in MuJoCo, the magnetometer chain with its effects, the dataset."""
