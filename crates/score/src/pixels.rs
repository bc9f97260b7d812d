//! The pixels that are scored: those of the region whose truth is known.

use raster::{BoundingBox, Plane};

use crate::{Region, ScoreError};

/// One scored pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
    /// The true disparity, finite.
    pub truth: f64,
    /// The estimated disparity, finite; `None` for a hole.
    pub estimate: Option<f64>,
}

impl Pixel {
    /// `estimate - truth`, or `None` for a hole.
    pub fn error(&self) -> Option<f64> {
        self.estimate.map(|estimate| estimate - self.truth)
    }
}

/// An estimate, a truth and a region that fit each other, with at least one pixel to score.
#[derive(Debug, Clone)]
pub struct Pixels<'a> {
    estimate: &'a Plane<f32>,
    truth: &'a Plane<f32>,
    mask: Option<&'a Plane<bool>>,
    bounds: BoundingBox,
    description: String,
    count: usize,
    holes: usize,
}

/// Errors unless `size` is the size of the estimate.
pub(crate) fn check_size(
    what: &'static str,
    (columns, rows): (usize, usize),
    estimate: &Plane<f32>,
) -> Result<(), ScoreError> {
    let (estimate_columns, estimate_rows) = estimate.size();
    if (columns, rows) == (estimate_columns, estimate_rows) {
        Ok(())
    } else {
        Err(ScoreError::SizesDiffer { what, columns, rows, estimate_columns, estimate_rows })
    }
}

impl<'a> Pixels<'a> {
    /// Checks that sizes agree, that the box lies inside, and that some truth is known there.
    pub fn select(
        estimate: &'a Plane<f32>,
        truth: &'a Plane<f32>,
        region: &Region<'a>,
    ) -> Result<Self, ScoreError> {
        check_size("truth", truth.size(), estimate)?;
        let mask = region.mask();
        if let Some(mask) = mask {
            check_size("mask", mask.size(), estimate)?;
        }
        let (columns, rows) = estimate.size();
        let description = region.describe();
        if columns == 0 || rows == 0 {
            return Err(ScoreError::NoTruth { region: description });
        }
        let bounds = region.bounds().unwrap_or(BoundingBox::whole(columns, rows));
        bounds.check_within(columns, rows)?;
        let mut this = Self { estimate, truth, mask, bounds, description, count: 0, holes: 0 };
        let (mut count, mut holes) = (0, 0);
        for pixel in this.iter() {
            count += 1;
            holes += usize::from(pixel.estimate.is_none());
        }
        (this.count, this.holes) = (count, holes);
        if count > 0 { Ok(this) } else { Err(ScoreError::NoTruth { region: this.description }) }
    }

    /// The scored pixels in row order.
    pub fn iter(&self) -> impl Iterator<Item = Pixel> + '_ {
        self.with_estimate(self.estimate)
    }

    /// The same pixels with another estimate of the same size.
    pub(crate) fn with_estimate<'b>(
        &'b self,
        estimate: &'b Plane<f32>,
    ) -> impl Iterator<Item = Pixel> + 'b {
        let BoundingBox { x0, y0, x1, y1 } = self.bounds;
        (y0..=y1).flat_map(move |y| {
            let truth = &self.truth.row(y)[x0..=x1];
            let estimate = &estimate.row(y)[x0..=x1];
            let mask = self.mask.map(|mask| &mask.row(y)[x0..=x1]);
            truth.iter().zip(estimate).enumerate().filter_map(move |(i, (&truth, &estimate))| {
                let scored = truth.is_finite() && mask.is_none_or(|mask| mask[i]);
                scored.then(|| Pixel {
                    x: x0 + i,
                    y,
                    truth: f64::from(truth),
                    estimate: estimate.is_finite().then_some(f64::from(estimate)),
                })
            })
        })
    }

    /// The errors of the pixels that have an estimate, in row order.
    pub fn errors(&self) -> impl Iterator<Item = f64> + '_ {
        self.iter().filter_map(|pixel| pixel.error())
    }

    /// How many pixels are scored, at least 1.
    pub fn count(&self) -> usize {
        self.count
    }

    /// How many of them have no estimate.
    pub fn holes(&self) -> usize {
        self.holes
    }

    /// The share of them that has an estimate.
    pub fn density(&self) -> f64 {
        (self.count - self.holes) as f64 / self.count as f64
    }

    /// The region in words.
    pub fn describe(&self) -> &str {
        &self.description
    }

    /// The map that is scored.
    pub(crate) fn estimate(&self) -> &'a Plane<f32> {
        self.estimate
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// One row of estimates against one row of truth.
    pub fn row(estimate: &[f32], truth: &[f32]) -> (Plane<f32>, Plane<f32>) {
        (
            Plane::new(estimate.len(), 1, estimate.to_vec()).unwrap(),
            Plane::new(truth.len(), 1, truth.to_vec()).unwrap(),
        )
    }

    #[test]
    fn only_known_truth_inside_box_and_mask_is_scored() {
        let truth = Plane::new(3, 2, vec![1.0, f32::NAN, 3.0, 4.0, f32::INFINITY, 6.0]).unwrap();
        let estimate = Plane::new(3, 2, vec![1.5, 2.0, f32::NAN, 4.0, 5.0, 6.0]).unwrap();
        let mask = Plane::new(3, 2, vec![true, true, true, false, true, true]).unwrap();
        let region = Region::masked("m", &mask);
        let pixels = Pixels::select(&estimate, &truth, &region).unwrap();
        let found: Vec<_> = pixels.iter().map(|p| (p.x, p.y, p.error())).collect();
        assert_eq!(found, [(0, 0, Some(0.5)), (2, 0, None), (2, 1, Some(0.0))]);
        assert_eq!((pixels.count(), pixels.holes()), (3, 1));

        let bounds = BoundingBox::new(1, 0, 2, 1).unwrap();
        let region = region.within(Some(bounds));
        assert_eq!(Pixels::select(&estimate, &truth, &region).unwrap().count(), 2);
    }

    #[test]
    fn what_cannot_be_scored_is_refused() {
        let (estimate, truth) = row(&[1.0, 2.0], &[f32::NAN, f32::INFINITY]);
        let whole = Region::whole();
        let error = Pixels::select(&estimate, &truth, &whole).unwrap_err();
        assert_eq!(error, ScoreError::NoTruth { region: "the whole image".into() });

        let small = Plane::filled(1, 1, 1.0);
        let error = Pixels::select(&estimate, &small, &whole).unwrap_err();
        assert!(error.to_string().starts_with("the truth is 1 x 1 but the estimate is 2 x 1"));

        let mask = Plane::filled(2, 2, true);
        let error = Pixels::select(&estimate, &estimate, &Region::masked("m", &mask)).unwrap_err();
        assert!(error.to_string().starts_with("the mask is 2 x 2"));

        let outside = whole.clone().within(Some(BoundingBox::new(0, 0, 2, 0).unwrap()));
        let error = Pixels::select(&estimate, &estimate, &outside).unwrap_err();
        assert!(matches!(error, ScoreError::Bounds(_)));

        let empty = Plane::filled(0, 0, 1.0);
        assert!(Pixels::select(&empty, &empty, &whole).is_err());
    }
}
