//! Samples of 16 bits of which the camera filled fewer.

use std::path::Path;

use anyhow::bail;
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
                "{path} has samples of {used} bits, more than --bits {bits} allows: give {used}{}, or leave it out \
                 where the file states its bits itself, as a PGM does",
                if used < u16::BITS { " or more" } else { "" }
            );
        }
    }
    Ok(files.map(|(_, image)| image.widened_from(bits)))
}
