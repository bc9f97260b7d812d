//! Where only every so many-th pixel of the matched rows is asked, these are all that rounds look at.

use raster::{Plane, Reason, View};
use rayon::prelude::*;

use super::between::follow;
use super::block::Given;
use super::rounds::Map;
use crate::kernels::level::Level;
use crate::profile::Work;

/// Takes every so many-th sample of the first rows of a view from a column on: so many columns and rows.
pub(super) fn take_every<T: Copy + Default + Send + Sync>(
    every: usize,
    from: View<'_, T>,
    first: usize,
    (columns, rows): (usize, usize),
    out: &mut Plane<T>,
) -> Work {
    out.reshape(columns, rows, T::default());
    let lines = out.samples_mut().par_chunks_mut(columns).enumerate();
    lines.for_each(|(y, out)| {
        let row = &from.row(y)[first..];
        match every {
            // In one go.
            1 => out.copy_from_slice(&row[..columns]),
            // Whole pairs become vectors; the last one may lack its second sample.
            2 => {
                let pairs = row.as_chunks::<2>().0;
                out.iter_mut().zip(pairs).for_each(|(out, pair)| *out = pair[0]);
                out[columns - 1] = row[2 * (columns - 1)];
            }
            _ => unreachable!("every pixel is asked, or every second one"),
        }
    });
    Work::bytes(2 * size_of_val(out.samples()))
}

/// Every so many-th pixel of the rows of a map, and what it says of all of them at the end.
#[derive(Default)]
pub(super) struct Sparse {
    values: Plane<f32>,
    other: Plane<f32>,
    reasons: Plane<Reason>,
    /// How sure all pixels are.
    certainty: Plane<u8>,
}

impl Sparse {
    /// What it takes where so many pixels are asked of a map of so many.
    pub fn bytes(asked: usize, pixels: usize) -> usize {
        let pixel = 2 * size_of::<f32>() + size_of::<Reason>();
        pixel * asked + size_of::<u8>() * pixels
    }

    /// Takes the pixels that are asked.
    pub fn take(&mut self, every: usize, values: &Plane<f32>, reasons: &Plane<Reason>) -> Work {
        let size = (values.columns().div_ceil(every), values.rows());
        take_every(every, values.view(), 0, size, &mut self.values)
            + take_every(every, reasons.view(), 0, size, &mut self.reasons)
    }

    /// The map of the pixels that are asked.
    pub fn map(&mut self) -> Map<'_> {
        let Self { values, other, reasons, .. } = self;
        Map { values, other, reasons }
    }

    /// Lets the others, which had the disparities `before`, follow those that were asked, into `out`.
    pub fn follow(
        &mut self,
        level: Level,
        every: usize,
        given: &Given<'_>,
        before: &Plane<f32>,
        certainty: &Plane<u8>,
        out: &mut Plane<f32>,
    ) -> Work {
        let (columns, rows) = before.size();
        out.reshape(columns, rows, 0.0);
        self.certainty.reshape(columns, rows, 0);
        follow(level, every, given, before, (&self.values, certainty), &mut self.certainty, out)
    }

    /// How sure all pixels are, in bytes.
    pub fn told(&self) -> &[u8] {
        self.certainty.samples()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_taken_from_a_column_on() {
        let image = Plane::from_fn(9, 6, |x, y| (10 * y + x) as u8);
        let mut out = Plane::default();
        take_every(2, image.view(), 2, (4, 2), &mut out);
        assert_eq!(out.size(), (4, 2));
        assert_eq!(out.samples(), [2, 4, 6, 8, 12, 14, 16, 18]);
        take_every(1, image.view(), 7, (2, 2), &mut out);
        assert_eq!(out.samples(), [7, 8, 17, 18]);
    }

    #[test]
    fn where_nobody_chose_the_map_stays() {
        for (columns, rows) in [(1, 1), (2, 3), (71, 8), (130, 5)] {
            let values = Plane::from_fn(columns, rows, |x, y| (x * x % 17 + y) as f32);
            // Every second row of the image is matched.
            let grey = Plane::from_fn(columns, 2 * rows, |x, y| 5 * values.row(y / 2)[x] as u8);
            let reasons = values.map(|_| Reason::Matched);
            let given = Given {
                doubtful: &Plane::default(),
                grey: [grey.view(); 2],
                right: &values,
                first: 0,
                top: 0,
                least: 0.0,
                most: 60.0,
            };
            let mut sparse = Sparse::default();
            sparse.take(2, &values, &reasons);
            let certainty = sparse.values.map(|_| 77);
            let mut out = Plane::default();
            sparse.follow(Level::detect(), 2, &given, &values, &certainty, &mut out);
            assert!(out == values, "{columns} x {rows}");
            assert!(sparse.told().iter().all(|&told| told == 77));
        }
    }
}
