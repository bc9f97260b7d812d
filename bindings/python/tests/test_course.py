"""The course's functions, called as the course calls them."""

import numpy as np
import pytest
from pairs import dots

import hazcam
from hazcam.course import stereo_disparity_best, stereo_disparity_fast

BBOX = np.array([[30, 90], [10, 40]])


@pytest.mark.parametrize(
    "function, preset", [(stereo_disparity_fast, "fast"), (stereo_disparity_best, "best")]
)
def test_the_box_is_answered_and_nothing_else(function, preset):
    left, right = dots()
    found = function(left.astype(np.float32), right.astype(np.float32), BBOX, 32)
    assert (found.shape, found.dtype) == (left.shape, np.float32)
    expected = hazcam.match(left, right, 32, box=(30, 10, 90, 40), preset=preset)
    inside = np.isfinite(expected.values)
    assert inside.sum() == 61 * 31
    assert np.array_equal(found[inside], expected.values[inside])
    assert np.all(found[~inside] == 0)
    assert np.median(found[inside]) == pytest.approx(7, abs=0.25)


def test_fractions_are_rounded_as_where_grey_is_made_of_colours():
    rng = np.random.default_rng(6)
    colour = rng.integers(0, 256, (40, 100, 3), np.uint8)
    # Luma with its fractions, some of them exactly a half.
    colour[:, ::7] = [[0, 0, 250]]
    luma = (colour @ np.array([299, 587, 114])) / 1000
    assert np.any(luma % 1 == 0.5)
    grey = luma.astype(np.float32)
    left, right = (np.ascontiguousarray(image) for image in (grey[:, :90], grey[:, 5:95]))
    found = stereo_disparity_fast(left, right, [[0, 89], [0, 39]], 16)
    expected = hazcam.match(colour[:, :90], colour[:, 5:95], 16, preset="fast")
    assert np.array_equal(found, expected.values)


@pytest.mark.filterwarnings("ignore:few pixels are matched:hazcam.HazcamWarning")
def test_black_and_white_of_0_and_1_are_grey_values():
    # Nothing says that white is 1 here: they are nearly black.
    Il = np.zeros((6, 9), np.float32)
    Il[::2] = 1
    with pytest.warns(hazcam.HazcamWarning, match="a small part of what they hold"):
        assert stereo_disparity_fast(Il, Il, [[0, 8], [0, 5]], 16383).shape == (6, 9)


def test_one_thread_does_the_work(monkeypatch):
    made = []

    class Watched(hazcam.Matcher):
        def __init__(self, *arguments, **options):
            made.append(options["threads"])
            super().__init__(*arguments, **options)

    monkeypatch.setattr("hazcam.matcher.Matcher", Watched)
    for function in (stereo_disparity_fast, stereo_disparity_best):
        function(*(image.astype(np.float32) for image in dots()), BBOX, 32)
    assert made == [1, 1]


@pytest.mark.parametrize("dtype", [np.float64, np.uint8, np.int32])
def test_other_numbers_are_taken_too(dtype):
    left, right = (image.astype(dtype) for image in dots())
    found = stereo_disparity_fast(left, right, BBOX.tolist(), np.int64(32))
    assert np.median(found[10:41, 30:91]) == pytest.approx(7, abs=0.25)
