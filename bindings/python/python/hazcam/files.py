"""Files in, files out: the formats of the stereo community, read strictly and written whole."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _hazcam
from .disparity_map import DisparityMap, in_pixels
from .doubts import warn
from .matcher import Image


def read_image(path: str | PathLike[str]) -> Image:
    """A picture as a matcher takes it: PNG, PGM/PPM, JPEG or TIFF, by content.

    uint8 or uint16 as the file has them, shape (rows, columns) for grey or (rows, columns, 3) for
    red, green, blue. Alpha is dropped. Warns (HazcamWarning) where EXIF says that the picture is to
    be turned, which is not done, and where the file holds more pictures than the first, which is read.

    Raises MissingFileError, FileAccessError, FileContentError.
    """
    image, unused = _hazcam.read_image(path)
    for what in unused:
        warn(f"{path}: {what}")
    return image


def read_disparity(path: str | PathLike[str], encoding: str = "auto") -> NDArray[np.float32]:
    """A map of disparities: float32 of shape (rows, columns), in pixels, NaN where there is none.

    ``encoding`` says how the file stands for them: ``"pfm"``, ``"npy"``, ``"tiff"``, ``"png8/K"``
    and ``"png16/K"`` (disparity = value / K, 0 is none; ``png8/4`` for Cones and Teddy,
    ``png16/256`` for KITTI). ``"auto"`` goes by content, and warns (HazcamWarning) where it had to
    assume a scale.  A KITTI PNG cannot hold a disparity of 0, which is "none" there: writers store
    1/256, which is read as that.

    Raises MissingFileError, FileAccessError, FileContentError, ArgumentError.
    """
    values, note = _hazcam.read_disparity(path, encoding)
    if note is not None:
        warn(f"{path}: {note}")
    return values


def write_disparity(path: str | PathLike[str], disparity: DisparityMap | NDArray[Any]) -> None:
    """Writes a map of disparities in pixels, whole or not at all; the format follows the extension.

    ``.pfm``, ``.npy`` and ``.tiff`` hold float32; ``.png`` is KITTI's 16 bit, from 0 to below 256
    pixels.

    Raises FileAccessError where it cannot be written, ArgumentError for what the format cannot
    hold.
    """
    _hazcam.write_disparity(path, in_pixels("disparity", disparity))
