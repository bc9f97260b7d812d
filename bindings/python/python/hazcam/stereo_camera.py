"""Disparity to depth and points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from numbers import Real
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _hazcam
from .disparity_map import DisparityMap, Reason, in_pixels
from .doubts import warn
from .errors import ArgumentError, ArgumentTypeError


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

    Warns
    -----
    HazcamWarning
        Where the focal length or the baseline seems to be in another unit.
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
    size: tuple[int, int] | None = None
    """Columns and rows of the images that the camera is of: maps of another size are refused.
    ``None`` where it is not known."""

    def __post_init__(self) -> None:
        doubt = _hazcam.check_camera(self)
        if self.size is not None:
            columns, rows = self.size
            object.__setattr__(self, "size", (int(columns), int(rows)))
        if doubt is not None:
            warn(doubt)

    def scaled(self, times: float) -> StereoCamera:
        """The camera of images that are so many times as large: 0.5 where they were made half as wide.

        Without ``cx`` and ``cy`` it looks at the middle of those, too.
        """
        focal_px, baseline_m, doffs, cx, cy = _hazcam.scaled(self, times)
        size = None
        if self.size is not None:
            columns, rows = self.size
            size = max(round(columns * times), 1), max(round(rows * times), 1)
        return replace(
            self,
            focal_px=focal_px,
            doffs=doffs,
            cx=None if self.cx is None else cx,
            cy=None if self.cy is None else cy,
            size=size,
        )

    def depth(
        self,
        disparity: DisparityMap | NDArray[Any],
        *,
        min_confidence: float = 0.0,
        max_depth: float | None = None,
    ) -> NDArray[np.float32]:
        """Depth in metres of each disparity in pixels, float32 of the same shape (rows, columns).

        NaN where there is no disparity, no point in front of the cameras has it, the matcher was
        less sure of it than ``min_confidence`` (from 0 to 1; 0.5 leaves about one wrong pixel in
        seventy of ``balanced``), or it is farther away than ``max_depth`` metres.

        Raises ArgumentError, ArgumentTypeError: for a map of another size than the camera's images,
        and ``min_confidence`` without a matcher's map. Warns (HazcamWarning) of pixels that were
        filled in without a match and not left out, whose depth is a guess, and of disparities that
        are larger than any match has, or mostly of nothing in front of the cameras, or all between
        0 and 1, as in a map of confidence.
        """
        farthest = metres(max_depth)
        depth, doubts = _hazcam.depth(self, sure(disparity, min_confidence))
        for doubt in doubts:
            warn(doubt)
        depth[depth > farthest] = np.nan
        return depth

    def points(
        self,
        disparity: DisparityMap | NDArray[Any],
        *,
        min_confidence: float = 0.0,
        max_depth: float | None = None,
    ) -> NDArray[np.float32]:
        """The point X, Y, Z in metres that each pixel shows, float32 of shape (rows, columns, 3).

        NaN three times where :meth:`depth` is NaN: ``points[~np.isnan(points[..., 2])]`` are the
        others. A map of a part of the image needs ``cx`` and ``cy``: its middle is another. Errors
        and warnings are those of :meth:`depth`.
        """
        farthest = metres(max_depth)
        points, doubts = _hazcam.points(self, sure(disparity, min_confidence))
        for doubt in doubts:
            warn(doubt)
        points[points[..., 2] > farthest] = np.nan
        return points

    def depth_uncertainty(
        self, depth: NDArray[Any], disparity_error: float = 1.0
    ) -> NDArray[np.float32]:
        """By how much each depth is off in metres where its disparity is off by so many pixels.

        ``Z**2 * disparity_error / (focal_px * baseline_m)``, to first order; NaN where there is no
        depth. Of what ``balanced`` and ``best`` are sure of, from 0.5 on, 93 of 100 disparities are
        off by less than 1.
        """
        return _hazcam.depth_uncertainty(self, depth, disparity_error)


def sure(disparity: DisparityMap | NDArray[Any], min_confidence: float) -> NDArray[Any]:
    """Disparities without those that a matcher was less sure of."""
    if not 0 <= number("min_confidence", min_confidence) <= 1:
        raise ArgumentError(f"`min_confidence` is {min_confidence!r}, but it must be from 0 to 1")
    if not isinstance(disparity, DisparityMap):
        if min_confidence > 0:
            raise ArgumentError(
                f"`min_confidence` is {min_confidence!r}, but an array does not say how sure a pixel is: give "
                "the DisparityMap that a matcher answered"
            )
        return in_pixels("disparity", disparity)
    values = disparity.values
    if min_confidence > 0:
        values = np.where(disparity.confidence >= min_confidence, values, np.float32(np.nan))
    if np.any((disparity.reasons != Reason.MATCHED) & ~np.isnan(values)):
        warn(
            "some disparities were filled in without a match, so their depth is a guess: leave them out by a "
            "min_confidence above 0.05, or match with holes='keep'"
        )
    return values


def metres(max_depth: float | None) -> float:
    """How far away something may be and still have a depth."""
    if max_depth is None:
        return np.inf
    if not number("max_depth", max_depth) > 0:
        raise ArgumentError(f"`max_depth` is {max_depth!r}, but it must be positive, in metres")
    return max_depth


def number(name: str, value: float) -> float:
    """An argument that is a number; truth values are none."""
    if isinstance(value, bool) or not isinstance(value, Real):
        kind = type(value).__name__
        raise ArgumentTypeError(f"`{name}` is {value!r} ({kind}), but a number is needed")
    return value


def read_calibration(
    path: str | PathLike[str], left: str | PathLike[str] | None = None
) -> StereoCamera:
    """The cameras of a calibration file of Middlebury, ETH3D, KITTI, OpenCV or ROS (the
    right camera's).

    OpenCV's YAML does not say in which unit its baseline is: that of the squares of the board that
    was calibrated with. It is taken as metres. ROS's file of the right camera does not say where the
    left one's principal point is: it is taken to be the same (``doffs`` 0), as ROS rectifies pairs.

    KITTI's files hold a grey and a colour pair, whose baselines differ: by the folder of the
    ``left`` image (``image_2`` is colour) the right one is taken. A calibration is that of images
    of one size, which the camera has where the file says it; see :meth:`StereoCamera.scaled`.

    Raises MissingFileError, FileAccessError, FileContentError. Warns (HazcamWarning) where a number
    seems to be in another unit, and where the file lacks the pair of the ``left`` image.
    """
    numbers, size, doubt = _hazcam.read_calibration(path, left)
    if doubt is not None:
        warn(doubt)
    return StereoCamera(*numbers, size=size)
