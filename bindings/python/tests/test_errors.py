"""What is wrong is named, with what was given, what is allowed, and the remedy."""

import errno
import itertools
import pickle
import subprocess
import sys

import numpy as np
import pytest

import hazcam
from hazcam import Matcher, StereoCamera, course, match, score

GREY = np.zeros((6, 9), np.uint8)
MAP = np.ones((6, 9))


def image(*shape, dtype=np.uint8):
    return np.zeros(shape, dtype)


class Masked(np.ma.MaskedArray):
    """A kind of masked arrays of somebody's own."""


def fast(left=GREY, right=GREY, box=None):
    return match(left, right, 4, preset="fast", box=box)


def for_course(Il=GREY, Ir=GREY, bbox=((0, 1), (0, 1)), maxd=4):
    return course.stereo_disparity_fast(Il, Ir, bbox, maxd)


INGREDIENTS = (
    "vertical-alignment, noise-smoothing, gradient, adaptive-p2, sub-pixel, uniqueness, "
    "left-right-check, speckle-filter, interpolation, plane-fill, learned-choice, further-choices, "
    "plane-smoothing, least-squares, median, near-detail, path-margin, descriptors, "
    "noise-check, surface-prior, last-surface-run, right-choices"
)
RANGE = "it must be from -16383 to 16383 pixels"
SEQUENCE = "a sequence of names is needed: ('median',) for one"
IMAGE = "an image is a numpy array of uint8 or uint16"
SHAPE = "an image has shape (rows, columns) for grey, or (rows, columns, 3) for red, green and blue"
BOX = (
    "four whole numbers (x0, y0, x1, y1) are needed, first column and row, last column and row, "
    "all part of the box; the course's [[x0, x1], [y0, y1]] is for hazcam.course"
)
IN_DISPARITIES = (
    "a map of disparities is a numpy array of numbers with shape (rows, columns), in pixels, NaN "
    "where there is none"
)
MASK = "a mask is a numpy array of bool with shape (rows, columns), True where to score"
COURSE_IMAGE = "a numpy array of grey values from 0 to 255 with shape (rows, columns) is needed"
COURSE_PIXELS = "a whole number of pixels from 0 to 16383 is needed"
COURSE_SIDES = (
    "in an image of 6 rows x 9 columns [[x0, x1], [y0, y1]] must have 0 <= x0 <= x1 < 9 and "
    "0 <= y0 <= y1 < 6"
)
COURSE_BOX = (
    "2 x 2 whole numbers [[x0, x1], [y0, y1]] are needed: first and last column, first and last "
    "row, all part of the box"
)

