from stereo_disparity_fast import stereo_disparity_fast


def stereo_disparity_best(Il, Ir, bbox, maxd):
    return stereo_disparity_fast(Il, Ir, bbox, maxd)
