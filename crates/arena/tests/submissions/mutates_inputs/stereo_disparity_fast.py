import numpy as np


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    """Normalises the images where they are, and moves the box to count from 1."""
    Il -= Il.mean()
    Ir -= Ir.mean()
    x0, y0 = bbox[0, 0], bbox[1, 0]
    bbox -= bbox.min()
    best = np.full(Il.shape, np.inf)
    Id = Il
    answer = np.zeros(Il.shape, dtype=np.float32)
    for d in range(maxd + 1):
        difference = np.abs(Id - np.roll(Ir, d, axis=1))
        total = difference.cumsum(0).cumsum(1)
        cost = np.full(Il.shape, np.inf)
        cost[5:-6, 5:-6] = total[11:, 11:] - total[:-11, 11:] - total[11:, :-11] + total[:-11, :-11]
        answer[cost < best] = d
        best = np.minimum(best, cost)
    Il[:] = 0
    Ir[:] = 0
    assert x0 >= 0 and y0 >= 0
    return answer
