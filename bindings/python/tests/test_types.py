"""Types are what the package says, and users of it are told where theirs are wrong."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import hazcam

SOURCES = Path(__file__).parents[1] / "python" / "hazcam"

pytest.importorskip("mypy", reason="mypy is not installed: types are not checked")


def run(*arguments):
    ran = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_the_stub_is_what_is_there():
    run("mypy.stubtest", "hazcam._hazcam")


def test_aliases_can_be_put_together_when_a_program_runs():
    for alias in (hazcam.Image, hazcam.Preset, hazcam.Holes):
        assert alias | None != alias


def test_types_are_right():
    run("mypy", "--strict", str(SOURCES))


def test_the_remedy_for_few_bits_is_of_a_right_type(tmp_path):
    [remedy] = re.findall(r"uint16 want ``(.+?)``", hazcam.Matcher.compute.__doc__)
    program = tmp_path / "program.py"
    program.write_text(
        "import hazcam\n"
        "import numpy as np\n"
        "left = hazcam.read_image('l.png')\n"
        f"hazcam.match({remedy}, {remedy})\n"
    )
    run("mypy", "--strict", str(program))


def test_users_are_told_of_wrong_types(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import hazcam\n"
        "matcher = hazcam.Matcher('balanced', 64)\n"
        "left, right = hazcam.read_image('l.png'), hazcam.read_image('r.png')\n"
        "rows, columns = matcher.compute(left, right, box=(0, 0, 5, 5)).values.shape\n"
        "hazcam.Matcher('blanced')\n"
    )
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", str(program)], capture_output=True, text=True
    )
    errors = [line for line in ran.stdout.splitlines() if ": error:" in line]
    assert len(errors) == 1 and ":5: error:" in errors[0], ran.stdout + ran.stderr


def test_pictures_and_numbers_of_opencv_and_numpy_are_of_right_types(tmp_path):
    pytest.importorskip("cv2", reason="OpenCV is not installed: its types are not checked")
    program = tmp_path / "program.py"
    program.write_text(
        "import cv2\n"
        "import hazcam\n"
        "import numpy as np\n"
        "left, right = cv2.imread('l.png', 0), cv2.imread('r.png', 0)\n"
        "assert left is not None and right is not None\n"
        "found = hazcam.match(left, right, np.int64(63))\n"
        "hazcam.score(found, found.values, mask=left == 255)\n"
    )
    run("mypy", "--strict", str(program))
