import numpy as np
from scipy.ndimage.filters import *


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    best = np.full(Il.shape, np.inf)
    Id = np.zeros(Il.shape)
    for d in range(maxd + 1):
        shifted = np.roll(Ir, d, axis=1)
        cost = uniform_filter(np.abs(Il - shifted), 11)
        Id[cost < best] = d
        best = np.minimum(best, cost)
    return Id
