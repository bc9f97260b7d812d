//! What changes of disparity cost in an image: where it is noisy, or full of texture, its grey steps say less.

use raster::View;

use crate::Preset;
use crate::ingredient::{Ingredient, Ingredients};
use crate::optimization::semi_global::Penalties;
use crate::prepare::texture::{self, usual_step};
use crate::profile::Work;

/// In a clean image without much texture.
const BALANCED: Penalties = Penalties { p1: 10, p2: 45, p2_least: 8, fall: 240, ignored: 0 };
const BEST: Penalties = Penalties { p1: 14, p2: 60, p2_least: 20, fall: 96, ignored: 0 };
/// Grey steps of up to so many standard deviations of the noise say nothing; but texture is taken for
/// noise of up to this standard deviation where images are clean.
const STEPS_OF_NOISE: f32 = 3.0;
const LITTLE_NOISE: f32 = 3.3;
/// In `balanced`, whose P2 falls fast and far, gravel leaves no P2 anywhere and the paths follow nothing. So where
/// the usual step from one matched pixel to the next is above this many grey levels, steps up to so many times
/// what it exceeds them by say nothing.
const LITTLE_TEXTURE: f32 = 6.0;
const STEPS_OF_TEXTURE: f32 = 4.0;
/// And P2 falls less far: for each grey level above this many by so much, at most by so much.
const SOME_TEXTURE: f32 = 4.0;
const LESS_FAR: f32 = 4.0;
const LEAST_FAR: f32 = 24.0;

/// Those of `balanced` or `best` for a left image with noise of this standard deviation, whose matched pixels
/// are so many columns apart.
pub(super) fn penalties(
    preset: Preset,
    ingredients: Ingredients,
    grey: View<'_, u8>,
    noise: f32,
    apart: usize,
) -> (Penalties, Work) {
    let usual = if preset == Preset::Balanced { BALANCED } else { BEST };
    if !ingredients.has(Ingredient::AdaptiveP2) {
        return (Penalties { fall: 0, ..usual }, Work::default());
    }
    let of_noise = STEPS_OF_NOISE * (noise - LITTLE_NOISE).max(0.0);
    let (step, done) = match preset {
        Preset::Balanced => (usual_step(grey, apart), texture::work(grey)),
        _ => (0.0, Work::default()),
    };
    let of_texture = STEPS_OF_TEXTURE * (step - LITTLE_TEXTURE).max(0.0);
    let ignored = (of_noise + of_texture).round_ties_even() as u8;
    let raised = (LESS_FAR * (step - SOME_TEXTURE).max(0.0)).min(LEAST_FAR) as u8;
    (Penalties { ignored, p2_least: usual.p2_least + raised, ..usual }, done)
}

#[cfg(test)]
mod tests {
    use raster::Plane;

    use super::*;
    use crate::chance::Chance;
    use crate::prepare::noise::noise;

    /// A slope of grey with equally likely numbers up to `most` added.
    fn rough(most: f32) -> Plane<u8> {
        let mut chance = Chance(2);
        Plane::from_fn(90, 60, |x, _| (90.0 + x as f32 + most * chance.share()) as u8)
    }

    fn of(preset: Preset, most: f32, with_noise: bool) -> Penalties {
        let grey = rough(most);
        let noise = if with_noise { noise(grey.view()) } else { 0.0 };
        penalties(preset, Ingredients::of(preset, &[]), grey.view(), noise, 2).0
    }

    #[test]
    fn steps_of_grey_count_less_in_a_noisy_image_alone() {
        let with_noise = |most| of(Preset::Best, most, true);
        assert_eq!(with_noise(0.0), BEST);
        // A deviation of 3: what texture is taken for.
        assert_eq!(with_noise(10.0), BEST);
        // One of 17.
        let noisy = with_noise(60.0);
        assert!((30..=50).contains(&noisy.ignored), "{noisy:?}");
        assert_eq!(Penalties { ignored: 0, ..noisy }, BEST);
    }

    #[test]
    fn steps_of_gravel_count_less_in_balanced_alone() {
        let textured = |preset, most| of(preset, most, false);
        assert_eq!(textured(Preset::Balanced, 8.0), BALANCED);
        // Half of the steps are below 17.6.
        let gravel = textured(Preset::Balanced, 60.0);
        assert!((40..=56).contains(&gravel.ignored), "{gravel:?}");
        let least = BALANCED.p2_least + LEAST_FAR as u8;
        assert_eq!(Penalties { ignored: 0, ..gravel }, Penalties { p2_least: least, ..BALANCED });
        // Of 5 and a little more levels.
        let sand = textured(Preset::Balanced, 19.0);
        assert!((12..=16).contains(&sand.p2_least), "{sand:?}");
        assert_eq!(Penalties { p2_least: 8, ..sand }, BALANCED);
        assert_eq!(textured(Preset::Best, 60.0), BEST);
    }

    #[test]
    fn without_adaptive_p2_nothing_falls() {
        let grey = rough(60.0);
        for preset in [Preset::Balanced, Preset::Best] {
            let without = Ingredients::of(preset, &[Ingredient::AdaptiveP2]);
            assert_eq!(penalties(preset, without, grey.view(), 7.0, 2).0.fall, 0);
        }
    }
}
