"""Pairs with a known answer are answered so, however the images lie in memory."""

import numpy as np
import pytest
from pairs import dots, inner

import hazcam
from hazcam import Reason

PRESETS = ["fast", "balanced", "best"]


def same(a, b):
    """Whether two maps are the same bit for bit."""
    return all(
        getattr(a, plane).tobytes() == getattr(b, plane).tobytes()
        for plane in ("values", "reasons", "confidence")
    )


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("shift", [1, 7, 31])
def test_shifted_dots_give_their_shift(preset, shift):
    left, right = dots(shift=shift)
    found = hazcam.Matcher(preset, max_disparity=32).compute(left, right)
    assert found.values.shape == found.reasons.shape == found.confidence.shape == left.shape
    assert (found.values.dtype, found.reasons.dtype) == (np.float32, np.uint8)
    assert found.confidence.dtype == np.float32
    wrong = np.abs(inner(found.values, shift) - shift) > 0.5
    assert wrong.mean() < 0.01
    assert (inner(found.reasons, shift) == Reason.MATCHED).mean() > 0.9


@pytest.mark.parametrize("preset", PRESETS)
def test_negative_disparities_are_found(preset):
    left, right = dots(shift=-5)
    found = hazcam.match(left, right, 4, min_disparity=-8, preset=preset)
    assert np.median(inner(found.values, -5)) == pytest.approx(-5, abs=0.25)


def test_colour_and_grey_of_8_and_16_bits_are_taken():
    left, right = dots()
    matcher = hazcam.Matcher("balanced", 32)
    grey = matcher.compute(left, right)
    colour = [np.repeat(image[..., None], 3, axis=2) for image in (left, right)]
    assert same(matcher.compute(*colour), grey)
    for pair in [(left, right), colour]:
        deep = [image.astype(np.uint16) * 257 for image in pair]
        assert np.median(inner(matcher.compute(*deep).values)) == pytest.approx(7, abs=0.25)


