"""Calibrators: one file each, a base class and the result type."""

from __future__ import annotations

from calib.base import Calibrator
from calib.de_gradiometer import DeGradiometer
from calib.de_turntable import DeTurntable
from calib.ellipsoid import EllipsoidCalibrator
from calib.ellipsoid_segmented import EllipsoidSegmented
from calib.ga import Ga
from calib.ga_gradiometer import GaGradiometer
from calib.ide_gradiometer import IdeGradiometer
from calib.kalman import KalmanCalibrator
from calib.kalman_fuzzy import KalmanFuzzyCalibrator
from calib.kalman_rescaled import KalmanRescaledCalibrator
from calib.least_squares_gradiometer import LeastSquaresGradiometer
from calib.ml_newton import MaximumLikelihoodNewton
from calib.pso import Pso
from calib.psoga import PsoGa
from calib.reference import Reference
from calib.result import Calibration, Status
from calib.serial import from_json, to_dict, to_json
from calib.sphere import SphereCalibrator
from calib.tolles_lawson import TollesLawsonCalibrator
from calib.two_step_gradiometer import TwoStepGradiometer
from calib.twostep import TwoStep
from calib.ukf import UkfCalibrator
from calib.vector_least_squares import VectorLeastSquares
from calib.vector_lm import VectorLmCalibrator
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
        Pso,
        Ga,
        PsoGa,
        DeTurntable,
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
    )
}
"""Every calibrator by name, in the order that tables show them."""


def get(name: str) -> Calibrator:
    """The calibrator of that name with its default settings; raises InputError listing the names there are."""
    if name not in CALIBRATORS:
        raise InputError(f"no calibrator is called {name!r}", do=f"choose among {', '.join(CALIBRATORS)}")
    return CALIBRATORS[name]()


__all__ = ["CALIBRATORS", "Calibration", "Calibrator", "Reference", "Status", "from_json", "get", "to_dict", "to_json"]
