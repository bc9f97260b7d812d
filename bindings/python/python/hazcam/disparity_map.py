"""What a matcher answers: per pixel a disparity, the reason for it, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from .doubts import warn


class Reason(IntEnum):
    """Why a pixel has its value, or none: what the bytes of :attr:`DisparityMap.reasons` mean."""

    OUTSIDE_BOX = 0
    """Outside the box that was asked for: no value."""
    MATCHED = 1
    """Found in the right image and confirmed by every check that the matcher makes."""
    OCCLUDED_FILLED = 2
    """Seen by the left camera only; filled from the background."""
    MISMATCHED_FILLED = 3
    """The match was wrong or ambiguous; filled from its surroundings."""
    OUTSIDE_RIGHT_FILLED = 4
    """The match lies outside the right image; extrapolated from where both cameras see."""
    OCCLUDED_HOLE = 5
    """As ``OCCLUDED_FILLED``, but left without a value (``holes="keep"``)."""
    MISMATCHED_HOLE = 6
    """As ``MISMATCHED_FILLED``, but left without a value (``holes="keep"``)."""
    OUTSIDE_RIGHT_HOLE = 7
    """As ``OUTSIDE_RIGHT_FILLED``, but left without a value (``holes="keep"``)."""


@dataclass(frozen=True)
class VerticalDisparity:
    """How far things stood lower in the right image than in the left one, in pixels.

    Rectification leaves such a rest; ``balanced`` and ``best`` take it out of the right image
    before they match. It depends on the place: with ``X = column / columns - 0.5`` (of the right
    image) and ``Y = row / rows - 0.5`` it is ``c[0] + c[1] X + c[2] Y + c[3] X Y + c[4] Y**2 + c[5] X**2``,
    the shapes that a camera makes that is turned a little (Longuet-Higgins & Prazdny 1980), and a lens
    whose elements are not in one line (Brown 1966).
    """

    coefficients: tuple[float, float, float, float, float, float]
    """The factors ``c`` of 1, X, Y, X Y, Y**2 and X**2, in pixels."""
    root_mean_square: float
    """The root of its mean square over the image, in pixels."""
    largest: float
    """The largest one in the image, up or down, in pixels; above 1.5 rectify the cameras anew."""


@dataclass(frozen=True, eq=False)
class DisparityMap:
    """A disparity for each pixel of the left image, with its reason and how sure it is.

    All arrays have the shape (rows, columns) of the left image, and are yours: later frames leave
    them as they are. As an array, as in ``numpy.save("d.npy", found)``, it is its values.
    """

    values: NDArray[np.float32]
    """Disparities in pixels: left ``(x, y)`` shows what right ``(x - d, y)`` shows, so what is
    nearer has a larger one. NaN exactly where the reason has no value."""
    reasons: NDArray[np.uint8]
    """Why the pixel has this value or none: the byte of a :class:`Reason`."""
    confidence: NDArray[np.float32]
    """How sure the value is, from 0 (a guess) to 1; 0 where there is no value. It ranks pixels
    and is no probability. What was filled in without a match has 0.05 at the most."""
    vertical_disparity: VerticalDisparity | None
    """What was mended of the rows, or ``None`` where nothing was worth it. ``fast`` never looks."""

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        if copy:
            return np.array(self.values, dtype)
        values = np.asarray(self.values, dtype)
        if copy is False and values is not self.values:
            raise ValueError("values are float32: they cannot be of another type without a copy")
        return values

    def __repr__(self) -> str:
        rows, columns = self.values.shape
        answered = self.reasons != Reason.OUTSIDE_BOX
        matched = np.sum(self.reasons == Reason.MATCHED) / max(np.sum(answered), 1)
        return f"<hazcam.DisparityMap of {rows} rows x {columns} columns, {matched:.1%} matched>"


def disparities(disparity: DisparityMap | NDArray[np.generic]) -> NDArray[np.generic]:
    """The values of a map, which may be given as it came from a matcher or as an array."""
    return disparity.values if isinstance(disparity, DisparityMap) else disparity


def in_pixels(name: str, disparity: DisparityMap | NDArray[Any]) -> NDArray[Any]:
    """The same, with a warning where an array seems to be in sixteenths of a pixel."""
    values = disparities(disparity)
    if getattr(values, "dtype", None) == np.int16:
        warn(
            f"`{name}` is an array of int16, which is taken as whole pixels: OpenCV's matchers answer "
            "sixteenths, and less than the least disparity where there is none; of these give "
            f"numpy.where({name} < 16 * min_disparity, numpy.nan, {name} / 16)"
        )
    return values
