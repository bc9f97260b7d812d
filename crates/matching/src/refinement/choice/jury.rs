//! The judges of a preset, and how often they are asked.

use std::sync::LazyLock;

use super::judge::{Judge, Layers};
use super::reach::{NARROW, Reach, WIDE};
use crate::Preset;

/// Judges who look at the same candidates.
pub(crate) struct Jury {
    pub reach: &'static Reach,
    judges: Vec<Judge>,
    /// Where there are several, how often the last one is asked again.
    again: usize,
}

static BALANCED: LazyLock<Jury> = LazyLock::new(|| {
    Jury::new(&NARROW, Layers { first: 16, second: 8 }, include_bytes!("balanced.bin"), 1)
});
static BEST: LazyLock<Jury> = LazyLock::new(|| {
    Jury::new(&WIDE, Layers { first: 32, second: 16 }, include_bytes!("best.bin"), 0)
});

impl Jury {
    /// From the weights of the judges one after the other, 32-bit floats in the order of
    /// [`Judge::new`]. `training/choice.py` makes them.
    fn new(reach: &'static Reach, layers: Layers, trained: &[u8], again: usize) -> Self {
        let (numbers, rest) = trained.as_chunks();
        let judges = numbers.chunks_exact(Judge::numbers(reach, layers));
        let whole = rest.is_empty() && judges.remainder().is_empty();
        assert!(whole, "the weights are those of other layers: train the judges again");
        let judge = |numbers: &[[u8; 4]]| {
            Judge::new(reach, layers, numbers.iter().copied().map(f32::from_le_bytes))
        };
        Self { reach, judges: judges.map(judge).collect(), again }
    }

    /// That of `balanced`, or else that of `best`.
    pub fn of(preset: Preset) -> &'static Self {
        match preset {
            Preset::Balanced => &BALANCED,
            _ => &BEST,
        }
    }

    /// Who is asked in each round.
    pub fn rounds(&self) -> impl Iterator<Item = &Judge> {
        let again = if self.judges.len() > 1 { self.again } else { 0 };
        self.judges.iter().chain(std::iter::repeat_n(self.judges.last(), again).flatten())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_judge_has_a_round_and_the_last_one_of_balanced_another() {
        for (preset, judges, again) in [(Preset::Balanced, 2, 1), (Preset::Best, 6, 0)] {
            let rounds: Vec<&Judge> = Jury::of(preset).rounds().collect();
            assert_eq!(rounds.len(), judges + again, "{preset}");
            let others = rounds.windows(2).take(judges - 1);
            assert!(others.into_iter().all(|pair| !std::ptr::eq(pair[0], pair[1])));
            assert!(rounds[judges..].iter().all(|&judge| std::ptr::eq(judge, rounds[judges - 1])));
        }
    }
}
