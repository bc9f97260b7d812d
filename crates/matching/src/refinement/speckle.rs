//! Speckles: small islands of disparity that stand alone are seldom real.
//!
//! Neighbours (above, below, left, right) whose disparities differ by at most `step` belong
//! together; groups of fewer than `least` pixels become mismatched holes (Hirschmueller 2008,
//! section 2.5).

use raster::{Plane, Reason};

/// Scratch memory, kept between frames.
#[derive(Default)]
pub(crate) struct Speckles {
    seen: Vec<bool>,
    group: Vec<usize>,
}

impl Speckles {
    /// Makes holes of small groups: values NaN, reasons [`Reason::MismatchedHole`].
    pub fn remove(
        &mut self,
        values: &mut Plane<f32>,
        reasons: &mut Plane<Reason>,
        least: usize,
        step: f32,
    ) {
        let (columns, rows) = values.size();
        let (values, reasons) = (values.samples_mut(), reasons.samples_mut());
        self.seen.clear();
        self.seen.extend(values.iter().map(|v| v.is_nan()));
        for start in 0..values.len() {
            if self.seen[start] {
                continue;
            }
            self.seen[start] = true;
            self.group.clear();
            self.group.push(start);
            let mut next = 0;
            while let Some(&at) = self.group.get(next) {
                next += 1;
                let (x, y) = (at % columns, at / columns);
                let neighbours = [
                    (x > 0).then(|| at - 1),
                    (x + 1 < columns).then_some(at + 1),
                    (y > 0).then(|| at - columns),
                    (y + 1 < rows).then_some(at + columns),
                ];
                for to in neighbours.into_iter().flatten() {
                    if !self.seen[to] && (values[to] - values[at]).abs() <= step {
                        self.seen[to] = true;
                        self.group.push(to);
                    }
                }
            }
            if self.group.len() < least {
                for &at in &self.group {
                    values[at] = f32::NAN;
                    reasons[at] = Reason::MismatchedHole;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_island_goes_and_a_slope_stays() {
        // A slope of one per pixel is one group; the lone 40 is an island of one.
        let mut values = Plane::from_fn(6, 2, |x, _| x as f32);
        values.row_mut(0)[3] = 40.0;
        let mut reasons = Plane::filled(6, 2, Reason::Matched);
        Speckles::default().remove(&mut values, &mut reasons, 4, 1.0);
        assert!(values.row(0)[3].is_nan());
        assert_eq!(reasons.row(0)[3], Reason::MismatchedHole);
        assert_eq!(values.samples().iter().filter(|v| v.is_nan()).count(), 1);
    }
}
