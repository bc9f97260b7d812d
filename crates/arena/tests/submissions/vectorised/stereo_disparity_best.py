import numpy as np

from stereo_disparity_fast import costs


def winners(Il, Ir, maxd, half):
    volume = np.stack(list(costs(Il, Ir, maxd, half))).astype(np.float32)
    return volume.argmin(axis=0)


def stereo_disparity_best(Il, Ir, bbox, maxd):
    """Windowed differences from both sides; where they disagree, the lower neighbour in the row."""
    left = winners(Il, Ir, maxd, 4)
    right = winners(Ir[:, ::-1], Il[:, ::-1], maxd, 4)[:, ::-1]
    columns = np.arange(Il.shape[1])[None, :]
    there = np.take_along_axis(right, np.maximum(columns - left, 0), axis=1)
    known = np.abs(there - left) <= 1
    Id = left.astype(np.float32)
    for y in range(bbox[1][0], bbox[1][1] + 1):
        good = np.flatnonzero(known[y])
        if good.size == 0:
            continue
        at = np.searchsorted(good, np.arange(Il.shape[1]))
        before = Id[y, good[np.maximum(at - 1, 0)]]
        after = Id[y, good[np.minimum(at, good.size - 1)]]
        Id[y] = np.where(known[y], Id[y], np.minimum(before, after))
    return Id
