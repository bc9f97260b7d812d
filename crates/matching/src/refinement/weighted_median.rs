//! A median whose votes count by likeness: edges of the map move to the edges of the image.
//!
//! Every pixel of a square window votes for its disparity with the weight
//! `exp(-|dI| / SHADE) exp(-distance / radius)`, less when it was filled; the weighted median wins
//! (Ma et al., *Constant time weighted median filtering for stereo matching and beyond*, ICCV 2013).

use raster::{Plane, Reason};
use rayon::prelude::*;

/// A grey step at which a vote counts 1/e.
const SHADE: f32 = 10.0;
/// What the vote of a filled pixel counts.
const FILLED: f32 = 0.3;

/// Filters `values` into `out`; `guide` has their size, 0 to 255.
pub(crate) fn weighted_median(
    values: &Plane<f32>,
    reasons: &Plane<Reason>,
    guide: &Plane<u8>,
    radius: usize,
    out: &mut Plane<f32>,
) {
    let (columns, rows) = values.size();
    out.reset(columns, rows, 0.0);
    let shade: Vec<f32> = (0..256).map(|step| (-(step as f32) / SHADE).exp()).collect();
    let near: Vec<f32> = (0..=2 * radius * radius)
        .map(|square| (-(square as f32).sqrt() / radius as f32).exp())
        .collect();
    out.samples_mut().par_chunks_mut(columns).enumerate().for_each_init(
        Vec::new,
        |votes, (y, row)| {
            for (x, result) in row.iter_mut().enumerate() {
                votes.clear();
                let here = guide.row(y)[x];
                let mut total = 0.0;
                for v in y.saturating_sub(radius)..=(y + radius).min(rows - 1) {
                    let (values, reasons, guide) = (values.row(v), reasons.row(v), guide.row(v));
                    for u in x.saturating_sub(radius)..=(x + radius).min(columns - 1) {
                        let trust = if reasons[u] == Reason::Matched { 1.0 } else { FILLED };
                        let square = u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2);
                        let weight =
                            trust * shade[usize::from(guide[u].abs_diff(here))] * near[square];
                        votes.push((values[u], weight));
                        total += weight;
                    }
                }
                votes.sort_unstable_by(|a: &(f32, f32), b| a.0.total_cmp(&b.0));
                let mut sum = 0.0;
                let middle = votes.iter().find(|vote| {
                    sum += vote.1;
                    sum >= 0.5 * total
                });
                *result = middle.map_or(values.row(y)[x], |vote| vote.0);
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_of_the_map_moves_to_the_edge_of_the_image() {
        // The image has its edge at column 10, the map at column 12: fattened by two.
        let guide = Plane::from_fn(20, 9, |x, _| if x < 10 { 40 } else { 200 });
        let values = Plane::from_fn(20, 9, |x, _| if x < 12 { 8.0 } else { 3.0 });
        let reasons = Plane::filled(20, 9, Reason::Matched);
        let mut out = Plane::default();
        weighted_median(&values, &reasons, &guide, 6, &mut out);
        assert_eq!((out.row(4)[9], out.row(4)[10]), (8.0, 3.0));
    }
}
