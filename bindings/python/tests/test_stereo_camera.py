"""Depth and points of cases worked by hand: f B = 800 * 0.25 = 200 px m."""

import numpy as np
import pytest

import hazcam

CAMERA = hazcam.StereoCamera(focal_px=800, baseline_m=0.25, cx=320, cy=240)


def test_depth_is_focal_length_times_baseline_over_disparity():
    disparity = np.array([[50, np.nan, 0, 100, -3]], np.float32)
    depth = CAMERA.depth(disparity)
    assert depth.dtype == np.float32
    np.testing.assert_array_equal(depth, [[4, np.nan, np.nan, 2, np.nan]])
    shifted = hazcam.StereoCamera(800, 0.25, doffs=10)
    np.testing.assert_array_equal(shifted.depth(np.array([[30, -5, -10]])), [[5, 40, np.nan]])


def test_points_stand_where_their_pixels_look():
    disparity = np.full((241, 721), np.nan)
    disparity[40, 720] = 50
    disparity[240, 320] = 20
    points = CAMERA.points(disparity)
    assert points.shape == (241, 721, 3)
    # Z = 4 m; (720 - 320) * 4 / 800 = 2 m right, (40 - 240) * 4 / 800 = 1 m up.
    assert points[40, 720].tolist() == [2, -1, 4]
    assert points[240, 320].tolist() == [0, 0, 10]
    assert np.isnan(points).sum() == 3 * (241 * 721 - 2)


def test_without_a_principal_point_cameras_look_at_the_middle_of_the_map():
    # Z = 4 m; 5 mm a pixel: 1.5 rows and 2 columns from the middle of 4 rows x 5 columns.
    disparity = np.full((4, 5), 50)
    points = hazcam.StereoCamera(800, 0.25).points(disparity)
    np.testing.assert_allclose(points[0, 0], [-0.01, -0.0075, 4], rtol=1e-6)
    np.testing.assert_allclose(points[3, 2], [0, 0.0075, 4], rtol=1e-6)
    points = hazcam.StereoCamera(800, 0.25, cx=0).points(disparity)
    np.testing.assert_allclose(points[0, 4], [0.02, -0.0075, 4], rtol=1e-6)
    points = hazcam.StereoCamera(800, 0.25, cy=0).points(disparity)
    np.testing.assert_allclose(points[3, 4], [0.01, 0.015, 4], rtol=1e-6)


def test_a_map_of_a_matcher_is_taken():
    values = np.full((2, 3), 50, np.float32)
    reasons = np.ones((2, 3), np.uint8)
    found = hazcam.DisparityMap(values, reasons, values / 50, None)
    assert np.all(CAMERA.depth(found) == 4)
    assert np.all(CAMERA.points(found)[..., 2] == 4)


def test_cameras_are_values():
    assert hazcam.StereoCamera(800, 0.25) == hazcam.StereoCamera(800.0, 0.25)
    assert hazcam.StereoCamera(800, 0.25) != CAMERA
    assert len({hazcam.StereoCamera(800, 0.25), hazcam.StereoCamera(800.0, 0.25)}) == 1


def test_calibrations_are_read(tmp_path):
    middlebury = tmp_path / "calib.txt"
    middlebury.write_text(
        "cam0=[800 0 320; 0 800 240; 0 0 1]\ncam1=[800 0 330; 0 800 240; 0 0 1]\n"
        "doffs=10\nbaseline=250\nwidth=640\nheight=480\nndisp=64\n"
    )
    expected = hazcam.StereoCamera(800, 0.25, doffs=10, cx=320, cy=240, size=(640, 480))
    assert hazcam.read_calibration(middlebury) == expected
    kitti = tmp_path / "000000.txt"
    rows = [(0, 0.0), (1, -350.0), (2, 35.0), (3, -315.7)]
    kitti.write_text("".join(f"P{i}: 700 0 600 {shift} 0 700 180 0 0 0 1 0\n" for i, shift in rows))
    assert hazcam.read_calibration(str(kitti)).baseline_m == pytest.approx(0.5)
    colour = hazcam.read_calibration(kitti, left=tmp_path / "image_2" / "000000_10.png")
    assert colour.baseline_m == pytest.approx(350.7 / 700)


