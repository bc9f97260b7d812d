//! A scene with its truth, in memory.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use formats::Encoding;
use raster::{BoundingBox, Image, Plane};

use super::scheme::{SceneSource, Scheme};
use crate::dataset::{Case, CaseData, Files, Purpose, TruthFile};

/// A rectified pair with ground truth. The truth stays in the grader's memory; entrants get files
/// with the two images and nothing else.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Its name in reports.
    pub id: String,
    /// Left image.
    pub left: Image,
    /// Right image, of the same size.
    pub right: Image,
    /// True disparity of the left image in pixels, NaN where nobody knows.
    pub truth: Plane<f32>,
    /// True where both cameras see the pixel, if that is known.
    pub non_occluded: Option<Plane<bool>>,
    /// The pixels that are asked for and scored.
    pub bounds: BoundingBox,
    /// Files that hold the truth or a part of it: they must be out of every entrant's reach.
    pub secrets: Vec<PathBuf>,
}

/// The scenes of a scheme by id; for one that cannot be used, why.
pub type Scenes = BTreeMap<String, Result<Scene, String>>;

/// What to render: kind, seed, columns and rows.
pub type Render<'a> =
    &'a dyn Fn(&str, u64, Option<usize>, Option<usize>) -> Result<CaseData, String>;

impl Scene {
    /// Loads a case; errors, in words, when it has no truth or its files cannot be used.
    pub fn load(case: &Case) -> Result<Self, String> {
        let secrets = case.files().map(secrets).unwrap_or_default();
        Self::from_data(&case.id, case.load().map_err(|error| error.to_string())?, secrets)
    }

    fn from_data(id: &str, data: CaseData, secrets: Vec<PathBuf>) -> Result<Self, String> {
        let truth = data.truth.ok_or_else(|| "it has no truth to score against".to_owned())?;
        let non_occluded =
            data.regions.into_iter().find(|region| region.name == "non-occluded").map(|r| r.mask);
        let (left, right, bounds) = (data.left, data.right, data.bounds);
        Ok(Self { id: id.to_owned(), left, right, truth, non_occluded, bounds, secrets })
    }

    /// Errors where most of what is scored lies beyond the largest disparity that is asked for: then the truth is read
    /// at the wrong scale, or nobody can answer.
    pub fn check_range(&self, max_disparity: u32) -> Result<(), String> {
        let truths = self.bounds.pixels().map(|(x, y)| self.truth.row(y)[x]);
        let scored = truths.filter(|truth| truth.is_finite() && *truth != 0.0);
        let beyond = score::share_outside(scored, f32::NEG_INFINITY..=max_disparity as f32);
        if beyond <= 0.5 {
            return Ok(());
        }
        Err(format!(
            "{:.0} % of its truth lies beyond max_disparity, {max_disparity}: is it stored as something else \
             (`truth_encoding`, such as \"png8/4\" for 8-bit PNG in quarters of a pixel), or max_disparity too small?",
            100.0 * beyond
        ))
    }

    /// The same scene, asked for and scored within this box only.
    fn within(mut self, bounds: Option<&str>) -> Result<Self, String> {
        let Some(bounds) = bounds else { return Ok(self) };
        let bounds = match bounds.ends_with(".npy") {
            true => formats::read_bounding_box(bounds),
            false => formats::parse_bounding_box(bounds),
        };
        self.bounds = bounds.map_err(|error| error.to_string())?;
        let (columns, rows) = self.truth.size();
        self.bounds.check_within(columns, rows).map_err(|error| error.to_string())?;
        Ok(self)
    }
}

/// What tells the truth of these files: that of the right view is the left one's, warped, and that
/// of pixels that both cameras see is most of it.
fn secrets(files: &Files) -> Vec<PathBuf> {
    let truths = [&files.truth, &files.truth_right, &files.truth_noc];
    let truths = truths.into_iter().flatten().map(|file| &file.path);
    truths.chain(&files.mask_nocc).cloned().collect()
}

impl SceneSource {
    /// Loads or renders the scene; files are relative to `folder`.
    pub fn load(&self, id: &str, folder: &Path, render: Render<'_>) -> Result<Scene, String> {
        match &self.within(folder) {
            Self::Files { left, right, truth, truth_encoding, bounds } => {
                let encoding = match truth_encoding {
                    Some(name) => name.parse::<Encoding>().map_err(|error| error.to_string())?,
                    None => Encoding::Auto,
                };
                let files = Files {
                    left: left.clone(),
                    right: right.clone(),
                    truth: Some(TruthFile::new(truth.clone(), encoding)),
                    ..Files::default()
                };
                Scene::load(&Case::new(id, Purpose::Test, files))?.within(bounds.as_deref())
            }
            Self::Rendered { kind, seed, columns, rows, bounds } => {
                let data = render(kind, *seed, *columns, *rows)?;
                Scene::from_data(id, data, Vec::new())?.within(bounds.as_deref())
            }
        }
    }
}

/// Every scene that the scheme's tests need: from the scheme itself, with files relative to
/// `folder`, else from the data sets' `cases`. `remedy` says how to get data sets.
pub fn load_scenes(
    scheme: &Scheme,
    folder: &Path,
    cases: &[Case],
    remedy: &str,
    render: Render<'_>,
) -> Scenes {
    let mut scenes = Scenes::new();
    for test in &scheme.tests {
        let id = &test.scene;
        let load = || match (scheme.scenes.get(id), cases.iter().find(|case| case.id == *id)) {
            (Some(source), _) => source.load(id, folder, render),
            (None, Some(case)) => Scene::load(case),
            (None, None) => Err(format!("it is not among the data sets; {remedy}")),
        };
        let named = |problem: String| format!("scene {id}: {problem}");
        // Tests on one scene may ask for other disparities.
        let scene = scenes.remove(id).unwrap_or_else(|| load().map_err(named));
        let scene = scene.and_then(|scene| {
            scene.check_range(test.max_disparity).map_err(named)?;
            Ok(scene)
        });
        scenes.insert(id.clone(), scene);
    }
    scenes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_of_a_scenes_truth_can_be_found() {
        let image = Image::Grey8(Plane::filled(5, 1, 0));
        // Outside of the box, without a truth, and 0, which is none.
        let truth = Plane::new(5, 1, vec![99.0, 40.0, f32::NAN, 20.0, 0.0]).unwrap();
        let scene = Scene {
            id: "wall".into(),
            left: image.clone(),
            right: image,
            truth,
            non_occluded: None,
            bounds: BoundingBox::new(1, 0, 4, 0).unwrap(),
            secrets: Vec::new(),
        };
        for enough in [20, 40, 55] {
            assert_eq!(scene.check_range(enough), Ok(()));
        }
        let problem = scene.check_range(19).unwrap_err();
        assert!(
            problem.starts_with("100 % of its truth lies beyond max_disparity, 19"),
            "{problem}"
        );
    }

    #[test]
    fn every_file_that_tells_the_truth_is_a_secret() {
        let truth = |name: &str| Some(TruthFile::new(name.into(), Encoding::Auto));
        let files = Files {
            left: "left.png".into(),
            right: "right.png".into(),
            truth: truth("truth.pfm"),
            truth_right: truth("truth-right.pfm"),
            truth_noc: truth("noc.png"),
            unscaled: None,
            mask_nocc: Some("mask.png".into()),
            bounds: Some("box.npy".into()),
            calibration: Some("calib.txt".into()),
        };
        let names = ["truth.pfm", "truth-right.pfm", "noc.png", "mask.png"].map(PathBuf::from);
        assert_eq!(secrets(&files), names);
    }
}
