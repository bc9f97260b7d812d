//! How much the grey of an image usually changes from pixel to pixel: what is usual there says nothing of depth.

use raster::View;

use super::histogram::quantile;
use crate::profile::Work;

/// Every so many-th row, and of it every other column, is looked at.
const EVERY: usize = 4;

/// What [`usual_step`] does: rows are read, and half of the samples compared and counted.
pub(crate) fn work(grey: View<'_, u8>) -> Work {
    let looked_at = grey.columns() * grey.rows() / EVERY;
    Work::bytes(looked_at) + Work::operations(2) * (looked_at / 2)
}

/// The median of the differences, in grey levels, between pixels so many columns apart: half of them differ by
/// less. 0 where there are no such pixels.
pub(crate) fn usual_step(grey: View<'_, u8>, apart: usize) -> f32 {
    let mut pairs_with = [0u32; 256];
    for y in (0..grey.rows()).step_by(EVERY) {
        let row = grey.row(y);
        let others = row.get(apart..).unwrap_or_default();
        for (&here, &there) in row.iter().zip(others).step_by(2) {
            pairs_with[usize::from(here.abs_diff(there))] += 1;
        }
    }
    quantile(&pairs_with, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;

    #[test]
    fn the_median_step_of_a_ramp_is_its_slope() {
        for (slope, apart) in [(1, 1), (2, 1), (3, 2)] {
            let ramp = Plane::from_fn(60, 9, |x, _| (slope * x) as u8);
            assert_eq!(usual_step(ramp.view(), apart), (slope * apart) as f32);
        }
    }

    #[test]
    fn few_large_steps_are_not_usual() {
        // Every tenth column is a bright line.
        let lines = Plane::from_fn(200, 40, |x, _| if x % 10 == 5 { 200 } else { 20 });
        assert!(usual_step(lines.view(), 1) < 0.5);
        // Of gravel, half of the differences of equally likely numbers below 100 are below 29.3.
        let mut chance = crate::chance::Chance(4);
        let gravel = Plane::from_fn(400, 400, |_, _| (100.0 * chance.share()) as u8);
        let usual = usual_step(gravel.view(), 2);
        assert!((28.0..31.0).contains(&usual), "{usual}");
    }

    #[test]
    fn where_there_are_no_two_columns_there_is_no_step() {
        for size in [(1, 1), (2, 1), (1, 30)] {
            assert_eq!(usual_step(Plane::filled(size.0, size.1, 9).view(), 2), 0.0);
        }
    }
}
