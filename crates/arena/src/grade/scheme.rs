//! What is tested and what it is worth: data, so that an instructor can change it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::SchemeError;
use crate::submission::Part;

/// The course's six tests, `grading/course.toml`.
pub const COURSE: &str = include_str!("../../grading/course.toml");

/// The longest limit of CPU time: longer than any grading lasts, and clocks can count it.
pub const MOST_SECONDS: f64 = 1e6;

/// Tests with their thresholds and points, and where their scenes come from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scheme {
    /// What it is called in reports.
    pub name: String,
    /// The tests, in the order in which they are run.
    #[serde(rename = "test")]
    pub tests: Vec<Test>,
    /// Scenes that are defined here; any other is looked up among the data sets.
    #[serde(default, rename = "scene")]
    pub scenes: BTreeMap<String, SceneSource>,
}

/// One test: one function on one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Test {
    /// Unique in the scheme.
    pub name: String,
    /// Which of the entrant's functions.
    pub part: Part,
    /// On which scene.
    pub scene: String,
    /// The largest disparity to search, in pixels, inclusive; the smallest is 0.
    pub max_disparity: u32,
    /// The root mean square error passes below this, in pixels.
    pub max_e_rms: f64,
    /// The share of bad pixels passes below this.
    pub max_p_bad: f64,
    /// Points when both pass.
    pub points: f64,
    /// Limit of CPU time, from the job to its answer.
    pub cpu_seconds: f64,
}

/// Where a scene that is no data set of its own comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, try_from = "SceneFields")]
pub enum SceneSource {
    /// Files, relative to the folder of the file that names them.
    Files {
        /// Left image.
        left: PathBuf,
        /// Right image.
        right: PathBuf,
        /// Ground truth for the left image.
        truth: PathBuf,
        /// How the truth is stored, as in `hazcam score --truth-encoding`; by the file if absent.
        truth_encoding: Option<String>,
        /// `x0,y0,x1,y1` inclusive, or a `.npy` file; all of the image if absent.
        #[serde(rename = "box")]
        bounds: Option<String>,
    },
    /// Rendered from a seed.
    Rendered {
        /// The kind of scene, as in `hazcam demo`.
        kind: String,
        /// The seed: another one is another scene.
        seed: u64,
        /// Width in pixels; the kind's own if absent.
        columns: Option<usize>,
        /// Height in pixels; the kind's own if absent.
        rows: Option<usize>,
        /// `x0,y0,x1,y1` inclusive; all of the image if absent.
        #[serde(rename = "box")]
        bounds: Option<String>,
    },
}

/// What may be said of a scene: `kind` tells which of it belongs together.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFields {
    left: Option<PathBuf>,
    right: Option<PathBuf>,
    truth: Option<PathBuf>,
    truth_encoding: Option<String>,
    kind: Option<String>,
    seed: Option<u64>,
    columns: Option<usize>,
    rows: Option<usize>,
    #[serde(rename = "box")]
    bounds: Option<String>,
}

impl TryFrom<SceneFields> for SceneSource {
    type Error = String;