def test_colours_count_as_in_luma():
    left, right = dots()
    channels = [np.stack([image, image // 2, image // 3], axis=-1) for image in (left, right)]
    luma = [
        ((299 * r.astype(int) + 587 * g.astype(int) + 114 * b.astype(int) + 500) // 1000)
        for r, g, b in (np.moveaxis(image, -1, 0) for image in channels)
    ]
    matcher = hazcam.Matcher("fast", 32)
    expected = matcher.compute(*[grey.astype(np.uint8) for grey in luma])
    assert same(matcher.compute(*channels), expected)
    # Blue first, as OpenCV has it, turned around by a view.
    blue_first = [np.ascontiguousarray(image[..., ::-1]) for image in channels]
    assert same(matcher.compute(*[image[..., ::-1] for image in blue_first]), expected)
    assert not same(matcher.compute(*blue_first), expected)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3])
def test_no_layout_of_memory_changes_the_answer(depth, channels):
    rng = np.random.default_rng(2)
    shape = (40, 90, 3) if channels == 3 else (40, 90)
    left = rng.integers(0, np.iinfo(depth).max, shape, depth, endpoint=True)
    right = np.ascontiguousarray(np.roll(left, -4, axis=1))
    matcher = hazcam.Matcher("fast", 16)
    expected = matcher.compute(left, right)

    def strided(image):
        wide = np.zeros((2 * image.shape[0], 3 * image.shape[1], *image.shape[2:]), depth)
        wide[::2, ::3] = image
        return wide[::2, ::3]

    def reversed_rows(image):
        return np.ascontiguousarray(image[::-1])[::-1]

    def unaligned(image):
        raw = np.empty(image.nbytes + 1, np.uint8)
        view = raw[1:].view(depth).reshape(image.shape)
        view[...] = image
        return view

    def read_only(image):
        image = image.copy()
        image.setflags(write=False)
        return image

    for layout in [np.asfortranarray, strided, reversed_rows, unaligned, read_only]:
        assert same(matcher.compute(layout(left), layout(right)), expected), layout
    if depth == np.uint16:
        assert not unaligned(left).flags.aligned


def test_only_the_box_is_answered():
    left, right = dots()
    box = (30, 10, 90, 40)
    found = hazcam.match(left, right, 32, box=box)
    inside = np.zeros(left.shape, bool)
    inside[10:41, 30:91] = True
    assert np.array_equal(np.isfinite(found.values), inside)
    assert np.array_equal(found.reasons != Reason.OUTSIDE_BOX, inside)
    assert np.all(found.confidence[~inside] == 0)
    for other in [list(box), np.array(box), np.array(box, np.uint8)]:
        assert same(hazcam.match(left, right, 32, box=other), found)


@pytest.mark.parametrize("preset", PRESETS)
def test_holes_are_kept_where_that_is_asked_for(preset):
    left, right = dots(shift=20)
    filled = hazcam.match(left, right, 32, preset=preset)
    kept = hazcam.match(left, right, 32, preset=preset, holes="keep")
    assert np.all(np.isfinite(filled.values))
    holes = np.isnan(kept.values)
    assert holes[:, :20].mean() > 0.9  # Outside of the right image.
    for hole, fill in [
        (Reason.OCCLUDED_HOLE, Reason.OCCLUDED_FILLED),
        (Reason.MISMATCHED_HOLE, Reason.MISMATCHED_FILLED),
        (Reason.OUTSIDE_RIGHT_HOLE, Reason.OUTSIDE_RIGHT_FILLED),
    ]:
        assert np.array_equal(kept.reasons == hole, filled.reasons == fill)
    assert np.array_equal(holes, kept.reasons >= Reason.OCCLUDED_HOLE)
    assert np.all(kept.confidence[holes] == 0)
    assert np.array_equal(kept.values[~holes], filled.values[~holes])


def test_frames_may_differ_in_size_and_keep_their_answers():
    matcher = hazcam.Matcher("balanced", 16)
    first, second = dots(seed=3), dots(rows=33, columns=77, shift=3, seed=4)
    answer = matcher.compute(*first)
    before = answer.values.copy(), answer.reasons.copy(), answer.confidence.copy()
    other = matcher.compute(*second)
    assert other.values.shape == (33, 77)
    assert np.median(inner(other.values, 3)) == pytest.approx(3, abs=0.25)
    assert np.array_equal(answer.values, before[0])
    assert np.array_equal(answer.reasons, before[1])
    assert np.array_equal(answer.confidence, before[2])
    assert same(matcher.compute(*first), answer)
    answer.values[...] = 0  # They belong to the caller.
    assert not same(matcher.compute(*first), answer)


def test_options_reach_the_matcher():
    left, right = dots(rows=200, columns=300)
    plain = hazcam.match(left, right, 32)
    assert same(hazcam.match(left, right, 32, threads=1), plain)
    assert same(hazcam.match(left, right, 32, memory=4_000_000), plain)
    assert not same(hazcam.match(left, right, 32, without=["median", "learned-choice"]), plain)
    # Numbers of numpy are numbers.
    one = hazcam.Matcher("balanced", np.int64(32), min_disparity=np.int8(0), threads=np.uint8(1))
    assert same(one.compute(left, right), plain)


def test_vertical_disparity_is_told():
    rng = np.random.default_rng(5)
    smooth = rng.integers(0, 256, (130, 210)).astype(float)
    for axis in (0, 1):
        smooth = (np.roll(smooth, 1, axis) + 2 * smooth + np.roll(smooth, -1, axis)) / 4
    # Two rows lower on the right.
    image = smooth.astype(np.uint8)
    left, right = image[2:, :200], image[:-2, 6:206]
    left, right = left[:126], right[:126]
    told = "things stand more than 1.5 pixels higher or lower in `right`"
    with pytest.warns(hazcam.HazcamWarning, match=told):
        found = hazcam.match(left, right, 32)
    vertical = found.vertical_disparity
    assert vertical is not None
    rows, columns = left.shape
    y, x = np.mgrid[0:9, 0:9] / 8
    x, y = x * (columns - 1) / columns - 0.5, y * (rows - 1) / rows - 0.5
    c = vertical.coefficients
    lower = c[0] + c[1] * x + c[2] * y + c[3] * x * y + c[4] * y**2
    assert lower[4, 4] == pytest.approx(2, abs=0.2)
    assert vertical.root_mean_square == pytest.approx(np.sqrt(np.mean(lower**2)))
    assert vertical.largest == pytest.approx(np.abs(lower).max())
    with pytest.warns(hazcam.HazcamWarning, match="few pixels are matched"):
        assert hazcam.match(left, right, 32, preset="fast").vertical_disparity is None
    left, right = dots(rows=126, columns=200)
    assert hazcam.match(left, right, 32).vertical_disparity is None


def test_a_map_and_a_matcher_can_be_shown():
    found = hazcam.match(*dots(), 32)
    share = np.mean(found.reasons == Reason.MATCHED)
    expected = f"<hazcam.DisparityMap of 60 rows x 120 columns, {100 * share:.1f}% matched>"
    assert repr(found) == expected
    matcher = hazcam.Matcher("fast", 16, holes="keep")
    assert eval(repr(matcher)).compute(*dots()).reasons.tolist() == (
        matcher.compute(*dots()).reasons.tolist()
    )


def test_as_an_array_a_map_is_its_values(tmp_path):
    found = hazcam.match(*dots(), 32)
    assert np.shares_memory(np.asarray(found), found.values)
    assert not np.shares_memory(np.array(found), found.values)
    assert np.asarray(found, np.float64).dtype == np.float64
    np.save(tmp_path / "d.npy", found)
    np.testing.assert_array_equal(hazcam.read_disparity(tmp_path / "d.npy"), found.values)


def test_reasons_are_those_of_the_matcher():
    names = {reason.name.lower().replace("_", "-"): int(reason) for reason in Reason}
    assert names == hazcam._hazcam.REASONS
