import numpy as np


def box_sum(image, half):
    """Sums over (2 half + 1)^2 windows, by an integral image; edges are repeated."""
    padded = np.pad(image, ((half + 1, half), (half + 1, half)), mode="edge")
    total = padded.cumsum(axis=0).cumsum(axis=1)
    size = 2 * half + 1
    return total[size:, size:] - total[:-size, size:] - total[size:, :-size] + total[:-size, :-size]


def costs(Il, Ir, maxd, half):
    """Yields the windowed absolute differences, one disparity after the other."""
    for d in range(maxd + 1):
        shifted = np.empty_like(Ir, dtype=np.float64)
        shifted[:, d:] = Ir[:, :Ir.shape[1] - d]
        shifted[:, :d] = Ir[:, :1]
        yield box_sum(np.abs(Il - shifted), half)


def stereo_disparity_fast(Il, Ir, bbox, maxd):
    best = np.full(Il.shape, np.inf)
    Id = np.zeros(Il.shape, dtype=np.int64)
    for d, cost in enumerate(costs(Il, Ir, maxd, 5)):
        better = cost < best
        best[better] = cost[better]
        Id[better] = d
    return Id
