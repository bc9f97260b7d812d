//! The files that a match writes.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::bail;
use formats::picture::{self, ColourMap};
use formats::{FormatError, write_disparity, write_image};
use raster::{DisparityMap, DisparityRange, Image, Plane};

use super::sidecar::Sidecar;
use crate::map::sha256;
use crate::outputs::{self, Output};

/// Where everything goes.
pub struct Outputs {
    /// The disparities, format by extension.
    pub disparity: PathBuf,
    /// The disparities in colours.
    pub preview: Option<PathBuf>,
    /// The confidence.
    pub confidence: Option<PathBuf>,
    /// The reasons in colours.
    pub reasons: Option<PathBuf>,
}

/// Whether the file is a PNG, which holds a picture or KITTI's whole numbers.
fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"))
}

/// A confidence as a grey picture or as numbers, by extension.
fn write_confidence(path: &Path, confidence: &Plane<f32>) -> Result<(), FormatError> {
    if is_png(path) {
        return write_image(path, &Image::Grey8(picture::confidence(confidence)));
    }
    write_disparity(path, confidence).map_err(|error| match error {
        // Disparities stand in other numbers in a PNG.
        FormatError::UnknownExtension { path, .. } => {
            FormatError::UnknownExtension { path, known: CONFIDENCE }
        }
        other => other,
    })
}

/// What confidence is written as, and pictures in colours.
const CONFIDENCE: &str = ".pfm, .npy, .tiff (float32), .png (grey picture)";
const COLOURS: &str = ".png, .ppm (colour)";

/// A picture in colours, by extension.
fn write_colours(path: &Path, colours: Plane<[u8; 3]>) -> Result<(), FormatError> {
    // A .pgm is a picture, too, but a grey one.
    let is = |colour: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(colour));
    match is("png") || is("ppm") {
        true => write_image(path, &Image::Rgb8(colours)),
        false => Err(FormatError::UnknownExtension { path: path.to_owned(), known: COLOURS }),
    }
}

impl Outputs {
    /// The record's place: `.json` behind the name of the disparities' file.
    pub fn sidecar(&self) -> PathBuf {
        let mut name = self.disparity.clone().into_os_string();
        name.push(".json");
        name.into()
    }

    /// Errors when a file cannot be written, as far as that can be told before there is a map.
    pub fn check(&self, inputs: &[&Path]) -> anyhow::Result<()> {
        let tiny = DisparityMap::empty(1, 1);
        outputs::check(&self.all(&tiny, DisparityRange::new(0, 1)?, &|_| String::new()), inputs)
    }

    /// Every file that was asked for, and what goes into it; the record is made of the map's SHA-256.
    fn all<'a>(
        &'a self,
        map: &'a DisparityMap,
        range: DisparityRange,
        record: &'a dyn Fn(Option<String>) -> String,
    ) -> Vec<Output<'a>> {
        // The record is written after the map, and tells which one it is of.
        let digest = Rc::new(RefCell::new(None));
        let told = Rc::clone(&digest);
        let mut all = vec![
            Output::new("--output", &self.disparity, move |path| {
                write_disparity(path, &map.values)?;
                let read = |source| FormatError::Read { path: path.to_owned(), source };
                *digest.borrow_mut() = sha256(path).map_err(read)?;
                Ok(())
            }),
            Output::new("--output", self.sidecar(), move |path| {
                let record = record(told.borrow().clone());
                formats::write_atomically(path, |file| file.write_all(record.as_bytes()))
            }),
        ];
        if let Some(path) = &self.preview {
            all.push(Output::new("--preview", path, move |path| {
                let (min, max) = (range.min() as f32, range.max() as f32);
                let colours = picture::disparity(&map.values, min, max, ColourMap::Turbo);
                write_colours(path, colours)
            }));
        }
        if let Some(path) = &self.confidence {
            let write = |path: &Path| write_confidence(path, &map.confidence);
            all.push(Output::new("--confidence", path, write));
        }
        if let Some(path) = &self.reasons {
            all.push(Output::new("--reasons", path, |path| {
                write_colours(path, picture::reasons(&map.reasons))
            }));
        }
        all
    }

    /// Errors when the format cannot hold every disparity of the range.
    pub fn check_range(&self, range: DisparityRange) -> anyhow::Result<()> {
        if is_png(&self.disparity) && (range.min() < 0 || range.max() > 255) {
            bail!(
                "{} holds disparities from 0 to below 256 (KITTI's 16-bit PNG), but {} to {} are \
                 to be looked for: write .pfm, .npy or .tiff, or give a range within 0 to 255",
                self.disparity.display(),
                range.min(),
                range.max()
            );
        }
        Ok(())
    }

    /// Writes every file, or leaves everything as it was.
    pub fn write(
        &self,
        map: &DisparityMap,
        range: DisparityRange,
        sidecar: &Sidecar,
    ) -> anyhow::Result<()> {
        outputs::write_all_or_none(&self.all(map, range, &|digest| sidecar.text(digest)))?;
        Ok(())
    }
}
