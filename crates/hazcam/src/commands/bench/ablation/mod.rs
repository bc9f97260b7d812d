//! `hazcam bench --ablation`: what each ingredient of a preset gives, by leaving out one at a time.
//!
//! Here stand the variants that run as engines; [`table`] says what came of them.

mod table;

use anyhow::bail;
use arena::engine::{Definition, Engines};
use matching::{Ingredient, Preset};

pub use table::{legend, rows, table};

/// A preset, whole or without one of its ingredients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    preset: Preset,
    without: Option<Ingredient>,
}

impl Variant {
    /// The whole preset, then one variant for each ingredient.
    fn of(preset: Preset) -> impl Iterator<Item = Self> {
        let ingredients = Ingredient::of(preset).iter().copied().map(Some);
        [None].into_iter().chain(ingredients).map(move |without| Self { preset, without })
    }

    /// The engine's name.
    fn name(self) -> String {
        match self.without {
            None => self.preset.name().into(),
            Some(ingredient) => format!("{}-without-{ingredient}", self.preset),
        }
    }

    fn definition(self) -> Definition {
        let built_in = Engines::built_in();
        let whole = built_in.named(self.preset.name()).expect("every preset is an engine").clone();
        match self.without {
            None => whole,
            Some(ingredient) => Definition {
                name: self.name(),
                description: format!(
                    "{} without {ingredient}: {}",
                    self.preset,
                    ingredient.instead()
                ),
                command: [whole.command, vec!["--without".into(), ingredient.name().into()]]
                    .concat(),
                ..whole
            },
        }
    }
}

/// The engines to run for these presets, or for all that can be taken apart when there are none.
pub fn engines(presets: &[Preset]) -> anyhow::Result<Vec<Definition>> {
    if let Some(preset) = presets.iter().find(|preset| Ingredient::of(**preset).is_empty()) {
        bail!("nothing can be left out of `{preset}`: --ablation takes balanced and best");
    }
    let asked = |preset: &Preset| match presets {
        [] => !Ingredient::of(*preset).is_empty(),
        chosen => chosen.contains(preset),
    };
    let presets = Preset::ALL.into_iter().filter(asked);
    Ok(presets.flat_map(Variant::of).map(Variant::definition).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_preset_comes_first_then_each_ingredient_is_left_out() {
        let engines = engines(&[Preset::Balanced]).unwrap();
        assert_eq!(engines.len(), 1 + Ingredient::of(Preset::Balanced).len());
        assert_eq!(engines[0].name, "balanced");
        assert_eq!(engines[1].name, "balanced-without-vertical-alignment");
        let without = ["--without".to_owned(), "vertical-alignment".to_owned()];
        assert!(engines[1].command.ends_with(&without));
    }

    #[test]
    fn without_a_choice_all_that_can_be_taken_apart_are() {
        let all = engines(&[]).unwrap();
        assert_eq!(all, engines(&[Preset::Best, Preset::Balanced]).unwrap());
        assert!(engines(&[Preset::Fast]).is_err());
    }
}
