"""Calibrators: one file each, a base class and the result type."""

from __future__ import annotations

from calib.base import Calibrator
from calib.methods.de_gradiometer import DeGradiometer
from calib.methods.de_turntable import DeTurntable
from calib.methods.ellipsoid import EllipsoidCalibrator
from calib.methods.ellipsoid_segmented import EllipsoidSegmented
from calib.methods.fixed_attitude import FixedAttitude
from calib.methods.ga import Ga
from calib.methods.ga_gradiometer import GaGradiometer
from calib.methods.gyro_accel_ml import GyroAccelMl
from calib.methods.gyro_ml import GyroMl
from calib.methods.ide_gradiometer import IdeGradiometer
from calib.methods.kalman import KalmanCalibrator
from calib.methods.kalman_fuzzy import KalmanFuzzyCalibrator
from calib.methods.kalman_rescaled import KalmanRescaledCalibrator
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.methods.ml_geometric import MaximumLikelihoodGeometric
from calib.methods.ml_newton import MaximumLikelihoodNewton
from calib.methods.motor_ellipsoid import MotorEllipsoid
from calib.methods.motor_vector import MotorVector
from calib.methods.planar import Planar
from calib.methods.pso import Pso
from calib.methods.psoga import PsoGa
from calib.methods.sphere import SphereCalibrator
from calib.methods.strength_dip import StrengthDip
from calib.methods.tolles_lawson import TollesLawsonCalibrator
from calib.methods.two_step_gradiometer import TwoStepGradiometer
from calib.methods.twostep import TwoStep
from calib.methods.ukf import UkfCalibrator
from calib.methods.vector_least_squares import VectorLeastSquares
from calib.methods.vector_lm import VectorLmCalibrator
from calib.options import SEPARATOR, configured
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.serial import from_json, to_dict, to_json
from scenarios.errors import InputError

CALIBRATORS: dict[str, type[Calibrator]] = {
    method.name: method
    for method in (
        SphereCalibrator,
        EllipsoidCalibrator,
        VectorLeastSquares,
        EllipsoidSegmented,
        TwoStep,
        MaximumLikelihoodNewton,
        MaximumLikelihoodGeometric,
        GyroMl,
        GyroAccelMl,
        StrengthDip,
        Pso,
        Ga,
        PsoGa,
        DeTurntable,
        Planar,
        FixedAttitude,
        KalmanCalibrator,
        KalmanRescaledCalibrator,
        KalmanFuzzyCalibrator,
        IdeGradiometer,
        DeGradiometer,
        GaGradiometer,
        LeastSquaresGradiometer,
        TwoStepGradiometer,
        UkfCalibrator,
        VectorLmCalibrator,
        TollesLawsonCalibrator,
        MotorEllipsoid,
        MotorVector,
    )
}
"""Every calibrator by name, in the order that tables show them."""


def get(text: str) -> Calibrator:
    """The calibrator `NAME`, with options `NAME:OPTION=VALUE:...`; raises InputError listing the names there are."""
    name, *options = text.split(SEPARATOR)
    if name not in CALIBRATORS:
        raise InputError(f"no calibrator is called {name!r}", do=f"choose among {', '.join(CALIBRATORS)}")
    return configured(CALIBRATORS[name], options)


__all__ = ["CALIBRATORS", "Calibration", "Calibrator", "Reference", "Status", "from_json", "get", "to_dict", "to_json"]
