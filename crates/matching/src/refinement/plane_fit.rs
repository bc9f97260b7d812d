//! The plane that a pixel of a disparity map lies on.

use raster::Plane;

/// Half the window of a plane fit, in pixels, and the distance of its samples.
const FIT_RADIUS: usize = 20;
const FIT_STEP: usize = 2;
/// Pulls slopes of small supports towards zero: added to the variance of the columns.
const RIDGE: f32 = 5.0;
/// Samples farther from the plane than this do not count, in pixels.
const OUTLIER: f32 = 1.5;
/// A fit with less support keeps what it has.
const LEAST_SUPPORT: f32 = 5.0;

/// A plane through a pixel: its disparity there, and the change per column and per row.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Surface {
    pub disparity: f32,
    pub along: f32,
    pub down: f32,
}

impl Surface {
    /// The surface that pixel `(x, y)`, which must have a value, lies on: a plane is fitted to the
    /// disparities around it, four times, each time to those near the plane before (Tukey's
    /// biweight). NaN values do not count.
    pub fn fit(values: &Plane<f32>, x: usize, y: usize) -> Self {
        let (columns, rows) = values.size();
        let here = values.row(y)[x];
        let (mut along, mut down, mut offset) = (0.0f32, 0.0f32, 0.0f32);
        let start = |at: usize| at % FIT_STEP + (at - at % FIT_STEP).saturating_sub(FIT_RADIUS);
        for round in 0..4 {
            let (outlier, growth) =
                if round == 0 { (OUTLIER, 0.04) } else { (0.7 * OUTLIER, 0.01) };
            // Weighted sums of 1, x, y, z and of their products.
            let [mut s, mut sx, mut sy, mut sz] = [0.0f32; 4];
            let [mut sxx, mut sxy, mut syy, mut sxz, mut syz] = [0.0f32; 5];
            for v in (start(y)..=(y + FIT_RADIUS).min(rows - 1)).step_by(FIT_STEP) {
                let dy = v as f32 - y as f32;
                let row = values.row(v);
                for u in (start(x)..=(x + FIT_RADIUS).min(columns - 1)).step_by(FIT_STEP) {
                    let dx = u as f32 - x as f32;
                    let z = row[u] - here;
                    let off = (z - along * dx - down * dy - offset).abs();
                    let limit = outlier + growth * (dx.abs() + dy.abs());
                    // Also leaves out NaN.
                    if off < limit {
                        let w = 1.0 - (off / limit).powi(2);
                        let w = w * w;
                        s += w;
                        sx += w * dx;
                        sy += w * dy;
                        sz += w * z;
                        sxx += w * dx * dx;
                        sxy += w * dx * dy;
                        syy += w * dy * dy;
                        sxz += w * dx * z;
                        syz += w * dy * z;
                    }
                }
            }
            if s < LEAST_SUPPORT {
                break;
            }
            let (mx, my, mz) = (sx / s, sy / s, sz / s);
            let (xx, yy) = (sxx / s - mx * mx + RIDGE, syy / s - my * my + RIDGE);
            let (xy, xz, yz) = (sxy / s - mx * my, sxz / s - mx * mz, syz / s - my * mz);
            let determinant = xx * yy - xy * xy;
            along = (xz * yy - yz * xy) / determinant;
            down = (yz * xx - xz * xy) / determinant;
            offset = mz - along * mx - down * my;
        }
        Self { disparity: here + offset, along, down }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_beside_another_surface_and_among_holes() {
        // d = 9 + 0.1 x - 0.2 y, some of it missing; another object at 30 on the right.
        let plane = |x: usize, y: usize| 9.0 + 0.1 * x as f32 - 0.2 * y as f32;
        let values = Plane::from_fn(60, 40, |x, y| match (x, y) {
            (40.., _) => 30.0,
            _ if (x * 7 + y * 3) % 5 == 0 => f32::NAN,
            _ => plane(x, y),
        });
        let Surface { disparity, along, down } = Surface::fit(&values, 32, 21);
        assert!((disparity - plane(32, 21)).abs() < 0.1, "{disparity}");
        // A ridge pulls slopes towards zero by a few percent.
        assert!((along - 0.1).abs() < 0.02 && (down + 0.2).abs() < 0.02, "{along} {down}");
    }
}
