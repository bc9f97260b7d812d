//! When tests are the same: what is asked, and of which pixels.

use raster::Image;
use sha2::{Digest, Sha256};

use crate::grade::{Scene, Test};
use crate::hexadecimal;

/// The SHA-256 of tests, and of every pixel of their images and truths.
pub(super) fn fingerprint(tests: &[(Test, &Scene)]) -> String {
    let mut hash = Sha256::new();
    for (test, scene) in tests {
        hash.update(serde_json::to_vec(test).expect("a test is plain data"));
        let bounds = scene.bounds;
        for number in [bounds.x0, bounds.y0, bounds.x1, bounds.y1] {
            hash.update((number as u64).to_le_bytes());
        }
        for image in [&scene.left, &scene.right] {
            hash_image(&mut hash, image);
        }
        for value in scene.truth.samples() {
            // Every NaN is the same: unknown.
            let value = if value.is_nan() { f32::NAN } else { *value };
            hash.update(value.to_bits().to_le_bytes());
        }
    }
    hexadecimal(&hash.finalize())
}

/// That of the tests of a scheme: points up to the same thresholds on the same scenes. Limits of CPU time are not
/// part of it: machines differ.
pub fn tests_fingerprint<'a>(tests: impl IntoIterator<Item = (&'a Test, &'a Scene)>) -> String {
    let unlimited = |test: &Test| Test { cpu_seconds: 0.0, ..test.clone() };
    let tests: Vec<_> = tests.into_iter().map(|(test, scene)| (unlimited(test), scene)).collect();
    fingerprint(&tests)
}

fn hash_image(hash: &mut Sha256, image: &Image) {
    let (columns, rows) = image.size();
    hash.update([columns as u64, rows as u64].map(u64::to_le_bytes).concat());
    match image {
        Image::Grey8(plane) => hash.update(plane.samples()),
        Image::Rgb8(plane) => hash.update(plane.samples().as_flattened()),
        Image::Grey16(plane) => plane.samples().iter().for_each(|s| hash.update(s.to_le_bytes())),
        Image::Rgb16(plane) => {
            plane.samples().as_flattened().iter().for_each(|s| hash.update(s.to_le_bytes()));
        }
    }
}