VALUES = [
    # Options.
    (lambda: Matcher("bst"), "`preset` is `bst`, but it must be one of fast, balanced, best"),
    (
        lambda: Matcher("\ud800"),
        "`preset` is '\\ud800' (str), but it must be one of fast, balanced, best",
    ),
    (lambda: Matcher("fast", 20000), f"`max_disparity` is 20000, but {RANGE}"),
    (lambda: Matcher("fast", 2**40), f"`max_disparity` is 1099511627776, but {RANGE}"),
    (lambda: Matcher("fast", 10**20), f"`max_disparity` is 1{20 * '0'} (int), but {RANGE}"),
    (
        lambda: Matcher("fast", 4, min_disparity=-20000),
        f"`min_disparity` is -20000, but {RANGE}",
    ),
    (
        lambda: Matcher("fast", 4, min_disparity=5),
        "`max_disparity` is 4, but it must not be below `min_disparity`, 5",
    ),
    (lambda: Matcher(threads=0), "`threads` is 0, but it must be from 1 to 1024"),
    (lambda: Matcher(threads=-1), "`threads` is -1, but it must be from 1 to 1024"),
    (lambda: Matcher(threads=1025), "`threads` is 1025, but it must be from 1 to 1024"),
    (
        lambda: Matcher(memory=-1),
        "`memory` is -1, but it must be a number of bytes, such as 400_000_000",
    ),
    (lambda: Matcher(holes="open"), "`holes` is `open`, but it must be 'fill' or 'keep'"),
    (
        lambda: Matcher(without=["medium"]),
        f"`without` is `medium`, but it must be one of {INGREDIENTS}",
    ),
    (
        lambda: Matcher("fast", without=["median"]),
        "`without` is `median`, but nothing can be left out of `fast`",
    ),
    # Images.
    (
        lambda: fast(left=GREY[0]),
        f"`left` is an array of uint8 with shape (9,), but {SHAPE}",
    ),
    (
        lambda: fast(right=image(6, 9, 1)),
        f"`right` is an array of uint8 with shape (6, 9, 1), but {SHAPE}: "
        "right[..., 0] is the grey "
        "image",
    ),
    (
        lambda: fast(left=image(6, 9, 2)),
        f"`left` is an array of uint8 with shape (6, 9, 2), but {SHAPE}: without its alpha it is "
        "left[..., 0]",
    ),
    (
        lambda: fast(left=image(6, 9, 4)),
        f"`left` is an array of uint8 with shape (6, 9, 4), but {SHAPE}: without its alpha it is "
        "left[..., :3]",
    ),
    (
        lambda: fast(left=image(3, 6, 9)),
        f"`left` is an array of uint8 with shape (3, 6, 9), but {SHAPE}: "
        "numpy.moveaxis(left, 0, -1) "
        "puts the colours last",
    ),
    (
        lambda: fast(left=image(1, 6, 9)),
        f"`left` is an array of uint8 with shape (1, 6, 9), but {SHAPE}: left[0] is the grey image",
    ),
    (
        lambda: fast(left=image(2, 6, 9, 3)),
        f"`left` is an array of uint8 with shape (2, 6, 9, 3), but {SHAPE}: give the images of a "
        "batch one after another",
    ),
    (
        lambda: fast(left=image(6, 9, 5)),
        f"`left` is an array of uint8 with shape (6, 9, 5), but {SHAPE}",
    ),
    (
        lambda: fast(right=GREY[1:]),
        "the left image is 9 x 6 but the right one is 9 x 5: a rectified pair "
        "has one size; rectify first, crop, or take both at one resolution",
    ),
    (
        lambda: fast(GREY[:0], GREY[:0]),
        "the images have no pixels: at least 1 x 1 is needed",
    ),
    (
        lambda: fast(right=np.broadcast_to(GREY[:1, :1], (2**20, 2**20))),
        "the images have 1048576 x 1048576 pixels, but at most 2147483647 can be matched at a "
        "time: cut them into tiles",
    ),
    (
        lambda: fast(left=np.broadcast_to(image(1, 1, 3), (2**32, 2**26, 3))),
        "the images have 67108864 x 4294967296 pixels, but at most 2147483647 can be matched at a "
        "time: cut them into tiles",
    ),
    (
        lambda: fast(right=GREY.astype(np.uint16)),
        "the left image is grey of 8 bits, but the right one is grey of 16 bits: a pair is of one "
        "kind; read both alike, or make both grey",
    ),
    (
        lambda: fast(right=image(6, 9, 3)),
        "the left image is grey of 8 bits, but the right one is colour of 8 bits: a pair is of one "
        "kind; read both alike, or make both grey",
    ),
    (
        lambda: fast(left=image(6, 9, 3)),
        "the left image is colour of 8 bits, but the right one is grey of 8 bits: a pair is of one "
        "kind; read both alike, or make both grey",
    ),
    # Boxes.
    (
        lambda: fast(box=(-1, 0, 3, 3)),
        "`box` is (-1, 0, 3, 3) (tuple), but its sides must be 0 or more: they "
        "count columns and rows "
        "from the top left",
    ),
    (
        lambda: fast(box=(0, 0, 2**70, 3)),
        f"`box` is (0, 0, {2**70}, 3) (tuple), but its sides must be columns and rows of the image",
    ),
    (
        lambda: fast(box=(3, 0, 2, 3)),
        "`box`: the box 3,0,2,3 ends before it begins: give x0,y0,x1,y1 with x0 <= x1 and y0 <= y1",
    ),
    (
        lambda: fast(box=(0, 0, 9, 5)),
        "`box`: the box 0,0,9,5 leaves the image of 9 x 6: its last column may be at "
        "most 8 and its last row "
        "at most 5 (the box is inclusive)",
    ),
    # Scores.
    (
        lambda: score(MAP, MAP[1:]),
        "the truth is 9 x 5 but the estimate is 9 x 6: both must have the size "
        "of the left image; was "
        "one of them made at another resolution?",
    ),
    (
        lambda: score(MAP, MAP * np.nan),
        "the truth has no known disparity in the whole image: nothing can be scored; check the "
        "truth's file and encoding, the box and the mask",
    ),
    (
        lambda: score(MAP[0], MAP),
        f"`disparity` is an array of float64 with shape (9,), but {IN_DISPARITIES}",
    ),
    (
        lambda: score(MAP, MAP * 1e300),
        "`truth` is 1e300 at column 0, row 0, but disparities must fit float32",
    ),
    (
        lambda: score(MAP, MAP, max_disparity=-1),
        "`max_disparity` is -1, but it must be a finite number of pixels, 0 or more",
    ),
    (
        lambda: score(MAP, MAP, mask=GREY[0] > 0),
        f"`mask` is an array of bool with shape (9,), but {MASK}",
    ),
    (
        lambda: hazcam.write_disparity("never.pfm", MAP[:0]),
        "`disparity` is a map of 0 rows x 9 columns, but at least 1 x 1 is needed",
    ),
    # Cameras.
    (
        lambda: StereoCamera(0, 1),
        "`focal_px`: the camera's focal length in pixels is 0, but it must be finite and positive",
    ),
    # The course.
    (
        lambda: for_course(Il=image(6, 9, 1)),
        f"`Il` has shape (6, 9, 1), but {COURSE_IMAGE}",
    ),
    (
        lambda: for_course(Il=np.broadcast_to(GREY[:1, :1], (2**20, 2**20))),
        "`Il` has shape (1048576, 1048576), but at most 2147483647 pixels can be matched",
    ),
    (
        lambda: for_course(Ir=GREY + 256.0),
        f"`Ir` is 256.0 at column 0, row 0, but {COURSE_IMAGE}",
    ),
    (
        lambda: for_course(Il=np.where(np.arange(9) == 4, np.nan, GREY)),
        f"`Il` is nan at column 4, row 0, but {COURSE_IMAGE}",
    ),
    (
        lambda: for_course(bbox=(0, 0, 1, 1)),
        f"`bbox` is (0, 0, 1, 1), but {COURSE_BOX}",
    ),
    (
        lambda: for_course(bbox=[[0, 1.5], [0, 1]]),
        f"`bbox` is [[0, 1.5], [0, 1]], but {COURSE_BOX}",
    ),
    (
        lambda: for_course(bbox=[[0, 1], [0]]),
        f"`bbox` is [[0, 1], [0]], but {COURSE_BOX}",
    ),
    (
        lambda: for_course(bbox=[[-1, 1], [0, 1]]),
        f"`bbox` is [[-1, 1], [0, 1]], but {COURSE_SIDES}",
    ),
    (
        lambda: for_course(bbox=[[0, 1], [2, 1]]),
        f"`bbox` is [[0, 1], [2, 1]], but {COURSE_SIDES}",
    ),
    (
        lambda: for_course(bbox=[[0, 9], [0, 1]]),
        f"`bbox` is [[0, 9], [0, 1]], but {COURSE_SIDES}",
    ),
    (
        lambda: for_course(bbox=np.array([[0, 8], [0, 6]])),
        f"`bbox` is [[0, 8], [0, 6]], but {COURSE_SIDES}",
    ),
    (lambda: for_course(maxd=-1), f"`maxd` is -1, but {COURSE_PIXELS}"),
    (lambda: for_course(maxd=16384), f"`maxd` is 16384, but {COURSE_PIXELS}"),
    (
        lambda: for_course(Ir=np.linspace(0, 1, 54).reshape(6, 9)),
        "`Ir` is from 0 to 1 everywhere, as where white is 1, but "
        f"{COURSE_IMAGE}: give 255 * Ir",
    ),
]

