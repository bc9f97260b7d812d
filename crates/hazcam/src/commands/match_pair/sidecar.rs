//! The record beside a disparity map: what it was made from, how, and what came out.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use formats::FormatError;
use matching::{Holes, Level, Options, VerticalDisparity};
use raster::{BoundingBox, DisparityMap, Image, Reason};
use serde::Serialize;

use super::outputs::Outputs;
use crate::clock::Elapsed;
use crate::map::sha256_of;

/// What stands in `OUT.json`.
#[derive(Serialize)]
pub struct Sidecar {
    /// The version of hazcam.
    hazcam: &'static str,
    left: Input,
    right: Input,
    #[serde(serialize_with = "formats::path_as_text")]
    output: PathBuf,
    columns: usize,
    rows: usize,
    options: OptionsRecord,
    /// The vector instructions that were used.
    cpu_level: &'static str,
    /// Of the matching alone, without reading and writing files.
    time: Elapsed,
    /// What was taken out of the right image before it was matched; none where it was left as it is.
    vertical_disparity: Option<VerticalRecord>,
    /// Pixels of the box per reason, as shares from 0 to 1; reasons that do not occur are left out.
    reasons: BTreeMap<&'static str, f64>,
}

/// The record of a map that was written.
#[derive(Serialize)]
struct OfMap<'a> {
    #[serde(flatten)]
    record: &'a Sidecar,
    /// None for what is no file.
    output_sha256: Option<String>,
}

/// In pixels, over the image.
#[derive(Serialize)]
struct VerticalRecord {
    root_mean_square: f64,
    largest: f64,
    coefficients: Coefficients,
}

/// The factors of `1`, `x`, `y`, `x y`, `y^2` and `x^2`, as [`VerticalDisparity::coefficients`] has them.
#[derive(Serialize)]
struct Coefficients {
    constant: f64,
    x: f64,
    y: f64,
    xy: f64,
    yy: f64,
    xx: f64,
}

impl From<[f64; 6]> for Coefficients {
    fn from([constant, x, y, xy, yy, xx]: [f64; 6]) -> Self {
        Self { constant, x, y, xy, yy, xx }
    }
}

/// A file that was read.
#[derive(Serialize)]
pub struct Input {
    #[serde(serialize_with = "formats::path_as_text")]
    path: PathBuf,
    bytes: usize,
    sha256: String,
    /// What else the file holds, of which nothing is made.
    #[serde(skip)]
    pub unused: Vec<String>,
}

#[derive(Serialize)]
struct OptionsRecord {
    matcher: &'static str,
    /// How many bits 16-bit samples were said to have; none for all.
    bits: Option<u32>,
    min_disparity: i32,
    max_disparity: i32,
    #[serde(rename = "box")]
    bounds: String,
    holes: &'static str,
    threads: usize,
    /// In bytes; none without a limit.
    memory: Option<usize>,
}

/// What a map is made of.
pub struct Inputs {
    pub left: Input,
    pub right: Input,
    /// How many bits 16-bit samples were said to have.
    pub bits: Option<u32>,
}

impl Sidecar {
    /// Counts the reasons.
    pub fn new(
        Inputs { left, right, bits }: Inputs,
        outputs: &Outputs,
        options: &Options,
        bounds: BoundingBox,
        map: &DisparityMap,
        vertical: Option<&VerticalDisparity>,
        time: Elapsed,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            hazcam: env!("CARGO_PKG_VERSION"),
            left,
            right,
            output: outputs.disparity.clone(),
            columns: map.values.columns(),
            rows: map.values.rows(),
            options: OptionsRecord {
                matcher: options.preset.name(),
                bits,
                min_disparity: options.range.min(),
                max_disparity: options.range.max(),
                bounds: bounds.to_string(),
                holes: match options.holes {
                    Holes::Fill => "fill",
                    Holes::Keep => "keep",
                },
                threads: options.threads,
                memory: options.memory,
            },
            cpu_level: Level::chosen()?.name(),
            time,
            vertical_disparity: vertical.map(|vertical| VerticalRecord {
                root_mean_square: vertical.root_mean_square(),
                largest: vertical.largest(),
                coefficients: vertical.coefficients().into(),
            }),
            reasons: shares(map, bounds),
        })
    }

    /// The record of a map whose file has this SHA-256, as a text.
    pub fn text(&self, output_sha256: Option<String>) -> String {
        let record = OfMap { record: self, output_sha256 };
        // Numbers and texts under names of their own: there is nothing that could fail.
        serde_json::to_string_pretty(&record).expect("a record can be written") + "\n"
    }

    /// The share of the box that was matched, not filled or left open.
    pub fn matched(&self) -> f64 {
        self.reasons.get(Reason::Matched.name()).copied().unwrap_or(0.0)
    }
}

/// The share of the box's pixels per reason.
fn shares(map: &DisparityMap, bounds: BoundingBox) -> BTreeMap<&'static str, f64> {
    let mut counts = [0usize; Reason::ALL.len()];
    for y in bounds.y0..=bounds.y1 {
        for &reason in &map.reasons.row(y)[bounds.x0..=bounds.x1] {
            counts[usize::from(reason as u8)] += 1;
        }
    }
    let all = (bounds.columns() * bounds.rows()) as f64;
    let found = Reason::ALL.into_iter().zip(counts).filter(|&(_, count)| count > 0);
    found.map(|(reason, count)| (reason.name(), count as f64 / all)).collect()
}

impl Input {
    /// Reads an image, and records what it was decoded from: while it is matched, the file may become another one.
    pub fn read(path: &Path) -> Result<(Image, Self), FormatError> {
        let (image, bytes) = formats::read_image_and_bytes(path)?;
        let (sha256, unused) = (sha256_of(&bytes), formats::unused(&bytes));
        Ok((image, Self { path: path.to_owned(), bytes: bytes.len(), sha256, unused }))
    }
}
