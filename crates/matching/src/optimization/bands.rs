//! How semi-global matching keeps its memory bounded: detours in bands of rows.
//!
//! Two sweeps meet in the middle, so each half of the image is crossed twice: first by the sweep that
//! begins there, then, from the middle back to its border, by the other. What the first found has to
//! be there when the second comes. Either the detours of all of its paths are kept; or they are made
//! again, for one band of rows after the other, from *checkpoints*: the states of the paths at a row,
//! which are far less than the detours of all rows up to the next checkpoint. The arithmetic is the
//! same, so are the bits.
//!
//! A checkpoint is as large as three rows of detours. With `n` rows in a half, a checkpoint every `b`
//! rows and the detours of one band of `b` rows take memory for `3 n / b + b` rows instead of `n`, and
//! the first sweep is done once more. With a second spacing (a checkpoint every `s` rows; inside of
//! such a stretch, while it is crossed, every `b` rows) it is `3 n / s + 3 s / b + b` rows, and the
//! sweep is done twice more: instead of two sweeps over every row there are three, or four. A whole
//! volume is one stretch with one band. (Griewank 1992 trades time for memory in this way where
//! programs are differentiated in reverse.)
//!
//! Rows of the band that the first sweep ends with are not done again, so of all plans that there is memory
//! for the one with the fewest rows to sweep is taken, most often that with the longest bands.

use crate::kernels::path::RowStates;

/// Rows between two checkpoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Bands {
    /// In a half: the length of a stretch, and of a band, of which the detours are kept.
    spacings: [usize; 2],
}

/// The size of a volume of costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Volume {
    pub columns: usize,
    pub rows: usize,
    /// Disparities, in whole groups.
    pub lanes: usize,
}

impl Volume {
    /// Rows of the larger half.
    fn half(&self) -> usize {
        self.rows.div_ceil(2)
    }
}

impl Bands {
    /// Every `stretch` and every `height` rows.
    pub fn new(stretch: usize, height: usize) -> Self {
        Self { spacings: [stretch, height] }
    }

    /// The plan that sweeps the fewest rows of those that fit; the one with the least memory if none does.
    pub fn within(volume: &Volume, fits: impl Fn(Self) -> bool) -> Self {
        let half = volume.half();
        let whole = Self::new(half, half);
        if fits(whole) {
            return whole;
        }
        // At this stretch 3 n / s + 3 s / b is least.
        let stretch = |height: usize| (half * height).isqrt().max(height);
        let plans = (1..=half)
            .flat_map(|height| [half, stretch(height)].map(|stretch| Self::new(stretch, height)));
        let fitting = plans.clone().filter(|&plan| fits(plan));
        let fastest = fitting.min_by_key(|plan| (plan.swept(half), plan.bytes(volume)));
        let least = || plans.min_by_key(|plan| plan.bytes(volume)).expect("there are several");
        fastest.unwrap_or_else(least)
    }

    /// The plan with the least memory.
    pub fn least(volume: &Volume) -> Self {
        Self::within(volume, |_| false)
    }

    /// Rows of a band.
    pub fn height(&self) -> usize {
        self.spacings[1]
    }

    /// How far to go to the next checkpoint with `left` rows ahead; none when their detours are
    /// to be kept. The first step is the one that may be short: the last rows, which are not done again, are a
    /// whole band.
    pub fn next(&self, left: usize) -> Option<usize> {
        let spacing = self.spacings.into_iter().find(|&spacing| left > spacing)?;
        Some((left - 1) % spacing + 1)
    }

    /// How many rows are done by the first sweep over a half of `rows` rows, those that are done again
    /// included.
    pub fn swept(&self, rows: usize) -> usize {
        let (mut swept, mut left) = (rows, rows);
        while let Some(spacing) = self.next(left) {
            swept += self.swept(spacing);
            left -= spacing;
        }
        swept
    }

    /// Checkpoints that are kept at the same time in a half of `rows` rows.
    pub fn checkpoints(&self, rows: usize) -> usize {
        let [stretch, height] = self.spacings;
        let between = |rows: usize, spacing: usize| rows.div_ceil(spacing).saturating_sub(1);
        between(rows, stretch) + between(rows.min(stretch), height)
    }

    /// The memory of detours and checkpoints, in both halves.
    pub fn bytes(&self, volume: &Volume) -> usize {
        let &Volume { columns, rows, lanes } = volume;
        let half = |rows: usize| {
            let detours = self.height().min(rows) * columns * lanes;
            detours + self.checkpoints(rows) * RowStates::saved_bytes(columns, lanes)
        };
        half(rows / 2) + half(volume.half())
    }
}

/// The states of a sweep at some of its steps: the last saved is the first to be taken up again.
#[derive(Default)]
pub(crate) struct Checkpoints {
    steps: Vec<usize>,
    states: Vec<u8>,
}

impl Checkpoints {
    /// Forgets all, and makes room for as many as there will be.
    pub fn reset(&mut self, count: usize, columns: usize, lanes: usize) {
        self.steps.clear();
        self.steps.reserve_exact(count);
        self.states.clear();
        self.states.reserve_exact(count * RowStates::saved_bytes(columns, lanes));
    }

    /// Saves the states before `step`.
    pub fn push(&mut self, step: usize, states: &RowStates) {
        self.steps.push(step);
        states.save(&mut self.states);
    }

    /// Takes the last states back, and says before which step they were.
    pub fn pop(&mut self, states: &mut RowStates) -> Option<usize> {
        let step = self.steps.pop()?;
        let start = self.states.len() / (self.steps.len() + 1) * self.steps.len();
        states.restore(&self.states[start..]);
        self.states.truncate(start);
        Some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn less_memory_costs_more_sweeps_and_grows_slower_than_the_rows() {
        let volume = |rows| Volume { columns: 3000, rows, lanes: 256 };
        let of =
            |limit, rows| Bands::within(&volume(rows), |bands| bands.bytes(&volume(rows)) <= limit);
        let megabytes = |bands: Bands, rows| bands.bytes(&volume(rows)) / 1_000_000;
        let whole = of(usize::MAX, 2000);
        assert_eq!((whole, megabytes(whole, 2000)), (Bands::new(1000, 1000), 1536));
        let one_level = of(200_000_000, 2000);
        assert_eq!((one_level, megabytes(one_level, 2000)), (Bands::new(1000, 103), 199));
        let two_levels = of(150_000_000, 2000);
        assert_eq!((two_levels, megabytes(two_levels, 2000)), (Bands::new(281, 79), 149));
        let least = Bands::least(&volume(2000));
        assert_eq!((least, megabytes(least, 2000)), (Bands::new(144, 21), 87));
        let swept = [whole, one_level, two_levels, least].map(|bands| bands.swept(1000));
        assert_eq!(swept, [1000, 1897, 2403, 2709]);
        // Eight times the rows, twice the memory.
        assert_eq!(megabytes(Bands::least(&volume(16_000)), 16_000), 183);
    }

    #[test]
    fn every_level_of_checkpoints_sweeps_nearly_all_rows_once_more() {
        let swept = |stretch, height| Bands::new(stretch, height).swept(100);
        // The detours of the last band are held at once. With stretches of 50, the first is swept again,
        // and of both all but the last band once more.
        assert_eq!([swept(100, 100), swept(100, 10), swept(50, 10)], [100, 190, 230]);
    }

    #[test]
    fn a_volume_of_one_row_has_nothing_to_split() {
        for rows in 1..4 {
            let bands = Bands::least(&Volume { columns: 5, rows, lanes: 32 });
            assert_eq!(bands.checkpoints(1), 0, "{rows}: {bands:?}");
        }
    }
}
