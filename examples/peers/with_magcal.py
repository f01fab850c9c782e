"""magcal 1.0 (MIT) as a calibrator: its ellipsoid is centred on the mean of the samples.

python -m venv peers && peers/bin/pip install magcal
magbench compare quad-calibration --exec 'magcal=peers/bin/python examples/peers/with_magcal.py \
    ellipsoid {recording.csv} {result}'

Units: microtesla, which its reports are in. Frame: the sensor's, which it leaves as it is.
Form: transform (m - centre) is of length one (apply_calibration), so the matrix is the field strength times transform;
its sphere leaves the field in microtesla.
"""

import numpy as np
from columns import STRENGTH_NT, main
from magcal import MagnetometerCalibrator

NT_PER_UT = 1000.0
"""Microtesla to nT."""


def ellipsoid(mag_nT, rate_rad_s, time_s):
    """Offset, nT, and matrix of its `ellipsoid_fit`."""
    found = MagnetometerCalibrator().ellipsoid_fit(mag_nT / NT_PER_UT)
    return NT_PER_UT * found["center"], STRENGTH_NT / NT_PER_UT * found["transform_matrix"]


def sphere(mag_nT, rate_rad_s, time_s):
    """Offset, nT, and the unit matrix of its `sphere_fit`."""
    found = MagnetometerCalibrator().sphere_fit(mag_nT / NT_PER_UT)
    return NT_PER_UT * found["center"], np.eye(3)


if __name__ == "__main__":
    main({"ellipsoid": ellipsoid, "sphere": sphere})
