"""OpenCV's stereo matchers as an engine (the engine protocol, version 1; see PROTOCOL.md).

OpenCV answers nothing in the left `numDisparities` columns and leaves holes elsewhere, so what is
compared is OpenCV with the usual finishing, the same for every configuration:

* both images get a border of replicated columns (`numDisparities` on the left; on the right as
  many as negative disparities need), so that the left strip is answered too;
* holes take the smaller of the two nearest values in their row (the background's), 0 where a row
  has none;
* a 5 x 5 median.

16-bit images are reduced to 8 bit, the only depth that these matchers take. Grey is ITU-R BT.601
luma, rounded. The penalties are OpenCV's own recommendation, P1 = 8 c b^2 and P2 = 32 c b^2 for
c channels and blocks of b x b.

The seconds stated are those of OpenCV's own `compute` (and WLS filter), on the images with their
border: neither the border nor the finishing above is in them. A matcher is kept for as long as jobs
ask for the same range, so that it can reuse its memory.
"""

import argparse
import json
import sys
import time

# Messages go to the real standard output; whatever a library prints goes to standard error.
CHANNEL, sys.stdout = sys.stdout, sys.stderr


def say(**message):
    CHANNEL.write(json.dumps(message) + "\n")
    CHANNEL.flush()


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--mode", choices=["bm", "sgbm", "3way", "hh"], required=True)
    parser.add_argument("--block", type=int, required=True, help="side of the block, odd")
    parser.add_argument("--colour", action="store_true", help="match colour images in colour")
    parser.add_argument("--cap", type=int, default=0, help="preFilterCap (0: OpenCV's default)")
    parser.add_argument("--uniqueness", type=int, default=0, help="uniquenessRatio, percent")
    parser.add_argument("--speckle-window", type=int, default=0)
    parser.add_argument("--speckle-range", type=int, default=0)
    parser.add_argument("--wls-lambda", type=float, help="finish with the WLS filter")
    parser.add_argument("--wls-sigma", type=float, default=0.8)
    return parser.parse_args()


def to_8_bit(image):
    if image.dtype == np.uint8:
        return image
    return ((image.astype(np.uint32) + 128) // 257).astype(np.uint8)


def to_grey(image):
    if image.ndim == 2:
        return image
    red, green, blue = (image[..., c].astype(np.uint32) for c in range(3))
    return ((299 * red + 587 * green + 114 * blue + 500) // 1000).astype(np.uint8)


def fill_from_background(values):
    """Holes (NaN) take the smaller of the nearest values to their left and right."""
    columns = values.shape[1]
    at = np.broadcast_to(np.arange(columns), values.shape)
    hole = np.isnan(values)
    left = np.maximum.accumulate(np.where(hole, -1, at), axis=1)
    right = np.minimum.accumulate(np.where(hole, columns, at)[:, ::-1], axis=1)[:, ::-1]
    take = lambda where: np.take_along_axis(values, np.clip(where, 0, columns - 1), axis=1)
    nearest_left = np.where(left >= 0, take(left), np.inf)
    nearest_right = np.where(right < columns, take(right), np.inf)
    filled = np.where(hole, np.minimum(nearest_left, nearest_right), values)
    return np.where(np.isfinite(filled), filled, 0).astype(np.float32)


class Matcher:
    def __init__(self, options, lowest, count, channels):
        block = options.block
        if options.mode == "bm":
            self.left = cv2.StereoBM_create(count, block)
            self.left.setMinDisparity(lowest)
        else:
            mode = {
                "sgbm": cv2.STEREO_SGBM_MODE_SGBM,
                "3way": cv2.STEREO_SGBM_MODE_SGBM_3WAY,
                "hh": cv2.STEREO_SGBM_MODE_HH,
            }[options.mode]
            self.left = cv2.StereoSGBM_create(
                lowest,
                count,
                block,
                P1=8 * channels * block * block,
                P2=32 * channels * block * block,
                disp12MaxDiff=1,
                preFilterCap=options.cap,
                uniquenessRatio=options.uniqueness,
                speckleWindowSize=options.speckle_window,
                speckleRange=options.speckle_range,
                mode=mode,
            )
        self.wls = None
        if options.wls_lambda is not None:
            self.wls = cv2.ximgproc.createDisparityWLSFilter(self.left)
            self.wls.setLambda(options.wls_lambda)
            self.wls.setSigmaColor(options.wls_sigma)
            self.right = cv2.ximgproc.createRightMatcher(self.left)

    def compute(self, left, right):
        """Disparities in sixteenths of a pixel, and a confidence from 0 to 255 or None."""
        found = self.left.compute(left, right)
        if self.wls is None:
            return found, None
        found = self.wls.filter(found, left, None, self.right.compute(right, left))
        return found, self.wls.getConfidenceMap()


def answer(job, options, kept):
    """Writes the answer; how long the matching alone took, in seconds."""
    left, right = (to_8_bit(np.load(job[side])) for side in ("left", "right"))
    if not options.colour:
        left, right = to_grey(left), to_grey(right)
    lowest, highest = job["min_disparity"], job["max_disparity"]
    count = (highest - lowest + 1 + 15) // 16 * 16
    before, after = max(0, lowest + count), max(0, -lowest)
    left, right = (
        cv2.copyMakeBorder(np.ascontiguousarray(i), 0, 0, before, after, cv2.BORDER_REPLICATE)
        for i in (left, right)
    )
    cv2.setNumThreads(job["threads"])
    channels = 1 if left.ndim == 2 else 3
    asked = (lowest, count, channels)
    if asked not in kept:
        kept.clear()
        kept[asked] = Matcher(options, *asked)
    started = time.perf_counter()
    found, confidence = kept[asked].compute(left, right)
    seconds = time.perf_counter() - started
    inside = slice(before, before + job["columns"])
    values = found[:, inside].astype(np.float32) / 16
    hole = values < lowest
    if options.wls_lambda is not None:
        # The filter extrapolates past the range that was searched.
        values = np.minimum(values, highest)
    values[hole] = np.nan
    values = cv2.medianBlur(fill_from_background(values), 5)
    np.save(job["disparity"], values)
    np.save(job["reasons"], np.where(hole, 3, 1).astype(np.uint8))
    if confidence is not None:
        confidence = np.clip(np.asarray(confidence)[:, inside] / 255, 0, 1)  # 255.03 does occur
        np.save(job["confidence"], np.where(hole, 0, confidence).astype(np.float32))
    return seconds


def serve(options):
    say(hazcam="ready", protocol=1, name="OpenCV", version=cv2.__version__)
    kept = {}
    for line in sys.stdin:
        job = json.loads(line)
        try:
            seconds = answer(job, options, kept)
        except (cv2.error, MemoryError, ValueError) as error:
            text = " ".join(str(error).split()) or type(error).__name__
            say(hazcam="failed", job=job["job"], message=text)
        else:
            say(hazcam="done", job=job["job"], seconds=seconds)


if __name__ == "__main__":
    parsed = arguments()
    try:
        import cv2
        import numpy as np

        if parsed.wls_lambda is not None:
            cv2.ximgproc.createDisparityWLSFilter
    except (ImportError, AttributeError) as missing:
        say(
            hazcam="absent",
            message=f"Python at {sys.executable} lacks what this engine needs ({missing}): "
            "pip install numpy opencv-contrib-python-headless",
        )
        sys.exit(0)
    serve(parsed)
