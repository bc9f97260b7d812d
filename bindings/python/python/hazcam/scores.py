"""A disparity map against ground truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike, NDArray

from . import _hazcam
from .disparity_map import DisparityMap, disparities
from .doubts import warn


@dataclass(frozen=True)
class Scores:
    """Every measure of a map, over the pixels whose truth is known."""

    measures: dict[str, float | None]
    """By the names of ``hazcam score``: ``E_RMS`` and ``p_bad`` of the course; ``bad0.5`` to
    ``bad4``, ``avgerr``, ``rms``, ``A50`` to ``A99`` and ``density`` of Middlebury (Scharstein
    et al. 2014); ``D1`` of KITTI (Menze & Geiger 2015); ``EPE``, ``median``, ``bias``,
    ``subpixel-mean`` and so on. Errors are in pixels, estimate less truth; shares run from 0 to 1.
    ``None`` where there is nothing to take it from."""
    protocols: dict[str, str]
    """For each measure that has a value, in words: which pixels were counted, what a
    hole counted as."""
    pixels: int
    """How many pixels were scored."""
    holes: int
    """How many of these have no estimate."""

    @property
    def e_rms(self) -> float | None:
        """Root mean square error in pixels, a hole counted as disparity 0 (the course's)."""
        return self.measures["E_RMS"]

    @property
    def p_bad(self) -> float | None:
        """Share of pixels that are off by more than 2 pixels, holes included (the course's)."""
        return self.measures["p_bad"]


def score(
    disparity: DisparityMap | NDArray[Any],
    truth: DisparityMap | NDArray[Any],
    *,
    box: ArrayLike | None = None,
    mask: NDArray[Any] | None = None,
    max_disparity: float | None = None,
) -> Scores:
    """Scores a map of disparities against the truth.

    Parameters
    ----------
    disparity
        What a matcher answered, or an array of numbers with shape (rows, columns), in pixels. What
        is not finite is a hole: of what OpenCV's matchers answer, sixteenths of a pixel, give
        ``numpy.where(d < 16 * min_disparity, numpy.nan, d / 16)``.
    truth
        The true disparities, of the same shape. What is not finite is not known, and not scored;
        the course's two numbers leave out zeros as well.
    box
        ``(x0, y0, x1, y1)``, all part of the box: score only these pixels.
    mask
        Truth values of the same shape: score only where it is true
        (``read_image("mask0nocc.png") == 255``).
    max_disparity
        Clip estimates from 0 to this before Middlebury's measures, as its benchmark does.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        For arrays that are no maps or differ in size, and where no truth is known.
    FrameMemoryError
        For views of more numbers than there is memory for.

    Warns
    -----
    HazcamWarning
        Where one of the two seems to be a multiple of the other, or of the other sign.
    """
    rows, pixels, holes, suspected = _hazcam.score(
        disparities(disparity), disparities(truth), box, mask, max_disparity
    )
    if suspected is not None:
        if suspected < 0:
            remedy = "`disparity` had the other sign: does it count from right to left?"
        else:
            larger = "disparity" if suspected > 1 else "truth"
            divisor = max(suspected, 1 / suspected)
            remedy = f"those of `{larger}` were divided by {divisor:g}: is it in pixels?"
        text = f"most disparities are bad, but would not be if {remedy}"
        warn(text)
    measures = {name: value for name, value, _ in rows}
    protocols = {name: protocol for name, _, protocol in rows if protocol is not None}
    return Scores(measures, protocols, pixels, holes)
