"""The functions of the robotics course's assignment, under its names and with its arguments.

They take the grey images that the course hands out, float32 from 0 to 255 with fractions (PIL's
mode ``F``), and its box, ``[[x0, x1], [y0, y1]]``. A submission needs one line for each::

    from hazcam.course import stereo_disparity_fast

They run on one thread, as the course's limit of CPU time counts those of all.
"""

from __future__ import annotations

import operator
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._hazcam import FARTHEST, MOST_PIXELS
from .errors import ArgumentError, ArgumentTypeError
from .matcher import Preset, match


def stereo_disparity_fast(
    Il: NDArray[Any], Ir: NDArray[Any], bbox: ArrayLike, maxd: SupportsIndex
) -> NDArray[np.float32]:
    """Disparities by the matcher ``fast``.

    Parameters
    ----------
    Il, Ir
        The left and the right image: grey values from 0 to 255, shape (rows, columns). They are
        rounded to whole ones.
    bbox
        2 x 2 whole numbers ``[[x0, x1], [y0, y1]]``: first and last column, first and last row to
        answer, all part of the box.
    maxd
        Disparities from 0 to this are searched, in pixels; at most 16383.

    Returns
    -------
    Id
        float32 of the shape of ``Il``: disparities in pixels, left ``(x, y)`` shows what right
        ``(x - d, y)`` shows; every pixel of the box has one, and 0 stands outside of it.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        For anything else; the message says what is needed.

    Warns
    -----
    HazcamWarning
        As :meth:`hazcam.Matcher.compute`, whose ``max_disparity`` is ``maxd``.
    """
    return _stereo_disparity("fast", Il, Ir, bbox, maxd)


def stereo_disparity_best(
    Il: NDArray[Any], Ir: NDArray[Any], bbox: ArrayLike, maxd: SupportsIndex
) -> NDArray[np.float32]:
    """Disparities by the matcher ``best``; the rest is as in :func:`stereo_disparity_fast`."""
    return _stereo_disparity("best", Il, Ir, bbox, maxd)


def _stereo_disparity(
    preset: Preset, Il: NDArray[Any], Ir: NDArray[Any], bbox: ArrayLike, maxd: SupportsIndex
) -> NDArray[np.float32]:
    left, right = _grey("Il", Il), _grey("Ir", Ir)
    box = _box(bbox, left.shape)
    found = match(left, right, _largest(maxd), box=box, preset=preset, threads=1)
    return np.nan_to_num(found.values, copy=False, nan=0.0)


def _grey(name: str, image: NDArray[Any]) -> NDArray[np.uint8]:
    """Grey values as whole ones; half goes up, as where hazcam makes grey of colours."""
    needed = "a numpy array of grey values from 0 to 255 with shape (rows, columns) is needed"
    if isinstance(image, np.ma.MaskedArray):
        raise ArgumentTypeError(f"`{name}` is a masked array, but {needed}: give {name}.filled(0)")
    if not isinstance(image, np.ndarray) or image.dtype.kind not in "fiu":
        kind = f"of {image.dtype}" if isinstance(image, np.ndarray) else type(image).__name__
        raise ArgumentTypeError(f"`{name}` is {kind}, but {needed}")
    if image.ndim != 2:
        raise ArgumentError(f"`{name}` has shape {image.shape}, but {needed}")
    if image.size > MOST_PIXELS:
        raise ArgumentError(
            f"`{name}` has shape {image.shape}, but at most {MOST_PIXELS} pixels can be matched"
        )
    if not np.all((image >= 0) & (image <= 255)):
        at = np.argwhere(~((image >= 0) & (image <= 255)))[0]
        raise ArgumentError(
            f"`{name}` is {image[tuple(at)]} at column {at[1]}, row {at[0]}, but {needed}"
        )
    if image.size > 0 and image.max() <= 1 and np.any(image % 1 != 0):
        raise ArgumentError(
            f"`{name}` is from {image.min():g} to {image.max():g} everywhere, as where white is 1, "
            f"but {needed}: give 255 * {name}"
        )
    return np.floor(image + np.float32(0.5)).clip(0, 255).astype(np.uint8)


def _box(bbox: ArrayLike, shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """The course's box as hazcam has it, for images of this shape."""
    needed = "[[x0, x1], [y0, y1]]"
    try:
        sides = np.asarray(bbox)
    except ValueError:  # Lists of several lengths.
        sides = np.empty(0)
    if sides.shape != (2, 2) or sides.dtype.kind not in "iu":
        raise ArgumentError(
            f"`bbox` is {bbox!r}, but 2 x 2 whole numbers {needed} are needed: first and last "
            "column, first and last row, all part of the box"
        )
    (x0, x1), (y0, y1) = sides.tolist()
    rows, columns = shape
    if not (0 <= x0 <= x1 < columns and 0 <= y0 <= y1 < rows):
        raise ArgumentError(
            f"`bbox` is {[[x0, x1], [y0, y1]]}, but in an image of {rows} rows x {columns} columns "
            f"{needed} must have 0 <= x0 <= x1 < {columns} and 0 <= y0 <= y1 < {rows}"
        )
    return x0, y0, x1, y1


def _largest(maxd: SupportsIndex) -> int:
    """The largest disparity, where it is one."""
    needed = f"a whole number of pixels from 0 to {FARTHEST} is needed"
    try:
        # A truth value is a number to Python, and a mistake here.
        if isinstance(maxd, (bool, np.bool_)):
            raise TypeError
        largest = operator.index(maxd)
    except TypeError:
        raise ArgumentTypeError(f"`maxd` is {maxd!r}, but {needed}") from None
    if not 0 <= largest <= FARTHEST:
        raise ArgumentError(f"`maxd` is {maxd!r}, but {needed}")
    return largest
