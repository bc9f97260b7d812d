"""What the course's functions are given, and what they must return.

Given: `Il` and `Ir`, float32 with fractions (PIL's mode 'F': grey as it is, colour by
(299 R + 587 G + 114 B) / 1000; 16-bit samples are brought to 0..255 by dividing by 257); `bbox`, a
2 x 2 integer array [[x0, x1], [y0, y1]], inclusive; `maxd`, an int. Each call gets its own arrays.
"""

import numpy as np


class BadAnswer(Exception):
    """What was returned is no disparity map; the text says why."""


def arguments(job):
    """The four arguments of a course function."""
    left, right = (_grey(np.load(job[side], allow_pickle=False)) for side in ("left", "right"))
    x0, y0, x1, y1 = job["box"]
    return left, right, np.array([[x0, x1], [y0, y1]], dtype=np.int64), int(job["max_disparity"])


def _grey(samples):
    scale = 257 if samples.dtype == np.uint16 else 1
    if samples.ndim == 2:
        return (samples.astype(np.float32) / np.float32(scale)).astype(np.float32)
    luma = samples.astype(np.int64) @ np.array([299, 587, 114])
    return (luma / (1000.0 * scale)).astype(np.float32)


def kind(value):
    """The type of a value with its article."""
    name = type(value).__name__
    return ("an " if name[0].lower() in "aeiou" else "a ") + name


def disparity(answer, shape):
    """The answer as a float32 array of this shape; raises BadAnswer when it is none."""
    if answer is None:
        raise BadAnswer(
            "the function returned nothing (None): end it with `return Id`, the disparity image"
        )
    if not isinstance(answer, np.ndarray):
        raise BadAnswer(
            "the function returned {}, but a numpy array with the shape of Il is needed".format(
                kind(answer)
            )
        )
    if answer.dtype.kind not in "iuf":
        raise BadAnswer(
            "the function returned an array of {}, but an array of real numbers is needed".format(
                answer.dtype
            )
        )
    if answer.shape != shape:
        raise BadAnswer(
            "the function returned an array of shape {}, but it must have the shape of Il, "
            "{} (rows, columns), whatever the box".format(answer.shape, shape)
        )
    # What is masked is no disparity, whatever stands there.
    masked = np.ma.getmaskarray(answer)
    answer = np.ma.getdata(answer)
    with np.errstate(all="ignore"):
        values = np.array(answer, dtype="<f4", order="C")
        # Too large for 32 bits is out of the range, whose nearer end it will be brought to.
        beyond = np.isinf(values) & np.isfinite(np.asarray(answer))
        values[beyond] = np.copysign(np.finfo(np.float32).max, values[beyond])
    # Outside of the box anything goes, and inside of it neither is a disparity; the protocol knows
    # NaN only.
    values[np.isinf(values) | masked] = np.nan
    return values
