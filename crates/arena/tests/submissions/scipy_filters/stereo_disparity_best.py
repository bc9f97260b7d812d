import numpy as np
from scipy.ndimage.filters import gaussian_filter, median_filter, sobel


def stereo_disparity_best(Il, Ir, bbox, maxd):
    """Intensity and gradient, truncated, in Gaussian windows; median at the end."""
    gl, gr = sobel(Il, axis=1), sobel(Ir, axis=1)
    best = np.full(Il.shape, np.inf)
    Id = np.zeros(Il.shape)
    for d in range(maxd + 1):
        difference = np.minimum(np.abs(Il - np.roll(Ir, d, axis=1)), 20)
        slope = np.minimum(np.abs(gl - np.roll(gr, d, axis=1)), 40)
        cost = gaussian_filter(difference + slope, 2.0)
        Id[cost < best] = d
        best = np.minimum(best, cost)
    return median_filter(Id, 9)
