"""The one array type of the annotations: float64 of any shape, which each docstring states."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
