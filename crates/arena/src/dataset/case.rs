//! One scene: what is known before its files are opened, and what is in them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use camera::StereoCamera;
use formats::Encoding;
use raster::{BoundingBox, DisparityRange, Image, Plane};
use serde::{Deserialize, Serialize};

use super::error::DatasetError;
use super::load;

/// What a scene may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Purpose {
    /// To be measured, never tuned on.
    Test,
    /// Parameters may be chosen by it.
    Tuning,
    /// From a rover's cameras, without truth.
    Rover,
    /// Rendered, with exact truth.
    Rendered,
}

impl Purpose {
    /// Every purpose.
    pub const ALL: [Purpose; 4] =
        [Purpose::Test, Purpose::Tuning, Purpose::Rover, Purpose::Rendered];

    /// The name used on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Test => "test",
            Self::Tuning => "tuning",
            Self::Rover => "rover",
            Self::Rendered => "rendered",
        }
    }
}

impl fmt::Display for Purpose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Purpose {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|purpose| purpose.name() == text).ok_or_else(|| {
            format!("`{text}` is no use of a scene; it must be test, tuning, rover or rendered")
        })
    }
}

/// A file of true disparities.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthFile {
    /// Where it lies.
    pub path: PathBuf,
    /// How its samples stand for disparities.
    pub encoding: Encoding,
    /// Whether a disparity of 0 says that nobody knows, in floats as it does in integers.
    pub zero_is_none: bool,
}

impl TruthFile {
    /// One whose encoding alone says what is unknown.
    pub fn new(path: PathBuf, encoding: Encoding) -> Self {
        Self { path, encoding, zero_is_none: false }
    }
}

/// Where the files of a scene lie.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Files {
    /// The left image.
    pub left: PathBuf,
    /// The right image.
    pub right: PathBuf,
    /// True disparities of the left image.
    pub truth: Option<TruthFile>,
    /// True disparities of the right image, from which occluded pixels can be told.
    pub truth_right: Option<TruthFile>,
    /// True disparities of the left image, only of pixels that both cameras see.
    pub truth_noc: Option<TruthFile>,
    /// Integers that are true disparities of the left image at a scale that nothing tells: they are not read.
    pub unscaled: Option<PathBuf>,
    /// Which pixels both cameras see.
    pub mask_nocc: Option<PathBuf>,
    /// The box to answer and score.
    pub bounds: Option<PathBuf>,
    /// The calibration.
    pub calibration: Option<PathBuf>,
}

impl Files {
    /// Every one of them.
    pub fn all(&self) -> impl Iterator<Item = &Path> {
        let Self { left, right, truth, truth_right, truth_noc, .. } = self;
        let Self { unscaled, mask_nocc, bounds, calibration, .. } = self;
        let truths = [truth, truth_right, truth_noc].into_iter().flatten().map(|truth| &truth.path);
        let others = [unscaled, mask_nocc, bounds, calibration].into_iter().flatten();
        [left, right].into_iter().chain(truths).chain(others).map(PathBuf::as_path)
    }
}

/// What makes a rendered scene when it is needed.
pub(super) type Renderer = Arc<dyn Fn() -> Result<CaseData, String> + Send + Sync>;

#[derive(Clone)]
pub(super) enum Origin {
    Files(Box<Files>),
    Rendered(Renderer),
}

/// One scene, not loaded yet.
#[derive(Clone)]
pub struct Case {
    /// A name, unique in its data set: `FAMILY/SCENE`.
    pub id: String,
    /// What it may be used for.
    pub purpose: Purpose,
    /// The disparities to search, where the data set states them.
    pub range: Option<DisparityRange>,
    pub(super) origin: Origin,
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("id", &self.id).field("purpose", &self.purpose).finish()
    }
}

impl Case {
    /// A scene in files.
    pub fn new(id: impl Into<String>, purpose: Purpose, files: Files) -> Self {
        Self { id: id.into(), purpose, range: None, origin: Origin::Files(Box::new(files)) }
    }

    /// A scene that `render` makes whenever it is needed.
    pub fn rendered(
        id: impl Into<String>,
        render: impl Fn() -> Result<CaseData, String> + Send + Sync + 'static,
    ) -> Self {
        Self {
            id: id.into(),
            purpose: Purpose::Rendered,
            range: None,
            origin: Origin::Rendered(Arc::new(render)),
        }
    }

