"""magyc 1.0 (github.com/CoMPASLab-MBARI, MIT) as a calibrator, in an environment of its own: it wants numpy before 2.

python -m venv peers && peers/bin/pip install magyc
magbench compare quad-calibration --exec 'magyc-ellipsoid=peers/bin/python examples/peers/with_magyc.py \
    ellipsoid_fit {recording.csv} {result}'

Units: magyc's own data and default gains are in milligauss (sim_data/generate_data.py), so it gets milligauss.
Frame: none of its methods uses an attitude; field and rate are in one frame, which is all they ask.
Form: it returns a hard iron b and a soft iron W with h = W^-1 (m - b) (hsi_calibration_validation.py), and the
determinant of W is one, or for ellipsoid_fit_fang free: the scale is taken from the field strength.
"""

import magyc
import numpy as np
from columns import main, scaled

NT_PER_MG = 100.0
"""Milligauss to nT."""


def hard(method):
    """A method of magyc that finds the offset alone."""

    def fit(mag_nT, rate_rad_s, time_s):
        offset_mG = method(mag_nT / NT_PER_MG, rate_rad_s, time_s)[0]
        return NT_PER_MG * np.ravel(offset_mG), np.eye(3)

    return fit


def hard_and_soft(method):
    """A method of magyc that finds offset and soft iron."""

    def fit(mag_nT, rate_rad_s, time_s):
        offset_mG, soft = method(mag_nT / NT_PER_MG, rate_rad_s, time_s)[:2]
        offset_nT = NT_PER_MG * np.ravel(offset_mG)
        return offset_nT, scaled(offset_nT, np.linalg.inv(soft), mag_nT)

    return fit


METHODS = {
    "sphere_fit": hard(lambda m, w, t: magyc.sphere_fit(m)),
    "ellipsoid_fit": hard_and_soft(lambda m, w, t: magyc.ellipsoid_fit(m)),
    "ellipsoid_fit_fang": hard_and_soft(lambda m, w, t: magyc.ellipsoid_fit_fang(m)),
    "sar_ls": hard(magyc.sar_ls),
    "sar_kf": hard(magyc.sar_kf),
    "sar_aid": hard(magyc.sar_aid),
    "magyc_ls": hard_and_soft(magyc.magyc_ls),
    "magyc_nls": hard_and_soft(magyc.magyc_nls),
    "magyc_bfg": hard_and_soft(magyc.magyc_bfg),
    "magyc_ifg": hard_and_soft(magyc.magyc_ifg),
}

if __name__ == "__main__":
    main(METHODS)
