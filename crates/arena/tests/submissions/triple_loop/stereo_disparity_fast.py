import numpy as np


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    """Sum of absolute differences over a window, pixel by pixel, in plain loops."""
    rows, columns = Il.shape
    Id = np.zeros((rows, columns))
    half = 3
    for y in range(bbox[1, 0], bbox[1, 1] + 1):
        y0, y1 = max(0, y - half), min(rows, y + half + 1)
        for x in range(bbox[0, 0], bbox[0, 1] + 1):
            left, right = min(half, x), min(half, columns - 1 - x)
            window = Il[y0:y1, x - left:x + right + 1]
            best, best_cost = 0, float("inf")
            for d in range(0, maxd + 1):
                if x - d - left < 0:
                    break
                other = Ir[y0:y1, x - d - left:x - d + right + 1]
                cost = np.sum(np.abs(window - other))
                if cost < best_cost:
                    best, best_cost = d, cost
            Id[y, x] = best
    return Id
