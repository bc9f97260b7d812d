"""The command answers the same, bit for bit."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import hazcam


def command():
    """The program: ``HAZCAM_COMMAND``, or one that was built in this source tree."""
    named = os.environ.get("HAZCAM_COMMAND")
    built = Path(__file__).parents[3] / "target" / "release" / "hazcam"
    return named or shutil.which(built)


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Coloured cards before a wall, as files."""
    program = command()
    if program is None:
        pytest.skip("no `hazcam` command: cargo build --release, or name one in HAZCAM_COMMAND")
    rng = np.random.default_rng(8)
    rows, columns = 150, 260
    views = np.zeros((2, rows, columns, 3), np.uint8)
    for disparity, (top, bottom), (first, last) in [
        (6, (0, rows), (0, columns)),
        (19, (30, 100), (40, 120)),
        (31, (70, 140), (150, 220)),
    ]:
        card = rng.integers(0, 256, (bottom - top, last - first + disparity, 3))
        card = (card + np.roll(card, 1, 0) + np.roll(card, 1, 1)) // 3
        for view, shift in zip(views, (0, disparity)):
            begin = max(first - shift, 0)
            view[top:bottom, begin:last] = card[:, begin + shift - first : last - first + shift]
    folder = tmp_path_factory.mktemp("pair")
    for name, view in zip(("left.ppm", "right.ppm"), views):
        header = f"P6 {columns} {rows} 255\n".encode()
        (folder / name).write_bytes(header + view.tobytes())
    return program, folder / "left.ppm", folder / "right.ppm"


@pytest.mark.parametrize(
    "preset, box, holes, minimum",
    [
        ("fast", None, "fill", 0),
        ("fast", (50, 20, 200, 130), "keep", -4),
        ("balanced", None, "fill", 0),
        ("balanced", (50, 20, 200, 130), "keep", -4),
        ("best", (50, 20, 200, 130), "fill", 0),
    ],
)
def test_the_command_finds_the_same(pair, tmp_path, preset, box, holes, minimum):
    program, left, right = pair
    out, sure = tmp_path / "d.npy", tmp_path / "c.npy"
    options = ["--matcher", preset, "--max-disparity", "40", "--min-disparity", str(minimum)]
    options += ["--holes", holes, "--confidence", sure]
    if box is not None:
        options += ["--box", ",".join(map(str, box))]
    subprocess.run([program, "-q", "match", left, right, "-o", out, *options], check=True)
    images = hazcam.read_image(left), hazcam.read_image(right)
    found = hazcam.match(*images, 40, min_disparity=minimum, preset=preset, box=box, holes=holes)
    assert np.isnan(found.values).any() == (box is not None or holes == "keep")
    assert np.load(out).tobytes() == found.values.tobytes()
    assert np.load(sure).tobytes() == found.confidence.tobytes()
