import numpy as np
from matplotlib import pyplot as plt

from stereo_disparity_fast import *


def stereo_disparity_best(Il, Ir, bbox, maxd):
    Id = stereo_disparity_fast(Il, Ir, bbox, maxd)
    return np.round_(median_filter(Id, 7))
