//! Samples of 16 bits of which the camera filled fewer.
//!
//! Cameras give 10 or 12 bits, and drivers store them in files of 16 as they are: the pictures are
//! nearly black. Steps of grey are what matching lives on, so it wants them over all 16 bits.

use std::path::Path;

use anyhow::bail;
use raster::Image;

/// Up to so many bits, it is told that the others are never used.
const FEW: u32 = 12;

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
                "{path} has samples of {used} bits, more than --bits {bits} allows: give {used} or more"
            );
        }
    }
    Ok(files.map(|(_, image)| image.widened_from(bits)))
}

/// What to tell of images that leave many of 16 bits unused. Of black ones there is nothing to tell.
pub fn unused(files: [(&Path, &Image); 2]) -> Option<String> {
    if files.iter().any(|(_, image)| image.depth() < u16::BITS) {
        return None;
    }
    let used = files.iter().map(|(_, image)| image.bits_used()).max()?;
    let [(left, _), (right, _)] = files;
    (1..=FEW).contains(&used).then(|| {
        format!(
            "{} and {}: of 16 bits the upper {} are never used, which makes matches worse; if the camera \
             gives {used} bits, say --bits {used}",
            left.display(),
            right.display(),
            u16::BITS - used,
        )
    })
}