TYPES = [
    # Options.
    (lambda: Matcher(3), "`preset` is 3 (int), but it must be one of fast, balanced, best"),
    (
        lambda: Matcher("fast", 64.0),
        "`max_disparity` is 64.0 (float), but a whole number is needed: "
        f"{RANGE}; int(max_disparity) "
        "is one",
    ),
    (
        lambda: Matcher("fast", float("nan")),
        f"`max_disparity` is nan (float), but a whole number is needed: {RANGE}",
    ),
    (lambda: hazcam.StereoCamera(True, 0.1), "`focal_px` is True (bool), but a number is needed"),
    (
        lambda: for_course(Il=np.ma.array(np.zeros((6, 9)))),
        f"`Il` is a masked array, but {COURSE_IMAGE}: give Il.filled(0)",
    ),
    (
        lambda: Matcher("fast", "64"),
        f"`max_disparity` is '64' (str), but a whole number is needed: {RANGE}",
    ),
    (
        lambda: Matcher(memory="1GB"),
        "`memory` is '1GB' (str), but a whole number is needed: it must be a "
        "number of bytes, such as "
        "400_000_000",
    ),
    (
        lambda: Matcher(holes=None),
        "`holes` is None (NoneType), but it must be 'fill' or 'keep'",
    ),
    (lambda: Matcher(without="median"), f"`without` is 'median' (str), but {SEQUENCE}"),
    (lambda: Matcher(without=[3]), f"`without` is 3 (int), but {SEQUENCE}"),
    (lambda: Matcher(without=3), f"`without` is 3 (int), but {SEQUENCE}"),
    # Images.
    (
        lambda: fast(left=[[1, 2]]),
        f"`left` is [[1, 2]] (list), but {IMAGE}: numpy.asarray(left) may be one",
    ),
    (
        lambda: fast(left=None),
        f"`left` is None (NoneType), but {IMAGE}: cv2.imread gives None for a file that it cannot read, "
        "hazcam.read_image says why",
    ),
    (
        lambda: fast(left="left.png"),
        f"`left` is 'left.png' (str), but {IMAGE}: hazcam.read_image(left) or another reader of hazcam's gives one",
    ),
    (
        lambda: fast(right=GREY.astype(np.float32)),
        f"`right` is an array of float32 with shape (6, 9), but {IMAGE}: "
        "numpy.rint(right).astype(numpy.uint8) makes one where white is 255, "
        "numpy.rint(255 * right).astype(numpy.uint8) where white is 1",
    ),
    (
        lambda: fast(left=GREY > 0),
        f"`left` is an array of bool with shape (6, 9), but {IMAGE}: "
        "255 * left.astype(numpy.uint8) makes one where True is white",
    ),
    (
        lambda: fast(left=GREY.astype(np.int32)),
        f"`left` is an array of int32 with shape (6, 9), but {IMAGE}: "
        "left.astype(numpy.uint8) makes "
        "one where white is 255, left.astype(numpy.uint16) where white is 65535",
    ),
    (
        lambda: fast(left=GREY.astype(np.dtype(np.uint16).newbyteorder())),
        "with shape (6, 9), but an image is a numpy array of uint8 or uint16: "
        "left.astype(numpy.uint16) has the machine's own order of bytes",
    ),
    (
        lambda: fast(left=GREY.astype(complex)),
        f"`left` is an array of complex128 with shape (6, 9), but {IMAGE}",
    ),
    (
        lambda: fast(left=np.ma.masked_equal(GREY, 0)),
        f"`left` is a masked array, but {IMAGE}: left.filled(...) says what "
        "stands where it is masked",
    ),
    (
        lambda: fast(right=np.ma.masked_equal(GREY, 0).view(Masked)),
        f"`right` is a masked array, but {IMAGE}: right.filled(...) says what "
        "stands where it is masked",
    ),
    # Boxes.
    (
        lambda: fast(box=[[0, 1], [0, 1]]),
        f"`box` is [[0, 1], [0, 1]] (list), but {BOX}",
    ),
    (lambda: fast(box=(1, 2, 3)), f"`box` is (1, 2, 3) (tuple), but {BOX}"),
    (lambda: fast(box=(0, 0, 1.5, 2)), f"`box` is (0, 0, 1.5, 2) (tuple), but {BOX}"),
    (
        lambda: fast(box=(True, False, True, True)),
        f"`box` is (True, False, True, True) (tuple), but {BOX}",
    ),
    (
        lambda: fast(box=itertools.repeat(1)),
        f"`box` is repeat(1) (repeat), but {BOX}",
    ),
    (lambda: fast(box=3), f"`box` is 3 (int), but {BOX}"),
    # Scores.
    (
        lambda: score([[1.0]], MAP),
        f"`disparity` is [[1.0]] (list), but {IN_DISPARITIES}: numpy.asarray(disparity) may be one",
    ),
    (
        lambda: score(MAP, MAP > 0),
        f"`truth` is an array of bool with shape (6, 9), but {IN_DISPARITIES}",
    ),
    (
        lambda: score(np.ma.masked_equal(MAP, 0), MAP),
        f"`disparity` is a masked array, but {IN_DISPARITIES}: "
        "disparity.filled(...) says what stands "
        "where it is masked",
    ),
    (
        lambda: score(MAP, MAP, mask=GREY),
        f"`mask` is an array of uint8 with shape (6, 9), but {MASK}: mask == 255 makes one of a "
        "picture",
    ),
    (
        lambda: score(MAP, MAP, max_disparity="a"),
        "`max_disparity` is 'a' (str), but a number is needed",
    ),
    # Cameras and files.
    (lambda: StereoCamera(1, 1, cx="a"), "`cx` is 'a' (str), but a number is needed"),
    (lambda: StereoCamera("a", 1), "`focal_px` is 'a' (str), but a number is needed"),
    (
        lambda: hazcam.read_image(3),
        "`path` is 3 (int), but a path is needed: a str or a pathlib.Path",
    ),
    (
        lambda: hazcam.read_disparity("d.png", 4),
        "`encoding` is 4 (int), but give 'auto', 'png8/4', 'png16/256', 'pfm', 'npy' or 'tiff'",
    ),
    # The course.
    (lambda: for_course(Il=GREY.tolist()), f"`Il` is list, but {COURSE_IMAGE}"),
    (lambda: for_course(Ir=GREY > 0), f"`Ir` is of bool, but {COURSE_IMAGE}"),
    (
        lambda: for_course(maxd=4.0),
        f"`maxd` is 4.0, but {COURSE_PIXELS}",
    ),
    (
        lambda: for_course(maxd=True),
        f"`maxd` is True, but {COURSE_PIXELS}",
    ),
]


