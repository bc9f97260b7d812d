//! A fixed square window, by running sums.
//!
//! `C(x, y, d) = V(x - r, y, d) + ... + V(x + r, y, d)` over the columns that lie in the image,
//! where `V` are sums down the window's columns. From one column to the next one column enters and
//! one leaves: four operations per pixel and disparity for any window (McDonnell, *Box-Filtering
//! Techniques*, 1981).
//!
//! At the image's border the window is clipped: all disparities of a pixel are compared over the
//! same left pixels, so nothing needs to be normalised.

/// Sums column sums over the window. Columns `first ..= last` are answered, with `radius` more on
/// both sides as far as the image goes: `margin` of them before `first`.
pub(crate) fn sum_along_row(
    columns: &[u16],
    lanes: usize,
    margin: usize,
    radius: usize,
    running: &mut [u16],
    costs: &mut [u16],
) {
    let supplied = columns.len() / lanes;
    let column = |c: usize| &columns[c * lanes..][..lanes];
    running.fill(0);
    for c in 0..(margin + radius).min(supplied) {
        for (sum, &v) in running.iter_mut().zip(column(c)) {
            *sum += v;
        }
    }
    for (x, costs) in costs.chunks_exact_mut(lanes).enumerate() {
        let centre = margin + x;
        if centre + radius < supplied {
            for (sum, &v) in running.iter_mut().zip(column(centre + radius)) {
                *sum += v;
            }
        }
        costs.copy_from_slice(running);
        if centre >= radius {
            for (sum, &v) in running.iter_mut().zip(column(centre - radius)) {
                *sum -= v;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_sums_equal_the_naive_window_sum() {
        let (width, lanes) = (11, 16);
        let columns: Vec<u16> = (0..width * lanes).map(|i| (i * i % 97) as u16).collect();
        for (first, last) in [(0, 10), (2, 8), (5, 5), (0, 0), (10, 10)] {
            for radius in 0..14 {
                let (c0, c1) = (first.max(radius) - radius, (last + radius).min(width - 1));
                let mut costs = vec![0; (last - first + 1) * lanes];
                sum_along_row(
                    &columns[c0 * lanes..(c1 + 1) * lanes],
                    lanes,
                    first - c0,
                    radius,
                    &mut vec![0; lanes],
                    &mut costs,
                );
                for x in first..=last {
                    for k in 0..lanes {
                        let naive: u16 = (0..width)
                            .filter(|c| c.abs_diff(x) <= radius)
                            .map(|c| columns[c * lanes + k])
                            .sum();
                        assert_eq!(costs[(x - first) * lanes + k], naive, "x {x} radius {radius}");
                    }
                }
            }
        }
    }
}
