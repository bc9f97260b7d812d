//! Where a map moved: who looks there has reason to be asked again.

use raster::Plane;
use rayon::prelude::*;

use super::reach::Reach;
use crate::kernels::level::{Level, at_every_level};
use crate::profile::Work;

/// By more than so many pixels of disparity.
const FAR: f32 = 2.0;

/// The pixels of a map that moved in a round: 1 for each, else 0.
#[derive(Default)]
pub(super) struct Moved(Plane<u8>);

impl Moved {
    /// What it takes for so many pixels.
    pub fn bytes(pixels: usize) -> usize {
        size_of::<u8>() * pixels
    }

    /// Compares a map with what it was before.
    pub fn find(&mut self, level: Level, before: &Plane<f32>, now: &Plane<f32>) -> Work {
        let (columns, rows) = now.size();
        self.0.reshape(columns, rows, 0);
        let found = self.0.samples_mut().par_chunks_mut(columns).enumerate();
        found.for_each(|(y, moved)| moved_in_row(level, before.row(y), now.row(y), moved));
        Work::bytes((2 * size_of::<f32>() + size_of::<u8>()) * columns * rows)
    }

    /// Marks the pixels of row `y` enough of whose candidates come from where the map moved, their own among
    /// these; says whether there are any. Places of the inner rings count twice. `counts` is scratch.
    pub fn seen_from(
        &self,
        level: Level,
        reach: &Reach,
        y: usize,
        counts: &mut [u8],
        marks: &mut [bool],
    ) -> bool {
        counts.fill(0);
        let columns = counts.len();
        for (k, place) in reach.places.iter().enumerate() {
            let weight = if k < reach.inner { 2 } else { 1 };
            let (first, Some(row)) = place.seen_from(0, y, self.0.rows()) else { continue };
            let moved = self.0.row(row);
            // Pixel `x` looks at column `first + x`.
            let shift = (first.unsigned_abs() as usize).min(columns);
            match first < 0 {
                true => count(level, weight, &moved[..columns - shift], &mut counts[shift..]),
                false => count(level, weight, &moved[shift..], &mut counts[..columns - shift]),
            }
        }
        let mut any = false;
        for (mark, &count) in marks.iter_mut().zip(&*counts) {
            *mark = count >= reach.moved;
            any |= *mark;
        }
        any
    }
}

at_every_level! {
    fn moved_in_row(before: &[f32], now: &[f32], moved: &mut [u8]) {
        for ((before, now), moved) in before.iter().zip(now).zip(moved) {
            *moved = u8::from((now - before).abs() > FAR);
        }
    }

    fn count(weight: u8, moved: &[u8], counts: &mut [u8]) {
        for (count, &moved) in counts.iter_mut().zip(moved) {
            *count += weight * moved;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reach::{NARROW, WIDE};
    use super::*;
    use crate::chance::Chance;

    #[test]
    fn those_are_marked_that_look_at_enough_places_that_moved() {
        for (columns, rows) in [(1, 1), (7, 60), (70, 9), (130, 70)] {
            let mut chance = Chance(5);
            let before = Plane::from_fn(columns, rows, |_, _| 50.0 * chance.share());
            let now = before.map(|&value| value + if chance.share() < 0.05 { 2.5 } else { 1.5 });
            for (level, reach) in
                Level::available().into_iter().flat_map(|level| [(level, &NARROW), (level, &WIDE)])
            {
                eprintln!("{columns} x {rows}, level {}", level.name());
                let (mut moved, mut marks) = (Moved::default(), vec![true; columns]);
                let mut counts = vec![9; columns];
                moved.find(level, &before, &now);
                for y in 0..rows {
                    let any = moved.seen_from(level, reach, y, &mut counts, &mut marks);
                    let looks_there = |x: usize| {
                        let places = reach.places.iter().enumerate();
                        let moved = places.filter(|(_, place)| {
                            let (u, v) = (
                                x as i64 + i64::from(place.columns),
                                y as i64 + i64::from(place.rows),
                            );
                            let inside =
                                (0..columns as i64).contains(&u) && (0..rows as i64).contains(&v);
                            inside
                                && now.row(v as usize)[u as usize]
                                    - before.row(v as usize)[u as usize]
                                    > 2.0
                        });
                        let counted: u8 = moved.map(|(k, _)| 1 + u8::from(k < reach.inner)).sum();
                        counted >= reach.moved
                    };
                    let expected: Vec<bool> = (0..columns).map(looks_there).collect();
                    assert_eq!(marks, expected, "row {y}");
                    assert_eq!(any, expected.contains(&true));
                }
            }
        }
    }
}
