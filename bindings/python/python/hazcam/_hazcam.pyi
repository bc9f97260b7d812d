# The part in Rust. What is `object` here is checked there, by its name in the public functions.
from typing import final

import numpy as np
from numpy.typing import NDArray

from .matcher import Image

__all__ = [
    "FARTHEST",
    "MOST_PIXELS",
    "REASONS",
    "Matcher",
    "__version__",
    "check_camera",
    "depth",
    "depth_uncertainty",
    "points",
    "read_calibration",
    "read_disparity",
    "read_image",
    "scaled",
    "score",
    "write_disparity",
]

__version__: str
FARTHEST: int
MOST_PIXELS: int
REASONS: dict[str, int]

@final
class Matcher:
    def __new__(
        cls,
        preset: object,
        max_disparity: object,
        min_disparity: object,
        threads: object,
        memory: object,
        holes: object,
        without: object,
    ) -> Matcher: ...
    def compute(
        self, left: object, right: object, box: object
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.uint8],
        NDArray[np.float32],
        tuple[list[float], float, float] | None,
        list[str],
    ]: ...

def score(
    disparity: object, truth: object, box: object, mask: object, max_disparity: object
) -> tuple[list[tuple[str, float | None, str | None]], int, int, float | None]: ...
def check_camera(camera: object) -> str | None: ...
def scaled(camera: object, times: object) -> tuple[float, float, float, float, float]: ...
def depth(camera: object, disparity: object) -> tuple[NDArray[np.float32], list[str]]: ...
def depth_uncertainty(
    camera: object, depth: object, disparity_error: object
) -> NDArray[np.float32]: ...
def points(camera: object, disparity: object) -> tuple[NDArray[np.float32], list[str]]: ...
def read_image(path: object) -> tuple[Image, list[str]]: ...
def read_disparity(path: object, encoding: object) -> tuple[NDArray[np.float32], str | None]: ...
def write_disparity(path: object, disparity: object) -> None: ...
def read_calibration(
    path: object, left: object
) -> tuple[tuple[float, float, float, float, float], tuple[int, int] | None, str | None]: ...
