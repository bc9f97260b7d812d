import numpy as np


def stereo_disparity_best(Il, Ir, bbox, maxd):
    return np.full(Il.shape, maxd / 3)
