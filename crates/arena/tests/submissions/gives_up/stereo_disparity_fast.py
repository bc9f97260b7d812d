import numpy as np


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    return np.zeros_like(Il)
