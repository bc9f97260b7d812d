"""Scores of cases worked by hand."""

import numpy as np
import pytest

import hazcam

NAN = np.nan


def test_by_hand():
    # Off by 0.5, by 3, a hole; one truth that nobody knows.
    truth = np.array([[10, 20, NAN, 40]], np.float32)
    estimate = np.array([[10.5, 23, 30, NAN]], np.float32)
    scores = hazcam.score(estimate, truth)
    assert (scores.pixels, scores.holes) == (3, 1)
    assert scores.p_bad == scores.measures["p_bad"] == pytest.approx(2 / 3)
    assert scores.e_rms == scores.measures["E_RMS"] == pytest.approx(np.sqrt((0.25 + 9 + 1600) / 3))
    assert scores.measures["avgerr"] == pytest.approx(1.75)
    assert scores.measures["bad4"] == pytest.approx(1 / 3)
    assert scores.measures["bias"] == pytest.approx(1.75)
    # Exactly 3 pixels off is no outlier; the hole is filled from its left.
    assert (scores.measures["D1-est"], scores.measures["D1"]) == (0, pytest.approx(1 / 3))
    assert len(scores.measures) == 29
    # Off by 3 px, and the hole, which is filled from its left, by 10.
    assert [scores.measures[f"Out{t}"] for t in (2, 3)] == [pytest.approx(2 / 3), pytest.approx(1 / 3)]
    assert "3 pixels with known truth in the whole image" in scores.protocols["avgerr"]


def test_only_box_and_mask_are_scored():
    truth = np.full((4, 5), 10.0)
    estimate = truth.copy()
    estimate[1, 2] = 60
    assert hazcam.score(estimate, truth).p_bad == pytest.approx(1 / 20)
    assert hazcam.score(estimate, truth, box=(2, 1, 3, 1)).p_bad == 0.5
    mask = np.zeros((4, 5), bool)
    mask[1:3, 2] = True
    masked = hazcam.score(estimate, truth, mask=mask)
    assert (masked.pixels, masked.p_bad) == (2, 0.5)
    assert hazcam.score(estimate, truth, box=(2, 1, 3, 1), mask=mask).p_bad == 1
    assert (
        "the box 2,1,3,1 (inclusive)"
        in hazcam.score(estimate, truth, box=(2, 1, 3, 1)).protocols["E_RMS"]
    )


def test_estimates_are_clipped_where_that_is_asked_for():
    truth, estimate = np.full((2, 2), 60.0), np.full((2, 2), 90.0)
    assert hazcam.score(estimate, truth).measures["avgerr"] == 30
    assert hazcam.score(estimate, truth, max_disparity=60).measures["avgerr"] == 0


@pytest.mark.parametrize("dtype", [np.float16, np.float64, np.int64, np.uint8, ">f4"])
def test_maps_may_be_of_any_numbers(dtype):
    truth = np.arange(1, 13).reshape(3, 4)
    estimate = np.asfortranarray((truth + 1).astype(dtype))
    assert hazcam.score(estimate, truth.astype(dtype)).measures["EPE"] == 1


def test_what_cannot_be_taken_is_none():
    scores = hazcam.score(np.full((2, 2), NAN), np.zeros((2, 2)))
    assert scores.e_rms is None and scores.measures["avgerr"] is None
    assert "E_RMS" not in scores.protocols
    assert scores.measures["bad1"] == 1


def test_a_factor_between_the_two_is_told():
    truth = np.arange(10.0, 60.0).reshape(5, 10)
    with pytest.warns(hazcam.HazcamWarning, match="`disparity` were divided by 4: is it in pixels"):
        hazcam.score(4 * truth, truth)
    with pytest.warns(hazcam.HazcamWarning, match="`truth` were divided by 16: is it in pixels"):
        hazcam.score(truth, 16 * truth)
    with pytest.warns(hazcam.HazcamWarning, match="`disparity` had the other sign"):
        hazcam.score(-truth, truth)


def test_zeros_that_stand_for_unknown_speak_for_no_factor(recwarn):
    truth = np.arange(10.0, 60.0).reshape(5, 10)
    truth[:4] = 0
    hazcam.score(np.full((5, 10), 30.0), truth)
    assert not recwarn.list
