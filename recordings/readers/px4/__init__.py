"""PX4's logs, ULog (.ulg): the container, the calibration that PX4 applied, and what else the vehicle logged."""

from recordings.readers.px4.reading import PX4

__all__ = ["PX4"]