def test_a_range_that_lies_outside_the_images_is_refused():
    for most, least in ((90, 60), (-60, -90)):
        matcher = hazcam.Matcher("fast", most, min_disparity=least)
        words = f"disparities {least} to {most} lie outside images of 9 columns.*within -8 to 8"
        with pytest.raises(hazcam.ArgumentError, match=words):
            matcher.compute(GREY, GREY)


@pytest.mark.parametrize("call, message", VALUES, ids=[message for _, message in VALUES])
def test_wrong_values_are_named(call, message):
    with pytest.raises(hazcam.ArgumentError) as error:
        call()
    assert isinstance(error.value, ValueError) and isinstance(error.value, hazcam.HazcamError)
    assert str(error.value) == message


@pytest.mark.parametrize("call, message", TYPES, ids=[message for _, message in TYPES])
def test_wrong_types_are_named(call, message):
    with pytest.raises(hazcam.ArgumentTypeError) as error:
        call()
    assert isinstance(error.value, TypeError) and isinstance(error.value, hazcam.HazcamError)
    # The other order of bytes is called differently on each machine.
    assert str(error.value).endswith(message)


def test_what_is_shown_of_a_value_is_short():
    with pytest.raises(hazcam.ArgumentTypeError) as error:
        fast(left=np.arange(10_000).tolist())
    assert str(error.value).startswith("`left` is [0, 1, 2,") and len(str(error.value)) < 200


