//! The judges of a preset: one for each round of choices.

use std::sync::LazyLock;

use super::judge::{Judge, Layers};
use super::reach::{NARROW, Reach, WIDE};
use crate::Preset;

/// Judges who look at the same candidates.
pub(crate) struct Jury {
    pub reach: &'static Reach,
    judges: Vec<Judge>,
}

static BALANCED: LazyLock<Jury> = LazyLock::new(|| {
    Jury::new(&NARROW, Layers { first: 16, second: 8 }, include_bytes!("balanced.bin"))
});
static BEST: LazyLock<Jury> = LazyLock::new(|| {
    Jury::new(&WIDE, Layers { first: 32, second: 16 }, include_bytes!("best.bin"))
});

impl Jury {
    /// From the weights of the judges one after the other, 32-bit floats in the order of
    /// [`Judge::new`]. `training/choice.py` makes them.
    fn new(reach: &'static Reach, layers: Layers, trained: &[u8]) -> Self {
        let (numbers, rest) = trained.as_chunks();
        let judges = numbers.chunks_exact(Judge::numbers(reach, layers));
        let whole = rest.is_empty() && judges.remainder().is_empty();
        assert!(whole, "the weights are those of other layers: train the judges again");
        let judge = |numbers: &[[u8; 4]]| {
            Judge::new(reach, layers, numbers.iter().copied().map(f32::from_le_bytes))
        };
        Self { reach, judges: judges.map(judge).collect() }
    }

    /// That of `balanced`, or else that of `best`.
    pub fn of(preset: Preset) -> &'static Self {
        match preset {
            Preset::Balanced => &BALANCED,
            _ => &BEST,
        }
    }

    /// The judges, with or without those after the first.
    pub fn judges(&self, with_last: bool) -> &[Judge] {
        let judges = if with_last { self.judges.len() } else { self.judges.len().min(1) };
        &self.judges[..judges]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_round_has_its_judge() {
        let rounds = [Preset::Balanced, Preset::Best].map(|p| Jury::of(p).judges(true).len());
        assert_eq!(rounds, [1, 2], "the files of weights are not whole");
    }
}
