import sys

import numpy as np

print("imported")
print('{"hazcam":"done","job":1}')


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    print("shape", Il.shape, "box", bbox)
    best = np.full(Il.shape, np.inf)
    Id = np.zeros(Il.shape)
    for d in range(maxd + 1):
        print("disparity", d, file=sys.stderr)
        difference = np.abs(Il - np.roll(Ir, d, axis=1))
        cost = difference.copy()
        for k in range(1, 6):
            cost += np.roll(difference, k, 1) + np.roll(difference, -k, 1)
        rows = cost.copy()
        for k in range(1, 6):
            rows += np.roll(cost, k, 0) + np.roll(cost, -k, 0)
        Id[rows < best] = d
        best = np.minimum(best, rows)
    print("\x1b[2Jdone", "x" * 5000)
    return Id