@pytest.mark.filterwarnings("ignore:few pixels are matched:hazcam.HazcamWarning")
def test_what_a_remedy_says_helps():
    right = np.full((6, 9), 99.6)
    assert fast(right=np.rint(right).astype(np.uint8)).values.shape == (6, 9)
    moved, without_alpha = np.moveaxis(image(3, 6, 9), 0, -1), image(6, 9, 4)[..., :3]
    assert fast(moved, without_alpha).values.shape == (6, 9)


@pytest.mark.filterwarnings("ignore:few pixels are matched:hazcam.HazcamWarning")
def test_memory_that_does_not_do_is_told():
    large = image(2000, 3000)
    matcher = Matcher("balanced", 255, memory=1_000_000)
    with pytest.raises(hazcam.FrameMemoryError) as error:
        matcher.compute(large, large)
    assert isinstance(error.value, MemoryError)
    assert str(error.value).startswith(
        "`memory` is 1 MB, but 3000 x 2000 pixels and 256 disparities need at least "
    )
    # It is fit for what does fit.
    assert Matcher("fast", 4, memory=1_000_000).compute(GREY, GREY).values.shape == (6, 9)


# Maps and images of 100 million samples, all one page, in a process that may take 300 MB more.
SCARCE = """
import mmap, resource
import numpy as np
import hazcam
samples = np.frombuffer(mmap.mmap(-1, 400_000_000), np.float32).reshape(10_000, 10_000)
with open("/proc/self/statm") as file:
    taken = int(file.read().split()[0]) * mmap.PAGESIZE
resource.setrlimit(resource.RLIMIT_AS, (taken + 300_000_000, resource.RLIM_INFINITY))
image = samples.view(np.uint8).reshape(10_000, -1)[:, :40_000]
for call in (
    lambda: hazcam.score(samples, samples),
    lambda: hazcam.match(image, image, 4),
):
    try:
        call()
    except hazcam.FrameMemoryError as error:
        print(error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the limit is Linux's")
def test_an_argument_for_which_there_is_no_memory_is_named():
    done = subprocess.run([sys.executable, "-c", SCARCE], capture_output=True, text=True)
    copies = [f"a copy of `{name}` takes 400000000 bytes" for name in ("disparity", "left")]
    expected = "".join(f"{copy}, for which there is no memory\n" for copy in copies)
    assert (done.returncode, done.stdout) == (0, expected), done.stderr


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
def test_a_map_that_cannot_be_copied_is_named(dtype):
    # One number, seen more often than there are addresses.
    endless = np.broadcast_to(np.ones((1, 1), dtype), (2**30, 2**30))
    with pytest.raises(hazcam.FrameMemoryError) as error:
        hazcam.score(MAP, endless)
    assert str(error.value) == (
        f"`truth` is an array of {np.dtype(dtype)} with shape (1073741824, 1073741824), for whose "
        "copy there is no memory"
    )


@pytest.mark.filterwarnings("ignore:few pixels are matched:hazcam.HazcamWarning")
def test_a_matcher_answers_after_an_error():
    matcher = Matcher("fast", 4)
    with pytest.raises(hazcam.ArgumentError):
        matcher.compute(GREY, GREY[1:])
    assert matcher.compute(GREY, GREY).values.shape == (6, 9)


def test_files_that_cannot_be_used_are_told(tmp_path):
    missing = tmp_path / "none.png"
    with pytest.raises(hazcam.MissingFileError) as error:
        hazcam.read_image(missing)
    assert isinstance(error.value, FileNotFoundError)
    assert isinstance(error.value, hazcam.FileAccessError)
    assert str(error.value).startswith(f"cannot read {missing}: ")
    assert (error.value.errno, error.value.filename) == (errno.ENOENT, str(missing))
    again = pickle.loads(pickle.dumps(error.value))
    assert (str(again), again.errno) == (str(error.value), errno.ENOENT)

    with pytest.raises(hazcam.MissingFileError, match="does not exist; create it first") as error:
        hazcam.write_disparity(tmp_path / "no" / "d.pfm", MAP)
    assert error.value.filename == str(tmp_path / "no" / "d.pfm")
    assert error.value.errno == errno.ENOENT
    with pytest.raises(hazcam.FileAccessError) as error:
        hazcam.read_image(tmp_path)
    assert str(error.value).startswith(f"cannot read {tmp_path}: ")
    assert error.value.filename == str(tmp_path)
    text = hazcam.FileAccessError("in words of one's own")
    assert (str(text), text.errno) == ("in words of one's own", None)

    damaged = tmp_path / "damaged.png"
    damaged.write_bytes(b"\x89PNG\r\n\x1a\n1234")
    with pytest.raises(hazcam.FileContentError, match="is damaged .*: was it copied whole"):
        hazcam.read_image(damaged)
    text = tmp_path / "calib.txt"
    text.write_text("this is no calibration")
    with pytest.raises(hazcam.FileContentError, match="is a text without a camera, but"):
        hazcam.read_calibration(text)
    hazcam.write_disparity(tmp_path / "d.npy", MAP)
    with pytest.raises(hazcam.FileContentError, match="the encoding png16/256 was asked for"):
        hazcam.read_disparity(tmp_path / "d.npy", "png16/256")

    with pytest.raises(hazcam.ArgumentError, match="`encoding`: `png9` is not an encoding of disparities"):
        hazcam.read_disparity(tmp_path / "d.npy", "png9")
    with pytest.raises(hazcam.ArgumentError, match=r"its extension `\.exr`: use one of \.pfm"):
        hazcam.write_disparity(tmp_path / "d.exr", MAP)
    with pytest.raises(hazcam.ArgumentError, match="column 0, row 0 is -1, but KITTI's 16-bit PNG"):
        hazcam.write_disparity(tmp_path / "d.png", -MAP)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["calib.txt", "d.npy", "damaged.png"]
