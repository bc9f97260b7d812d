"""Files of the stereo community, between hazcam and others."""

import struct
import zlib

import numpy as np
import pytest

import hazcam


@pytest.mark.parametrize("extension", ["pfm", "npy", "tiff", "png"])
def test_disparities_survive_their_files(tmp_path, extension):
    values = np.array([[1.5, np.nan, 20.25], [0.5, 63, 100]], np.float32)
    path = tmp_path / f"map.{extension}"
    hazcam.write_disparity(path, values)
    read = hazcam.read_disparity(str(path), "png16/256" if extension == "png" else extension)
    assert read.dtype == np.float32
    np.testing.assert_array_equal(read, values)


def test_numpy_reads_what_is_written(tmp_path):
    found = hazcam.DisparityMap(
        np.array([[1, np.nan]], np.float32), np.zeros((1, 2), np.uint8), np.zeros((1, 2)), None
    )
    hazcam.write_disparity(tmp_path / "map.npy", found)
    np.testing.assert_array_equal(np.load(tmp_path / "map.npy"), found.values)


def test_what_had_to_be_assumed_is_told(tmp_path):
    path = tmp_path / "map.png"
    hazcam.write_disparity(path, np.full((2, 2), 3.0))
    with pytest.warns(hazcam.HazcamWarning, match=r"map\.png: 16-bit grey does not say its scale"):
        assert np.all(hazcam.read_disparity(path) == 3)


def test_pictures_are_read_as_they_are(tmp_path):
    grey = np.arange(6, dtype=np.uint8).reshape(2, 3)
    (tmp_path / "grey.pgm").write_bytes(b"P5 3 2 255\n" + grey.tobytes())
    read = hazcam.read_image(tmp_path / "grey.pgm")
    assert read.dtype == np.uint8
    np.testing.assert_array_equal(read, grey)
    colour = np.arange(18, dtype=np.uint16).reshape(2, 3, 3) * 3000
    (tmp_path / "colour.ppm").write_bytes(b"P6 3 2 65535\n" + colour.astype(">u2").tobytes())
    read = hazcam.read_image(tmp_path / "colour.ppm")
    assert read.dtype == np.uint16
    np.testing.assert_array_equal(read, colour)


def test_a_picture_that_is_to_be_turned_is_told(tmp_path):
    # A PNG of one grey pixel.
    picture = tmp_path / "turned.png"
    exif = b"II*\0\x08\0\0\0\x01\0" + b"\x12\x01\x03\0\x01\0\0\0\x06\0\0\0" + bytes(4)
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0)),
        (b"eXIf", exif),
        (b"IDAT", zlib.compress(b"\0\x07")),
        (b"IEND", b""),
    ]
    png = b"\x89PNG\r\n\x1a\n"
    for name, data in chunks:
        png += struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    picture.write_bytes(png)
    with pytest.warns(hazcam.HazcamWarning, match="orientation 6"):
        assert hazcam.read_image(picture).tolist() == [[7]]
