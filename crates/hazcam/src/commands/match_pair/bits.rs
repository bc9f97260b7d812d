//! Samples of 16 bits of which the camera filled fewer.

use std::path::Path;

use anyhow::bail;
use matching::{few_bits, few_levels};
use raster::Image;

use crate::arguments;

/// How many bits samples have.
pub fn number(text: &str) -> Result<u32, String> {
    arguments::whole(text, 1..=u16::BITS)
}

/// The images of two files whose samples have so many bits, over all 16.
pub fn widened(bits: u32, files: [(&Path, Image); 2]) -> anyhow::Result<[Image; 2]> {
    for (path, image) in &files {
        let path = path.display();
        if image.depth() < u16::BITS {
            bail!("--bits {bits} is for images of 16 bits, but {path} has 8: leave it out");
        }
        let used = image.bits_used();
        if used > bits {
            bail!(
                "{path} has samples of {used} bits, more than --bits {bits} allows: give {used} or \
                 more, or leave it out where the file states its bits itself, as a PGM does"
            );
        }
    }
    Ok(files.map(|(_, image)| image.widened_from(bits)))
}

/// What to tell of images that leave much of 16 bits unused.
pub fn unused([(left, of_left), (right, of_right)]: [(&Path, &Image); 2]) -> Option<String> {
    let levels = few_levels(of_left, of_right).map(|[least, most]| {
        format!(
            "{} and {}: all samples of 16 bits lie from {least} to {most}, which makes matches worse; spread \
             them over 0 to 65535 before",
            left.display(),
            right.display(),
        )
    });
    let bits = few_bits(of_left, of_right).map(|used| {
        format!(
            "{} and {}: of 16 bits the upper {} are never used, which makes matches worse; if the camera \
             gives {used} bits, say --bits {used}",
            left.display(),
            right.display(),
            u16::BITS - used,
        )
    });
    bits.or(levels)
}
