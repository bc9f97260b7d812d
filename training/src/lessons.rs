//! Which pixels are learned from, and what is written of them.

use arena::dataset::CaseData;
use matching::training::{Pixel, choices};
use matching::{MatchError, Preset};
use raster::Plane;
use scenes::Random;

/// How much a pixel of a map is wanted, which is every so many-th one of the truth: more where the map is wrong and
/// along edges, less where all is flat.
fn wanted(values: &Plane<f32>, every: usize, truth: &Plane<f32>, x: usize, y: usize) -> f64 {
    let error = (values.row(y)[x] - truth.row(every * y)[every * x]).abs();
    if error.is_nan() {
        return 0.0;
    }
    let (columns, rows) = values.size();
    let far = 4 / every;
    let near =
        |place: usize, end: usize| [place.saturating_sub(far), place, (place + far).min(end - 1)];
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

/// About so many pixels by chance, the more wanted ones more often, of a map of every so many-th pixel; each
/// stands for as many as its chance says, in the mean for one.
fn picked(
    (values, every): (&Plane<f32>, usize),
    truth: &Plane<f32>,
    pixels: usize,
    random: &mut Random,
) -> Vec<Pixel> {
    let (columns, rows) = values.size();
    let places = || (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let all: f64 = places().map(|(column, row)| wanted(values, every, truth, column, row)).sum();
    let mut picked = Vec::new();
    for (column, row) in places() {
        let chance = pixels as f64 * wanted(values, every, truth, column, row) / all;
        if random.chance(chance) {
            let [column, row] = [column, row].map(|place| every * place);
            picked.push(Pixel { column, row, weight: 1.0 / chance.min(1.0) as f32 });
        }
    }
    let mean = picked.iter().map(|pixel| pixel.weight).sum::<f32>() / picked.len() as f32;
    picked.iter_mut().for_each(|pixel| pixel.weight /= mean);
    picked
}

/// What is learned from about so many pixels of a pair. Each is so many numbers: its truth, how many
/// pixels it stands for (in the mean of those picked 1), disparities, which of them count, what is
/// known of each, of the pixel.
pub fn lesson(
    preset: Preset,
    data: &CaseData,
    pixels: usize,
    mut random: Random,
) -> Result<Vec<Vec<f32>>, MatchError> {
    let truth = data.truth.as_ref().expect("scenes to learn from have truth");
    let pick = {
        let truth = truth.clone();
        move |values: &Plane<f32>, every: usize| {
            picked((values, every), &truth, pixels, &mut random)
        }
    };
    let known = choices(preset, &data.left, &data.right, data.range, pick)?;
    let numbers = known.into_iter().map(|(Pixel { column, row, weight }, known)| {
        let mut numbers = vec![truth.row(row)[column], weight];
        numbers.extend(known.disparities);
        numbers.extend(known.inside.iter().map(|&inside| f32::from(u8::from(inside))));
        numbers.extend(known.of_each.iter().flatten());
        numbers.extend(known.of_pixel);
        numbers
    });
    Ok(numbers.collect())
}