    fn try_from(fields: SceneFields) -> Result<Self, String> {
        let SceneFields { left, right, truth, truth_encoding, kind, seed, columns, rows, bounds } =
            fields;
        let of_files = [
            ("left", left.is_some()),
            ("right", right.is_some()),
            ("truth", truth.is_some()),
            ("truth_encoding", truth_encoding.is_some()),
        ];
        let of_rendered =
            [("seed", seed.is_some()), ("columns", columns.is_some()), ("rows", rows.is_some())];
        let first = |fields: &[(&'static str, bool)]| {
            fields.iter().find(|(_, is_there)| *is_there).map(|(name, _)| *name)
        };
        let missing = |name: &str, of: &str| format!("`{name}` is missing: {of}");
        match kind {
            Some(kind) => match first(&of_files) {
                Some(name) => Err(format!(
                    "`{name}` is of a scene in files and `kind` of a rendered one: remove either"
                )),
                None => {
                    let seed = seed.ok_or_else(|| missing("seed", RENDERED))?;
                    Ok(Self::Rendered { kind, seed, columns, rows, bounds })
                }
            },
            None => match first(&of_rendered) {
                Some(_) => Err(missing("kind", RENDERED)),
                None if left.is_some() && left == right => {
                    Err("`left` and `right` are one file: a pair shows the scene from two places"
                        .into())
                }
                None => Ok(Self::Files {
                    left: left.ok_or_else(|| missing("left", FILES))?,
                    right: right.ok_or_else(|| missing("right", FILES))?,
                    truth: truth.ok_or_else(|| missing("truth", FILES))?,
                    truth_encoding,
                    bounds,
                }),
            },
        }
    }
}

const FILES: &str = "a scene in files has left, right and truth, a rendered one kind and seed";
const RENDERED: &str = "a rendered scene has kind and seed";

impl SceneSource {
    /// The same with files below `folder`, unless their paths are absolute.
    pub fn within(&self, folder: &Path) -> Self {
        let mut this = self.clone();
        if let Self::Files { left, right, truth, bounds, .. } = &mut this {
            for path in [left, right, truth] {
                *path = folder.join(&*path);
            }
            if let Some(bounds) = bounds.as_mut().filter(|bounds| bounds.ends_with(".npy")) {
                *bounds = folder.join(&*bounds).to_string_lossy().into_owned();
            }
        }
        this
    }
}

impl Scheme {
    /// Reads a scheme from the text of `path`, which only messages mention.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SchemeError> {
        let malformed = |problem: String| SchemeError { path: path.to_owned(), problem };
        let scheme: Self =
            toml::from_str(text).map_err(|e| malformed(e.to_string().trim_end().into()))?;
        scheme.check().map_err(malformed)?;
        Ok(scheme)
    }

    /// The course's six tests.
    pub fn course() -> Self {
        Self::parse(COURSE, Path::new("course.toml")).expect("the scheme that is built in is sound")
    }

    /// All points.
    pub fn points(&self) -> f64 {
        total(self.tests.iter().map(|test| test.points))
    }

    fn check(&self) -> Result<(), String> {
        if self.tests.is_empty() {
            return Err("it has no [[test]]".into());
        }
        for (at, test) in self.tests.iter().enumerate() {
            let name = &test.name;
            if self.tests[..at].iter().any(|other| other.name == *name) {
                return Err(format!("two tests are called `{name}`; names must be unique"));
            }
            test.check().map_err(|problem| format!("test `{name}`: {problem}"))?;
        }
        Ok(())
    }
}

impl Test {
    fn check(&self) -> Result<(), String> {
        let positive = |field, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(format!("{field} is {value}, but it must be a number greater than 0")),
        };
        if self.name.trim().is_empty() {
            return Err("name is blank: reports and boards tell tests apart by it".into());
        }
        positive("max_e_rms", self.max_e_rms)?;
        positive("max_p_bad", self.max_p_bad)?;
        positive("cpu_seconds", self.cpu_seconds)?;
        if self.cpu_seconds > MOST_SECONDS {
            return Err(format!(
                "cpu_seconds is {}, but it must be at most {MOST_SECONDS} seconds",
                self.cpu_seconds
            ));
        }
        if self.max_p_bad > 1.0 {
            return Err(format!(
                "max_p_bad is {}, but it is a share and must be at most 1",
                self.max_p_bad
            ));
        }
        if !(self.points.is_finite() && self.points >= 0.0) {
            return Err(format!("points is {}, but it must be 0 or more", self.points));
        }
        if !(1..=4096).contains(&self.max_disparity) {
            return Err(format!(
                "max_disparity is {}, but it must be from 1 to 4096 pixels",
                self.max_disparity
            ));
        }
        Ok(())
    }
}

