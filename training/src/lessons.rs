//! Which pixels are learned from, and what is written of them.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use arena::dataset::CaseData;
use matching::MatchError;
use matching::training::{CANDIDATES, OF_EACH, OF_PIXEL, choices};
use raster::Plane;

use crate::random::Random;

/// Numbers of a pixel: its truth, how many pixels it stands for (in the mean 1), disparities, which of
/// them count, what is known of each, of the pixel.
pub const NUMBERS: usize = 2 + CANDIDATES * (2 + OF_EACH) + OF_PIXEL;

/// How much a pixel is wanted: more where the map is wrong and along edges, less where all is flat.
fn wanted(values: &Plane<f32>, truth: &Plane<f32>, x: usize, y: usize) -> f32 {
    let error = (values.row(y)[x] - truth.row(y)[x]).abs();
    if error.is_nan() {
        return 0.0;
    }
    let (columns, rows) = values.size();
    let near =
        |place: usize, end: usize| [place.saturating_sub(4), place, (place + 4).min(end - 1)];
    let around = near(y, rows).into_iter().flat_map(|v| near(x, columns).map(|u| (u, v)));
    let (least, most) = around.fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), (u, v)| {
        let value = values.row(v)[u];
        (least.min(value), most.max(value))
    });
    let wrong = if error > 1.0 { 4.0 } else { 1.0 };
    wrong
        * match most - least {
            step if step > 2.0 => 3.0,
            step if step < 0.5 => 0.2,
            _ => 1.0,
        }
}

/// About so many pixels of a pair: [`NUMBERS`] for each.
pub fn lesson(data: &CaseData, pixels: usize, seed: u64) -> Result<Vec<f32>, MatchError> {
    let truth = data.truth.clone().expect("scenes to learn from have truth");
    let chances = Arc::new(Mutex::new(HashMap::new()));
    let pick = {
        let (truth, chances) = (truth.clone(), Arc::clone(&chances));
        move |values: &Plane<f32>| {
            let wanted = Plane::from_fn(values.columns(), values.rows(), |x, y| {
                wanted(values, &truth, x, y)
            });
            let all: f64 = wanted.samples().iter().map(|&wanted| f64::from(wanted)).sum();
            let mut random = Random::new(seed);
            let mut chances = chances.lock().expect("nobody fails with it");
            for y in 0..values.rows() {
                for x in 0..values.columns() {
                    let chance = (pixels as f64 * f64::from(wanted.row(y)[x]) / all) as f32;
                    if random.unit() < chance {
                        chances.insert((x, y), chance.min(1.0));
                    }
                }
            }
            let mut places: Vec<_> = chances.keys().copied().collect();
            places.sort_unstable();
            places
        }
    };
    let known = choices(&data.left, &data.right, data.range, pick)?;
    let chances = chances.lock().expect("nobody fails with it");
    let mean: f32 = chances.values().map(|chance| 1.0 / chance).sum::<f32>() / chances.len() as f32;
    let mut numbers = Vec::with_capacity(known.len() * NUMBERS);
    for ((x, y), known) in known {
        numbers.extend([truth.row(y)[x], 1.0 / (chances[&(x, y)] * mean)]);
        numbers.extend(known.disparities);
        numbers.extend(known.inside.map(|inside| f32::from(u8::from(inside))));
        numbers.extend(known.of_each.iter().flatten());
        numbers.extend(known.of_pixel);
    }
    Ok(numbers)
}
