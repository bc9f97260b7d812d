"""Disparity to depth and points."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _hazcam
from .disparity_map import DisparityMap, disparities


@dataclass(frozen=True)
class StereoCamera:
    """A rectified pair of pinhole cameras, the right one to the right of the left one.

    A point at depth ``Z`` has the disparity ``d = focal_px * baseline_m / Z - doffs`` (Scharstein
    et al., GCPR 2014). Coordinates are those of the left camera: X to the right, Y down, Z forward,
    in metres; pixel centres lie at whole numbers.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        Unless all are finite numbers, and focal length and baseline positive.
    """

    focal_px: float
    """Focal length of both cameras in pixels."""
    baseline_m: float
    """Distance between the cameras in metres."""
    doffs: float = 0.0
    """Column of the right camera's principal point less that of the left one, in pixels."""
    cx: float | None = None
    """Column of the left camera's principal point, in pixels; the middle of the map unless given,
    ``(columns - 1) / 2``. Points need it, depth does not."""
    cy: float | None = None
    """Row of both cameras' principal points, in pixels; the middle of the map unless given,
    ``(rows - 1) / 2``. Points need it, depth does not."""

    def __post_init__(self) -> None:
        _hazcam.check_camera(self)

    def depth(self, disparity: DisparityMap | NDArray[Any]) -> NDArray[np.float32]:
        """Depth in metres of each disparity in pixels, float32 of the same shape (rows, columns).

        NaN where there is no disparity, or no point in front of the cameras has it.
        """
        return _hazcam.depth(self, disparities(disparity))

    def points(self, disparity: DisparityMap | NDArray[Any]) -> NDArray[np.float32]:
        """The point X, Y, Z in metres that each pixel shows, float32 of shape (rows, columns, 3).

        NaN three times where :meth:`depth` is NaN: ``points[~np.isnan(points[..., 2])]`` are the
        others. A map of a part of the image needs ``cx`` and ``cy``: its middle is another.
        """
        return _hazcam.points(self, disparities(disparity))


def read_calibration(
    path: str | PathLike[str], left: str | PathLike[str] | None = None
) -> StereoCamera:
    """The cameras of a calibration file of Middlebury, ETH3D, KITTI, OpenCV or ROS (the
    right camera's).

    OpenCV's YAML does not say in which unit its baseline is: that of the squares of the board that
    was calibrated with. It is taken as metres.

    KITTI's files hold a grey and a colour pair, whose baselines differ: by the folder of the
    ``left`` image (``image_2`` is colour) the right one is taken. A calibration is that of images
    of one size.

    Raises MissingFileError, FileAccessError, FileContentError.
    """
    return StereoCamera(*_hazcam.read_calibration(path, left))
