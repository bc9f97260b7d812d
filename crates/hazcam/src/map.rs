//! A disparity map from its file, with what lies over it pixel for pixel: the left image, how sure each
//! pixel is and why, the truth.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::bail;
use formats::{Encoding, ReadDisparity};
use matching::few_bits;
use raster::{Image, Plane, Reason};
use serde::Deserialize;
use sha2::{Digest, Sha256};

use crate::ui::Ui;

/// What is read of the record beside a map.
#[derive(Deserialize)]
struct Record {
    /// The images that it was matched from.
    left: Input,
    right: Input,
    /// Of the map's file.
    output_sha256: String,
    /// Pixels per reason, as shares.
    reasons: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
struct Input {
    path: String,
    sha256: String,
}

/// A disparity map and where it came from.
pub struct Map {
    path: PathBuf,
    /// In pixels, NaN where there is none.
    pub disparities: Plane<f32>,
    /// What lies beside it, once somebody has asked: the whole map is read for that.
    record: OnceCell<Option<Record>>,
}

/// The SHA-256 of a file in hexadecimal digits; none for a pipe, which can be read only once.
pub fn sha256(path: &Path) -> io::Result<Option<String>> {
    if !fs::metadata(path)?.is_file() {
        return Ok(None);
    }
    Ok(Some(sha256_of(&fs::read(path)?)))
}

/// The SHA-256 of these bytes in hexadecimal digits.
pub fn sha256_of(bytes: &[u8]) -> String {
    arena::hexadecimal(&Sha256::digest(bytes))
}

impl Map {
    /// Reads a map and says what had to be assumed.
    pub fn read(path: &Path, encoding: Encoding, ui: &Ui) -> anyhow::Result<Self> {
        let disparities = match disparities(path, encoding, ui)? {
            // Where 0 says that there is none, a disparity of 0 is written as the least that is left: it is no distance.
            (values, Encoding::Png16 { divisor: KITTI }) => {
                values.map(|&d| if d == 1.0 / KITTI { 0.0 } else { d })
            }
            (values, _) => values,
        };
        if let Some(doubt) = camera::too_large(&disparities) {
            ui.warn(format_args!("{}: {doubt}", path.display()));
        }
        Ok(Self { path: path.to_owned(), disparities, record: OnceCell::new() })
    }

    /// The left image, for colours. Samples of 16 bits that use few of them would all be black: they are spread over
    /// all, which is said. Where the record beside the map tells that it is the right one a warning says so.
    pub fn image(&self, path: &Path, ui: &Ui) -> anyhow::Result<Image> {
        let (image, bytes) = formats::read_image_and_bytes(path)?;
        self.same_size(path, image.size())?;
        if let Some(Record { left, right, .. }) = self.record()
            && left.sha256 != right.sha256
            && sha256_of(&bytes) == right.sha256
        {
            ui.warn(format_args!(
                "{} is the right image of the pair that {} was matched from, and disparities lie over the left \
                 one: give {}",
                path.display(),
                self.path.display(),
                left.path
            ));
        }
        let Some(used) = few_bits(&image, &image) else { return Ok(image) };
        ui.note(format_args!(
            "{}: of 16 bits the upper {} are never used: its colours are made as bright as {used} bits are",
            path.display(),
            u16::BITS - used
        ));
        Ok(image.widened_from(used))
    }

    /// Says how many of the disparities were filled in without a match, and what to do then, where the record that
    /// `hazcam match` leaves beside a map tells of any: a warning where it is most of them.
    pub fn tell_guesses(&self, ui: &Ui, remedy: fmt::Arguments<'_>) {
        let Some(share) = self.guesses() else { return };
        let told = format!(
            "{:.1} % of the disparities were filled in without a match, so their depth is a guess: {remedy}",
            100.0 * share
        );
        match share > 0.5 {
            true => ui.warn(told),
            false => ui.note(told),
        }
    }

    /// The record that `hazcam match` leaves beside a map. One of another map, which stood there before, is none.
    fn record(&self) -> Option<&Record> {
        let read = || {
            let mut record = self.path.clone().into_os_string();
            record.push(".json");
            let record: Record = serde_json::from_slice(&fs::read(record).ok()?).ok()?;
            (sha256(&self.path).ok()?? == record.output_sha256).then_some(record)
        };
        self.record.get_or_init(read).as_ref()
    }

    /// The share of the disparities that were filled in, by the record beside the map.
    fn guesses(&self) -> Option<f64> {
        let record = self.record()?;
        let share = |filled: &dyn Fn(Reason) -> bool| -> f64 {
            let reasons = Reason::ALL.into_iter().filter(|&reason| filled(reason));
            reasons.filter_map(|reason| record.reasons.get(reason.name())).sum()
        };
        let filled = share(&|reason| reason.has_value() && reason != Reason::Matched);
        (filled > 0.0).then(|| filled / share(&Reason::has_value))
    }

    /// How sure each pixel is, from 0 to 1; NaN is not sure.
    pub fn confidence(&self, path: &Path) -> anyhow::Result<Plane<f32>> {
        // Not what had to be assumed: a file that needs that holds no confidence, which is found below.
        let confidence = formats::read_disparity(path, Encoding::Auto)?.values;
        self.same_size(path, confidence.size())?;
        let wrong = confidence.samples().iter().position(|sure| *sure < 0.0 || *sure > 1.0);
        if let Some(at) = wrong {
            bail!(
                "{} holds no confidence: the pixel at column {}, row {} is {}, but it must be from \
                 0 to 1; give the .pfm, .npy or .tiff of `hazcam match --confidence`",
                path.display(),
                at % confidence.columns(),
                at / confidence.columns(),
                confidence.samples()[at]
            );
        }
        Ok(confidence)
    }

    /// Why each pixel has its value or none.
    pub fn reasons(&self, path: &Path) -> anyhow::Result<Plane<Reason>> {
        let reasons = formats::read_reasons(path)?;
        self.same_size(path, reasons.size())?;
        Ok(reasons)
    }

    /// The true disparities. Says what had to be assumed.
    pub fn truth(&self, path: &Path, encoding: Encoding, ui: &Ui) -> anyhow::Result<Plane<f32>> {
        let (truth, _) = disparities(path, encoding, ui)?;
        self.same_size(path, truth.size())?;
        Ok(truth)
    }

    /// Errors that name the files: `path` lies over the map.
    fn same_size(&self, path: &Path, found: (usize, usize)) -> anyhow::Result<()> {
        let (columns, rows) = self.disparities.size();
        if found != (columns, rows) {
            bail!(
                "{} is {} x {} but {} is {columns} x {rows}: they must have one size",
                path.display(),
                found.0,
                found.1,
                self.path.display()
            );
        }
        Ok(())
    }
}

/// What KITTI's samples of 16 bits are divided by.
const KITTI: f32 = 256.0;

/// Reads disparities, in which encoding they were, and says what had to be assumed.
fn disparities(path: &Path, encoding: Encoding, ui: &Ui) -> anyhow::Result<(Plane<f32>, Encoding)> {
    let ReadDisparity { values, encoding, note } = formats::read_disparity(path, encoding)?;
    if let Some(note) = note {
        ui.note(format_args!("{}: {note}", path.display()));
    }
    Ok((values, encoding))
}
