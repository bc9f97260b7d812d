"""What looks like a mistake is warned of, at the line that made it."""

import warnings

import numpy as np
import pytest
from pairs import dots

import hazcam
from hazcam.course import stereo_disparity_fast


def told(call):
    """What is warned of, always from this file."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    assert all(issubclass(one.category, hazcam.HazcamWarning) for one in caught)
    assert all(one.filename == __file__ for one in caught)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("preset", ["fast", "balanced", "best"])
def test_a_sound_pair_is_not_doubted(preset):
    left, right = dots()
    assert told(lambda: hazcam.match(left, right, 32, preset=preset)) == []


def test_a_pair_of_which_hardly_anything_matches_is_doubted():
    (left, _), (_, right) = dots(seed=1), dots(seed=2)
    expected = (
        "few pixels are matched, so this is to be doubted. Either `left` is not the left "
        "image of the two (exchange them), or things lie outside disparities -3 to 32 (raise "
        "`max_disparity`, lower `min_disparity`), or the two are no rectified pair of one scene "
        "(rectify them), or they have no texture, or so much of it that more effort is needed (preset 'best')"
    )
    matcher = hazcam.Matcher("balanced", 32, min_disparity=-3)
    assert told(lambda: matcher.compute(left, right)) == [expected]
    # The part that is answered counts.
    left[:, :20] = right[:, :20] = 0
    assert told(lambda: matcher.compute(left, right, box=(20, 0, 119, 59))) == [expected]
    assert told(lambda: matcher.compute(left, right, box=(0, 0, 50, 59))) == []


def test_matches_that_do_not_thin_out_towards_the_end_of_the_range_are_doubted():
    (left, right), near, (_, other) = dots(120), dots(120, shift=18), dots(120, seed=2)
    # 6 rows of ten are matched, some of them near the end; the others show something else.
    left[60:72], right[60:72] = near[0][60:72], near[1][60:72]
    right[72:] = other[72:]
    expected = (
        "many of the pixels are not matched, and those that are do not thin out towards the largest disparity, 20: "
        "there may be nearer things that are missed, and filled as if they were far where holes are filled; raise "
        "`max_disparity`"
    )
    assert told(lambda: hazcam.match(left, right, 20, preset="fast")) == [expected]
    assert told(lambda: hazcam.match(left, right, 40, preset="fast")) == []


def test_matches_at_an_end_of_the_range_are_doubted():
    left, right = dots(shift=20)
    nearer = (
        "many of the matched pixels lie at the largest disparity, 20: there may be nearer things "
        "that are missed; raise `max_disparity`"
    )
    assert told(lambda: hazcam.match(left, right, 20, preset="fast")) == [nearer]
    farther = (
        "many of the matched pixels lie at the smallest disparity, 20: there may be farther things "
        "that are missed; lower `min_disparity`"
    )
    assert told(lambda: hazcam.match(left, right, 40, min_disparity=20, preset="fast")) == [farther]
    left, right = dots(shift=0)
    infinite = (
        "many of the matched pixels lie at disparity 0, infinitely far. If nothing is, the two show "
        "what belongs to the cameras: blocks of compressed pictures, dust on lenses, vignetting"
    )
    assert told(lambda: hazcam.match(left, right, 40)) == [infinite]
    thermal = [30000 + image.astype(np.uint16) for image in dots(shift=20)]
    levels = (
        "all samples of `left` and `right` lie in a small part of what they hold, which makes "
        "matches worse; spread them over all of it, alike in both"
    )
    assert levels in told(lambda: hazcam.match(*thermal, 40))


def test_pictures_are_doubted_once():
    left, right = dots(rows=80, columns=120, shift=9)
    soft = (sum(np.roll(right, i, 1).astype(float) for i in range(5)) / 5).astype(np.uint8)
    matcher = hazcam.Matcher("balanced", 24)
    less_sharp = (
        "`left` has much more fine detail than `right`: is one out of focus, moved, of another "
        "resolution or noisier? Where edges are blurred in one image alone matches are off, and may "
        "be sure"
    )
    assert less_sharp in told(lambda: matcher.compute(left, soft))
    assert less_sharp not in told(lambda: matcher.compute(left, soft))
    # A first frame that shows nothing is not all that is looked at.
    matcher = hazcam.Matcher("balanced", 24)
    black = np.zeros_like(left)
    assert told(lambda: matcher.compute(black, black))
    assert less_sharp in told(lambda: matcher.compute(left, soft))


def test_the_course_function_doubts_too():
    left, right = dots(shift=20)
    nearer = (
        "many of the matched pixels lie at the largest disparity, 20: there may be nearer things "
        "that are missed; raise `max_disparity`"
    )
    bbox = [[0, 119], [0, 59]]
    floats = left.astype(np.float32), right.astype(np.float32)
    assert told(lambda: stereo_disparity_fast(*floats, bbox, 20)) == [nearer]


def test_bits_that_are_never_used_are_told_with_a_remedy():
    left, right = (image.astype(np.uint16) << np.uint16(4) for image in dots())
    [words] = told(lambda: hazcam.match(left, right, 32))
    assert words == (
        "of the 16 bits of `left` and `right` the upper 4 are never used, which makes matches "
        "worse; if the camera gives 12 bits, give left << numpy.uint16(4) and the right one alike"
    )
    left, right = left << np.uint16(4), right << np.uint16(4)
    assert told(lambda: hazcam.match(left, right, 32)) == []


def test_frames_with_the_same_doubt_are_told_of_once():
    matcher = hazcam.Matcher("fast", 20)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        for seed in range(3):
            matcher.compute(*dots(shift=20, seed=seed))
    assert len(caught) == 1
