"""Dense stereo matching on a CPU: two rectified images in, a disparity map out.

>>> import hazcam
>>> matcher = hazcam.Matcher("balanced", max_disparity=63)
>>> found = matcher.compute(left, right)     # numpy arrays, uint8 or uint16
>>> found.values                             # float32, in pixels, NaN where there is none

A disparity ``d`` says that left ``(x, y)`` shows what right ``(x - d, y)`` shows.
"""

from . import course
from ._hazcam import __version__
from .disparity_map import DisparityMap, Reason, VerticalDisparity
from .errors import (
    ArgumentError,
    ArgumentTypeError,
    FileAccessError,
    FileContentError,
    FrameMemoryError,
    HazcamError,
    HazcamWarning,
    MissingFileError,
)
from .files import read_disparity, read_image, write_disparity
from .matcher import Holes, Image, Matcher, Preset, match
from .scores import Scores, score
from .stereo_camera import StereoCamera, read_calibration

__all__ = [
    "ArgumentError",
    "ArgumentTypeError",
    "DisparityMap",
    "FileAccessError",
    "FileContentError",
    "FrameMemoryError",
    "HazcamError",
    "HazcamWarning",
    "Holes",
    "Image",
    "Matcher",
    "MissingFileError",
    "Preset",
    "Reason",
    "Scores",
    "StereoCamera",
    "VerticalDisparity",
    "__version__",
    "course",
    "match",
    "read_calibration",
    "read_disparity",
    "read_image",
    "score",
    "write_disparity",
]
