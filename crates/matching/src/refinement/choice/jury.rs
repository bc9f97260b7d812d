//! The judges of a preset: one for each round.

use std::sync::LazyLock;

use super::judge::{Judge, Layers};
use super::reach::{NARROW, Reach, WIDE};
use crate::Preset;

/// Judges who look at the same candidates.
pub(crate) struct Jury {
    pub reach: &'static Reach,
    /// One for each round.
    pub judges: Vec<Judge>,
}

static BALANCED: LazyLock<Jury> = LazyLock::new(|| {
    let plain = Layers { context: 0, first: 16, second: 8 };
    Jury::new(&NARROW, &[plain], include_bytes!("balanced.bin"))
});
static BEST: LazyLock<Jury> = LazyLock::new(|| {
    let plain = Layers { context: 0, first: 32, second: 16 };
    Jury::new(&WIDE, &[Layers { context: 32, ..plain }, plain], include_bytes!("best.bin"))
});

impl Jury {
    /// From the weights of the judges one after the other, 32-bit floats in the order of [`Judge::new`]; networks
    /// of these layers take turns. `training/choice.py` makes them.
    fn new(reach: &'static Reach, layers: &[Layers], trained: &[u8]) -> Self {
        let other = "the weights are those of other layers: train the judges again";
        let (mut numbers, rest) = trained.as_chunks();
        assert!(rest.is_empty(), "{other}");
        let (mut judges, mut turns) = (Vec::new(), layers.iter().cycle());
        while let (false, Some(&layers)) = (numbers.is_empty(), turns.next()) {
            let own = numbers.split_off(..Judge::numbers(reach, layers)).expect(other);
            judges.push(Judge::new(reach, layers, own.iter().copied().map(f32::from_le_bytes)));
        }
        Self { reach, judges }
    }

    /// That of `balanced`, or else that of `best`.
    pub fn of(preset: Preset) -> &'static Self {
        match preset {
            Preset::Balanced => &BALANCED,
            _ => &BEST,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_round_has_a_judge_of_its_own() {
        for (preset, judges) in [(Preset::Balanced, 5), (Preset::Best, 6)] {
            let found = &Jury::of(preset).judges;
            assert_eq!(found.len(), judges, "{preset}");
            for (i, judge) in found.iter().enumerate() {
                assert!(!found[..i].contains(judge), "{preset}, round {i}");
            }
        }
    }
}
