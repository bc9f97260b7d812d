//! The files that a match writes: tried before the work begins, written after it, all or none.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use formats::picture::{self, ColourMap};
use formats::{FormatError, write_disparity, write_image};
use raster::{DisparityMap, DisparityRange, Image, Plane};

use super::sidecar::Sidecar;

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

/// A confidence as a picture or as numbers, by extension.
fn write_confidence(path: &Path, confidence: &Plane<f32>) -> Result<(), FormatError> {
    match is_png(path) {
        true => write_image(path, &Image::Rgb8(picture::confidence(confidence))),
        false => write_disparity(path, confidence),
    }
}

impl Outputs {
    /// The record's place: `.json` behind the name of the disparities' file.
    pub fn sidecar(&self) -> PathBuf {
        let mut name = self.disparity.clone().into_os_string();
        name.push(".json");
        name.into()
    }

    /// Every file with the option that asked for it.
    fn files(&self) -> Vec<(&'static str, PathBuf)> {
        let optional = [
            ("--preview", &self.preview),
            ("--confidence", &self.confidence),
            ("--reasons", &self.reasons),
        ];
        let mut files = vec![("--output", self.disparity.clone()), ("--output", self.sidecar())];
        files.extend(
            optional.into_iter().filter_map(|(option, path)| Some((option, path.clone()?))),
        );
        files
    }

    /// Errors when a file would replace an input or another output, when its extension is unknown,
    /// or when its folder cannot be written. Leaves nothing behind.
    pub fn check(&self, inputs: [&PathBuf; 2]) -> anyhow::Result<()> {
        let files = self.files();
        for (i, (option, path)) in files.iter().enumerate() {
            if inputs.iter().any(|input| is_same_file(input, path)) {
                bail!("{option} {} would replace an input: name another file", path.display());
            }
            if let Some((other, _)) = files[..i].iter().find(|(_, other)| other == path) {
                bail!("{other} and {option} both name {}: name two files", path.display());
            }
        }
        let tiny = Plane::filled(1, 1, 0.0);
        let picture = Image::Rgb8(Plane::filled(1, 1, [0; 3]));
        attempt(&self.disparity, |path| write_disparity(path, &tiny))?;
        attempt(&self.sidecar(), |path| formats::write_atomically(path, |_| Ok(())))?;
        if let Some(path) = &self.confidence {
            attempt(path, |path| write_confidence(path, &tiny))?;
        }
        for path in [&self.preview, &self.reasons].into_iter().flatten() {
            attempt(path, |path| write_image(path, &picture))?;
        }
        Ok(())
    }

    /// Errors when the format cannot hold every disparity of the range.
    pub fn check_range(&self, range: DisparityRange) -> anyhow::Result<()> {
        if is_png(&self.disparity) && (range.min() < 0 || range.max() > 255) {
            bail!(
                "{} holds disparities from 0 to below 256 (KITTI's 16-bit PNG), but {} to {} are \
                 to be looked for: write .pfm, .npy or .tiff, or narrow the range",
                self.disparity.display(),
                range.min(),
                range.max()
            );
        }
        Ok(())
    }

    /// Writes every file. When one fails, those already written are removed.
    pub fn write(
        &self,
        map: &DisparityMap,
        range: DisparityRange,
        sidecar: &Sidecar,
    ) -> anyhow::Result<()> {
        let result = self.write_each(map, range, sidecar);
        if result.is_err() {
            for (_, path) in self.files() {
                // The error that stopped the writing matters more than one from tidying up.
                let _ = fs::remove_file(path);
            }
        }
        result
    }

    fn write_each(
        &self,
        map: &DisparityMap,
        range: DisparityRange,
        sidecar: &Sidecar,
    ) -> anyhow::Result<()> {
        write_disparity(&self.disparity, &map.values)?;
        if let Some(path) = &self.preview {
            let (min, max) = (range.min() as f32, range.max() as f32);
            let colours = picture::disparity(&map.values, min, max, ColourMap::Turbo);
            write_image(path, &Image::Rgb8(colours))?;
        }
        if let Some(path) = &self.confidence {
            write_confidence(path, &map.confidence)?;
        }
        if let Some(path) = &self.reasons {
            write_image(path, &Image::Rgb8(picture::reasons(&map.reasons)))?;
        }
        let record = serde_json::to_string_pretty(sidecar)? + "\n";
        formats::write_atomically(self.sidecar(), |file| file.write_all(record.as_bytes()))?;
        Ok(())
    }
}

/// Whether both paths lead to one existing file.
fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

/// Writes a file of the same name into a passing folder beside `path`, so that whatever would stop
/// the real writing stops the program before it has worked.
fn attempt(
    path: &Path,
    write: impl FnOnce(&Path) -> Result<(), FormatError>,
) -> anyhow::Result<()> {
    let Some(name) = path.file_name() else { bail!("{} names no file", path.display()) };
    if path.is_dir() {
        bail!("cannot write {}: it is a folder; name a file in it", path.display());
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        bail!(
            "cannot write {}: the folder {} does not exist; create it first",
            path.display(),
            folder.display()
        );
    }
    let passing = tempfile::Builder::new()
        .prefix(".hazcam-")
        .tempdir_in(folder)
        .with_context(|| format!("cannot write {}", path.display()))?;
    write(&passing.path().join(name)).map_err(|error| match error {
        FormatError::UnknownExtension { known, .. } => {
            FormatError::UnknownExtension { path: path.to_owned(), known }
        }
        other => other,
    })?;
    Ok(())
}
