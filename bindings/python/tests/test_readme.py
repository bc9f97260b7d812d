"""What the pages say to do is done as it stands there."""

import re
from pathlib import Path

import numpy as np
import pytest
from pairs import dots

PROJECT = Path(__file__).parents[3]


def examples(page):
    return re.findall(r"^```python\n(.*?)^```", (PROJECT / page).read_text("utf-8"), re.M | re.S)


def test_the_example_of_the_package(capsys):
    [example] = examples("bindings/python/README.md")
    exec(example, {})
    told = capsys.readouterr().out.splitlines()
    assert told[0].startswith("<hazcam.DisparityMap of 120 rows x 200 columns, 9")
    assert float(told[1]) == 7
    assert float(told[2].strip("[]").split()[2]) == pytest.approx(12, abs=0.1)
    assert float(told[3]) < 0.05


def test_the_example_of_the_project(tmp_path, monkeypatch):
    [example] = examples("README.md")
    for name, image in zip(("left.png", "right.png"), dots(rows=80, columns=160)):
        # The content counts, not the extension.
        (tmp_path / name).write_bytes(b"P5 160 80 255\n" + image.tobytes())
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(example, names)
    assert names["depth"].shape == names["sure"].shape == (80, 160)
    assert np.nanmedian(names["depth"]) == pytest.approx(12, abs=0.1)
    assert (tmp_path / "disparity.pfm").stat().st_size > 4 * 80 * 160
