"""The matchers ``fast``, ``balanced`` and ``best``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from operator import index
from typing import Any, Literal, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _hazcam
from .disparity_map import DisparityMap, VerticalDisparity
from .doubts import warn

Image: TypeAlias = NDArray[np.uint8] | NDArray[np.uint16]
Preset: TypeAlias = Literal["fast", "balanced", "best"]
Holes: TypeAlias = Literal["fill", "keep"]


class Matcher:
    """Matches rectified pairs of images: built once, then fed frame after frame.

    Parameters
    ----------
    preset
        ``"fast"``: a fixed square window, sum of absolute differences (Scharstein & Szeliski 2002).
        ``"balanced"``: semi-global matching in real time (Hirschmüller 2008) with learned choices.
        ``"best"``: accuracy first, with learned descriptors. ``hazcam explain PRESET`` tells all.
    max_disparity, min_disparity
        The disparities to search, in whole pixels, both included; from -16383 to 16383. What is
        nearer than ``max_disparity`` is missed. ``min_disparity`` may be negative.
    threads
        1 to 1024; one per processor unless given. The answer does not depend on it.
    memory
        The most bytes that a frame may take. With less, ``balanced`` and ``best`` take longer; the
        answer does not depend on it.
    holes
        ``"fill"`` gives pixels without a trustworthy match a value from their surroundings,
        ``"keep"`` leaves them NaN. :class:`Reason` tells which they are in both.
    without
        Names of what the preset is to do without, such as ``("median",)``.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        For an option that is not allowed; the message says what is.

    Notes
    -----
    It keeps its memory from frame to frame. Several Python threads may share one: frames wait for
    each other, and other Python threads run while it matches. An interrupt (Ctrl-C) is heard when
    the frame is done. A process that was forked off needs one of its own. The Rust crate
    ``hazcam-matching`` does the work.

    One can be pickled and copied: what comes out is another matcher with the same options, so
    ``multiprocessing`` may be given one to send to its processes.
    """

    __slots__ = ("__weakref__", "_matcher", "_options", "_searched")

    def __init__(
        self,
        preset: Preset = "balanced",
        max_disparity: SupportsIndex = 63,
        *,
        min_disparity: SupportsIndex = 0,
        threads: SupportsIndex | None = None,
        memory: SupportsIndex | None = None,
        holes: Holes = "fill",
        without: Sequence[str] = (),
    ) -> None:
        if isinstance(without, Iterable) and not isinstance(without, str):
            without = tuple(without)  # Once: it may give its names a single time.
        self._matcher = _hazcam.Matcher(
            preset, max_disparity, min_disparity, threads, memory, holes, without
        )
        # Numbers, not what they were given as: an array may become another one.
        self._searched = (preset, index(max_disparity))
        self._options: dict[str, Any] = {
            "min_disparity": index(min_disparity),
            "threads": None if threads is None else index(threads),
            "memory": None if memory is None else index(memory),
            "holes": holes,
            "without": without,
        }

    def compute(
        self, left: NDArray[Any], right: NDArray[Any], box: ArrayLike | None = None
    ) -> DisparityMap:
        """The disparity of every pixel of the left image.

        Parameters
        ----------
        left, right
            The rectified pair: uint8 or uint16, shape (rows, columns) for grey or
            (rows, columns, 3) for red, green, blue (OpenCV reads blue first: ``left[..., ::-1]``).
            Both are of one size, depth and kind, and in any layout of memory. Samples of 12 bits in
            uint16 want ``left << np.uint16(4)``.
        box
            ``(x0, y0, x1, y1)``: the first column and row and the last column and row to answer,
            all part of the box. The whole image unless given. A box is not cut out of the answer
            to the whole image: near its edges the two differ.

        Raises
        ------
        ArgumentError, ArgumentTypeError
            For images that are no pair, for a box that leaves them, and where no disparity of the
            range has its match within them.
        FrameMemoryError
            For a frame that needs more memory than is allowed or there is.

        Warns
        -----
        HazcamWarning
            Where little matched, matches pile up at an end of the range or at disparity 0, or many
            pixels are not matched and the others do not thin out towards the largest one, or the
            images stand far off vertically; and, looked for until a frame is answered without any
            such doubt, where samples use few of 16 bits or few grey levels, both images show blocks
            of compression, or one is less sharp than the other. Python shows each once for a line
            of your program.
        """
        values, reasons, confidence, vertical, doubts = self._matcher.compute(left, right, box)
        for doubt in doubts:
            warn(doubt)
        mended = None
        if vertical is not None:
            (c0, c1, c2, c3, c4, c5), root_mean_square, largest = vertical
            mended = VerticalDisparity((c0, c1, c2, c3, c4, c5), root_mean_square, largest)
        return DisparityMap(values, reasons, confidence, mended)

    def __repr__(self) -> str:
        preset, max_disparity = self._searched
        options = ", ".join(f"{name}={value!r}" for name, value in self._options.items())
        return f"hazcam.Matcher({preset!r}, {max_disparity}, {options})"

    def __reduce__(self) -> tuple[Any, ...]:
        # What it is made of: threads and memory stay with their process. What others have added goes along.
        added = getattr(self, "__dict__", None)
        return partial(type(self), **self._options), self._searched, added or None


def match(
    left: NDArray[Any],
    right: NDArray[Any],
    max_disparity: SupportsIndex = 63,
    *,
    box: ArrayLike | None = None,
    preset: Preset = "balanced",
    min_disparity: SupportsIndex = 0,
    threads: SupportsIndex | None = None,
    memory: SupportsIndex | None = None,
    holes: Holes = "fill",
    without: Sequence[str] = (),
) -> DisparityMap:
    """The disparities of one pair, with a matcher that is made for it alone.

    ``left``, ``right`` and ``box`` are those of :meth:`Matcher.compute`, everything else is that of
    :class:`Matcher`, and so are errors and warnings. For more frames than one, make a
    :class:`Matcher`.
    """
    options: dict[str, Any] = {
        "min_disparity": min_disparity,
        "threads": threads,
        "memory": memory,
        "holes": holes,
        "without": without,
    }
    return Matcher(preset, max_disparity, **options).compute(left, right, box)
