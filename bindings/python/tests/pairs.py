"""Pairs of images with a known answer."""

import numpy as np


def dots(rows=60, columns=120, shift=7, seed=1):
    """Random dots, which the right camera sees ``shift`` pixels further left."""
    width = columns + abs(shift)
    wide = np.random.default_rng(seed).integers(0, 256, (rows, width), np.uint8)
    near, far = wide[:, :columns], wide[:, abs(shift) :]
    pair = (near, far) if shift >= 0 else (far, near)
    return tuple(np.ascontiguousarray(image) for image in pair)


def inner(values, shift=7):
    """What both cameras see, away from the border."""
    return values[5:-5, abs(shift) + 8 : -(abs(shift) + 8)]
