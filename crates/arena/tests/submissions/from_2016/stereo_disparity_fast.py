import time
from collections import Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.linalg import inv
from scipy.ndimage.filters import *
from scipy import signal
from scipy.ndimage.interpolation import shift


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    """Names that numpy, scipy and Python have dropped since."""
    started = time.clock()
    half = np.int(11 / 2)
    Id = np.zeros(Il.shape, dtype=np.float)
    best = np.Inf * np.ones(Il.shape)
    bad = np.zeros(Il.shape, dtype=np.bool)
    for d in range(maxd + 1):
        cost = convolve(np.abs(Il - shift(Ir, (0, d), order=0)), np.ones((2 * half + 1,) * 2))
        Id[cost < best] = d
        best = np.minimum(best, cost)
    assert not np.alltrue(bad) and isinstance(bbox.tolist(), Sequence)
    assert np.asscalar(signal.gaussian(3, 1.0)[1:2]) == 1.0
    print("took %.1f s" % (time.clock() - started))
    return Id
