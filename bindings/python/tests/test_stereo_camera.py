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
    expected = hazcam.StereoCamera(800, 0.25, doffs=10, cx=320, cy=240)
    assert hazcam.read_calibration(middlebury) == expected
    kitti = tmp_path / "000000.txt"
    rows = [(0, 0.0), (1, -350.0), (2, 35.0), (3, -315.7)]
    kitti.write_text("".join(f"P{i}: 700 0 600 {shift} 0 700 180 0 0 0 1 0\n" for i, shift in rows))
    assert hazcam.read_calibration(str(kitti)).baseline_m == pytest.approx(0.5)
    colour = hazcam.read_calibration(kitti, left=tmp_path / "image_2" / "000000_10.png")
    assert colour.baseline_m == pytest.approx(350.7 / 700)