    /// The part of the id before its last `/`: the data set that the scene belongs to.
    pub fn family(&self) -> &str {
        self.id.rsplit_once('/').map_or("", |(family, _)| family)
    }

    /// Where its files lie; `None` for a rendered scene.
    pub fn files(&self) -> Option<&Files> {
        match &self.origin {
            Origin::Files(files) => Some(files),
            Origin::Rendered(_) => None,
        }
    }

    /// Whether there is truth to score against.
    pub fn has_truth(&self) -> bool {
        match &self.origin {
            Origin::Files(files) => files.truth.is_some(),
            Origin::Rendered(_) => true,
        }
    }

    /// Opens the files, or renders the scene.
    pub fn load(&self) -> Result<CaseData, DatasetError> {
        match &self.origin {
            Origin::Files(files) => load::files(files, self.range),
            Origin::Rendered(render) => render().map_err(DatasetError::Rendering),
        }
    }

    /// True disparities of the right image of `data`, which was loaded from it, NaN = unknown; `None`
    /// where there are none in a file.
    pub fn truth_right(&self, data: &CaseData) -> Result<Option<Plane<f32>>, DatasetError> {
        let file = self.files().and_then(|files| files.truth_right.as_ref());
        file.map(|file| load::truth_right(file, data.right.size())).transpose()
    }
}

/// Pixels that are scored apart.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseRegion {
    /// "non-occluded", "occluded", and in rendered scenes "discontinuity", "thin", "textureless",
    /// "repeated".
    pub name: &'static str,
    /// Which pixels.
    pub mask: Plane<bool>,
    /// Their truth, where the data set has another one for them (KITTI's `disp_noc`).
    pub truth: Option<Plane<f32>>,
}

/// Small things that were laid before a scene. Both planes have the size of the left image.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacles {
    /// True disparities of what is behind them, NaN = unknown.
    pub behind: Plane<f32>,
    /// Which of them is seen there, counted from 1; 0 where none is.
    pub things: Plane<u32>,
    /// The width of each in pixels, or its height if that is less.
    pub widths: Vec<usize>,
}

/// One scene, loaded. All planes have the size of the left image.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseData {
    /// The left image.
    pub left: Image,
    /// The right image.
    pub right: Image,
    /// The pixels to answer and to score.
    pub bounds: BoundingBox,
    /// The disparities to search.
    pub range: DisparityRange,
    /// The cameras, where they are known.
    pub camera: Option<StereoCamera>,
    /// True disparities of the left image, NaN = unknown.
    pub truth: Option<Plane<f32>>,
    /// Pixels that are scored apart.
    pub regions: Vec<CaseRegion>,
    /// Small things that were laid before the scene, where they were.
    pub obstacles: Option<Obstacles>,
    /// Which truth, which masks, what was assumed: sentences for the record.
    pub protocol: Vec<String>,
}

impl CaseData {
    /// A scene in memory whose whole image is answered.
    pub fn new(left: Image, right: Image, range: DisparityRange) -> Self {
        let bounds = BoundingBox::whole(left.columns(), left.rows());
        let (camera, truth, regions, protocol) = (None, None, Vec::new(), Vec::new());
        let obstacles = None;
        Self { left, right, bounds, range, camera, truth, regions, obstacles, protocol }
    }

    /// Adds the pixels that both cameras see and those that only the left one does.
    pub fn add_occlusions(&mut self, occluded: &Plane<bool>) {
        let non_occluded = occluded.map(|&hidden| !hidden);
        self.regions.push(CaseRegion { name: "non-occluded", mask: non_occluded, truth: None });
        self.regions.push(CaseRegion { name: "occluded", mask: occluded.clone(), truth: None });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_a_scene_is_named() {
        let truth = |name: &str| Some(TruthFile::new(name.into(), Encoding::Pfm));
        let files = Files {
            left: "left".into(),
            right: "right".into(),
            truth: truth("truth"),
            truth_right: truth("truth-right"),
            truth_noc: truth("truth-noc"),
            unscaled: Some("unscaled".into()),
            mask_nocc: Some("mask".into()),
            bounds: Some("box".into()),
            calibration: Some("calibration".into()),
        };
        let names: Vec<_> = files.all().map(|path| path.display().to_string()).collect();
        let truths = ["truth", "truth-right", "truth-noc", "unscaled"];
        let expected = [&["left", "right"][..], &truths, &["mask", "box", "calibration"]].concat();
        assert_eq!(names, expected);
        assert_eq!(Files::default().all().count(), 2);
    }
}
