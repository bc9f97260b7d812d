import time

import numpy as np


def stereo_disparity_best(Il, Ir, bbox, maxd):
    """Uses no CPU time at all, and never ends."""
    time.sleep(1e6)
    return np.zeros(Il.shape)
