"""Python threads, and processes."""

import copy
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from pairs import dots

import hazcam


def test_threads_share_a_matcher():
    matcher = hazcam.Matcher("balanced", 16, threads=2)
    pairs = [dots(rows=40 + 3 * i, columns=80 + i, shift=1 + i, seed=i) for i in range(8)]
    expected = [matcher.compute(*pair) for pair in pairs]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(3):
            for found, answer in zip(
                pool.map(lambda pair: matcher.compute(*pair), pairs), expected
            ):
                assert found.values.tobytes() == answer.values.tobytes()
                assert found.reasons.tobytes() == answer.reasons.tobytes()


@pytest.fixture
def no_turns():
    """A thread keeps Python to itself until it waits for something, or gives it away."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    yield
    sys.setswitchinterval(before)


def goes_on(work):
    """Whether another Python thread has a turn within ``work``, in one of many calls."""
    turns = []
    gate = threading.Lock()
    gate.acquire()

    def other():
        with gate:
            turns.append(None)

    thread = threading.Thread(target=other)
    thread.start()
    # Opening the gate gives nothing away: the other thread goes through where `work` lets it.
    gate.release()
    for _ in range(20):
        work()
    had_one = bool(turns)
    thread.join()
    return had_one


def test_python_goes_on_while_a_pair_is_matched(no_turns):
    matcher = hazcam.Matcher("balanced", 64, threads=1)
    left, right = dots(rows=100, columns=300)
    assert goes_on(lambda: matcher.compute(left, right))
    # What never lets go shows that the turn was the matcher's to give.
    assert not goes_on(lambda: sorted(range(100_000)))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_matcher_says_that_it_did_not_come_along_into_a_forked_process():
    matcher = hazcam.Matcher("fast", 16)
    pair = dots()
    matcher.compute(*pair)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        message = "answered"
        try:
            matcher.compute(*pair)
        except hazcam.HazcamError as error:
            message = str(error)
            # One of its own works.
            own = hazcam.Matcher("fast", 16).compute(*pair)
            message += f"; {own.values.shape}"
        finally:
            os.write(writer, message.encode())
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as answer:
        told = answer.read()
    os.waitpid(child, 0)
    assert told.startswith("this Matcher was made before the process was forked"), told
    assert told.endswith("make one in each process; (60, 120)"), told


def test_answers_travel_between_processes():
    found = hazcam.match(*dots(), 16)
    truth = np.full((60, 120), 7.0)
    for value in (found, hazcam.score(found, truth), hazcam.StereoCamera(500, 0.1)):
        again = pickle.loads(pickle.dumps(value))
        assert type(again) is type(value)
    again = pickle.loads(pickle.dumps(found))
    assert np.array_equal(again.values, found.values)
    assert np.array_equal(copy.deepcopy(found).reasons, found.reasons)


class Tagged(hazcam.Matcher):
    tag = "none"


def test_a_matcher_keeps_what_others_make_of_it():
    matcher = Tagged("fast", without=iter(()))
    matcher.tag = "mine"
    again = pickle.loads(pickle.dumps(matcher))
    assert (type(again), again.tag) == (Tagged, "mine")
    without = hazcam.Matcher("balanced", without=iter(["median"]))
    assert "without=('median',)" in repr(without)
    assert repr(pickle.loads(pickle.dumps(without))) == repr(without)
    largest = np.array(9)
    matcher = hazcam.Matcher("fast", largest)
    largest[...] = 5
    assert repr(matcher).startswith("hazcam.Matcher('fast', 9, ")


def test_a_matcher_travels_as_what_it_is_made_of():
    matcher = hazcam.Matcher(
        "balanced", 16, min_disparity=-2, holes="keep", without=("median",)
    )
    pair = dots()
    expected = matcher.compute(*pair)
    for again in (pickle.loads(pickle.dumps(matcher)), copy.copy(matcher), copy.deepcopy(matcher)):
        assert again is not matcher
        assert repr(again) == repr(matcher)
        assert np.array_equal(again.compute(*pair).reasons, expected.reasons)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        (there,) = pool.starmap(matcher.compute, [pair])
    assert np.array_equal(there.reasons, expected.reasons)
