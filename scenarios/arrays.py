"""The array type of the annotations: float64 of any shape; each docstring states the shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