/// A sum of points, rounded: tenths are not exact, and what they lack would add up.
pub(super) fn total(points: impl Iterator<Item = f64>) -> f64 {
    const STEPS: f64 = 1e6;
    (points.sum::<f64>() * STEPS).round() / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_course_has_six_tests_and_fifty_points() {
        let scheme = Scheme::course();
        assert_eq!((scheme.tests.len(), scheme.points()), (6, 50.0));
        let points: Vec<f64> = scheme.tests.iter().map(|test| test.points).collect();
        assert_eq!(points, [6.0, 7.0, 7.0, 10.0, 10.0, 10.0]);
        assert_eq!(scheme.tests.iter().filter(|test| test.part == Part::Fast).count(), 3);
    }

    #[test]
    fn a_mistake_is_named_with_its_test() {
        let refused = |from: &str, to: &str| {
            assert!(COURSE.contains(from));
            let error = Scheme::parse(&COURSE.replacen(from, to, 1), Path::new("mine.toml"));
            error.unwrap_err().to_string()
        };
        let text = refused("max_p_bad = 0.17", "max_p_bad = 17");
        assert!(text.starts_with("mine.toml: test `Part 1, Cones`: max_p_bad is 17"), "{text}");
        assert!(refused("Part 1, Teddy", "Part 1, Cones").contains("names must be unique"));
        assert!(refused("points = 6", "point = 6").contains("unknown field `point`"));
        assert!(refused("cpu_seconds = 600", "cpu_seconds = 0").contains("greater than 0"));
        assert!(refused("Part 1, Cones", " ").contains("name is blank"));
        assert!(refused("max_disparity = 55", "max_disparity = 0").contains("from 1 to 4096"));
        assert!(refused("max_p_bad = 0.17", "max_p_bad = 0").contains("greater than 0"));
        let text = refused("cpu_seconds = 600", "cpu_seconds = 1e300");
        assert!(text.contains("must be at most 1000000 seconds"), "{text}");
        let none = Scheme::parse("name = 'x'\ntest = []", Path::new("a")).unwrap_err();
        assert!(none.to_string().contains("no [[test]]"));
    }

    #[test]
    fn a_mistake_in_a_scene_is_named() {
        let refused = |scene: &str| {
            let text = format!("{COURSE}\n[scene.mine]\n{scene}\n");
            Scheme::parse(&text, Path::new("mine.toml")).unwrap_err().to_string()
        };
        let files = "left = 'l.png'\nright = 'r.png'\ntruth = 't.pfm'\n";
        let rendered = "kind = 'mars'\nseed = 1\n";
        for (scene, words) in [
            (format!("{files}boks = '0,0,1,1'"), "unknown field `boks`"),
            (files.replace("right", "truth_encoding"), "`right` is missing: a scene in files has"),
            (files.replace("r.png", "l.png"), "`left` and `right` are one file"),
            (format!("{rendered}columns = -4"), "invalid value: integer `-4`"),
            (format!("{rendered}colums = 4"), "unknown field `colums`"),
            ("kind = 'mars'".into(), "`seed` is missing: a rendered scene has kind and seed"),
            ("seed = 1".into(), "`kind` is missing"),
            (
                format!("{rendered}{files}"),
                "`left` is of a scene in files and `kind` of a rendered",
            ),
            (String::new(), "`left` is missing: a scene in files has left, right and truth, a ren"),
        ] {
            let error = refused(&scene);
            assert!(error.starts_with("mine.toml: ") && error.contains(words), "{error}");
        }
    }

    #[test]
    fn scenes_can_be_files_or_rendered() {
        let text = r#"
            name = "mine"
            [[test]]
            name = "a"
            part = "best"
            scene = "wall"
            max_disparity = 16
            max_e_rms = 1.0
            max_p_bad = 0.1
            points = 1
            cpu_seconds = 5
            [scene.wall]
            left = "l.png"
            right = "r.png"
            truth = "t.pfm"
            box = "1,2,3,4"
            [scene."my/room"]
            kind = "clutter"
            seed = 7
        "#;
        let scheme = Scheme::parse(text, Path::new("mine.toml")).unwrap();
        assert!(
            matches!(&scheme.scenes["wall"], SceneSource::Files { bounds: Some(b), .. } if b == "1,2,3,4")
        );
        assert!(matches!(&scheme.scenes["my/room"], SceneSource::Rendered { seed: 7, .. }));
    }
}