def test_maps_of_another_size_than_the_images_are_refused_and_a_scaled_camera_takes_them():
    camera = hazcam.StereoCamera(800, 0.25, doffs=10, cx=320, cy=240, size=(640, 480))
    whole, half = np.full((480, 640), 30.0), np.full((240, 320), 15.0)
    for answer in (camera.depth, camera.points):
        with pytest.raises(hazcam.ArgumentError, match=r"240 rows x 320 columns.*scaled\(0\.5\)"):
            answer(half)
    scaled = camera.scaled(0.5)
    assert scaled == hazcam.StereoCamera(400, 0.25, doffs=5, cx=159.75, cy=119.75, size=(320, 240))
    assert np.all(scaled.depth(half) == camera.depth(whole)[::2, ::2])
    anywhere = hazcam.StereoCamera(800, 0.25).scaled(2)
    assert (anywhere.cx, anywhere.cy, anywhere.size) == (None, None, None)
    for times in (0, -1, float("nan")):
        with pytest.raises(hazcam.ArgumentError, match="times"):
            camera.scaled(times)
    for size in ([640, 480], np.array([640, 480]), (np.int64(640), 480)):
        given = hazcam.StereoCamera(800, 0.25, size=size)
        assert given == hazcam.StereoCamera(800, 0.25, size=(640, 480)) and hash(given)
        assert [type(number) for number in given.size] == [int, int]
    for size in ((0, 5), (5,), (1, 2, 3), 7):
        with pytest.raises(hazcam.ArgumentError, match="size"):
            hazcam.StereoCamera(800, 0.25, size=size)


def test_numbers_in_other_units_are_doubted():
    with pytest.warns(hazcam.HazcamWarning, match="focal length is 0.004 px"):
        hazcam.StereoCamera(0.004, 0.12)
    with pytest.warns(hazcam.HazcamWarning, match="baseline is 120 m"):
        hazcam.StereoCamera(700, 120)


def test_what_is_not_sure_filled_or_far_can_be_left_out():
    values = np.array([[50, 50, 20]], np.float32)
    reasons = np.array([[1, 2, 1]], np.uint8)
    found = hazcam.DisparityMap(values, reasons, np.float32([[0.9, 0.1, 0.6]]), None)
    with pytest.warns(hazcam.HazcamWarning, match="filled in without a match.*min_confidence"):
        np.testing.assert_array_equal(CAMERA.depth(found), [[4, 4, 10]])
    with pytest.warns(hazcam.HazcamWarning, match="a min_confidence above 0.05"):
        CAMERA.depth(found, min_confidence=0.1)
    np.testing.assert_array_equal(CAMERA.depth(found, min_confidence=0.5), [[4, np.nan, 10]])
    sure = CAMERA.points(found, min_confidence=0.5, max_depth=9)
    np.testing.assert_array_equal(np.isnan(sure[0]).all(axis=1), [False, True, True])
    np.testing.assert_array_equal(CAMERA.depth(values, max_depth=4), [[4, 4, np.nan]])
    with pytest.raises(hazcam.ArgumentError, match="min_confidence.*DisparityMap"):
        CAMERA.depth(values, min_confidence=0.5)
    for wrong in ({"min_confidence": 1.5}, {"max_depth": 0}):
        with pytest.raises(hazcam.ArgumentError, match=next(iter(wrong))):
            CAMERA.depth(found, **wrong)
    for wrong in ({"min_confidence": "x"}, {"min_confidence": None}, {"max_depth": True}):
        with pytest.raises(hazcam.ArgumentTypeError, match=f"`{next(iter(wrong))}` is .*a number"):
            CAMERA.points(found, **wrong)


def test_disparities_that_no_match_has_are_doubted():
    of_kitti = np.full((2, 3), 5120, np.uint16)
    for call in (CAMERA.depth, CAMERA.points):
        with pytest.warns(hazcam.HazcamWarning, match="up to 5120 px in a map of 3 columns"):
            call(of_kitti)
        with pytest.warns(hazcam.HazcamWarning, match="6 of 6 disparities are of nothing in front"):
            call(np.full((2, 3), -4.0))


def test_uncertainty_grows_with_the_square_of_depth():
    off = CAMERA.depth_uncertainty(np.array([[2, 4, np.nan]]), 0.5)
    np.testing.assert_allclose(off, [[0.01, 0.04, np.nan]], rtol=1e-6)
    with pytest.raises(hazcam.ArgumentError, match="disparity_error"):
        CAMERA.depth_uncertainty(np.ones((1, 1)), 0)
    with pytest.raises(hazcam.ArgumentError, match="`depth` is 1e300.*depths must fit float32"):
        CAMERA.depth_uncertainty(np.full((1, 1), 1e300))
    with pytest.raises(hazcam.ArgumentError, match="a map of depths .* in metres"):
        CAMERA.depth_uncertainty(np.ones(3))


def test_sixteenths_of_a_pixel_are_doubted():
    of_opencv = np.array([[80, 16]], np.int16)
    with pytest.warns(hazcam.HazcamWarning, match="`disparity` is an array of int16.*sixteenths"):
        CAMERA.depth(of_opencv)
