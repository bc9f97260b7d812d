//! The pair by which a board ranks.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::BoardError;
use super::fingerprint::fingerprint;
use crate::grade::{Render, Scene, SceneSource, Scheme, Test};
use crate::submission::Part;

/// The pair by which a board ranks: one test, on files or on a scene rendered from a secret seed.
///
/// It is written as a scheme with one test and its scene:
/// ```toml
/// name = "Hold-out"
///
/// [[test]]
/// name = "Hold-out"
/// part = "best"
/// scene = "secret"
/// max_disparity = 64
/// max_e_rms = 5.0      # what E_RMS is divided by
/// max_p_bad = 0.11     # what p_bad is divided by
/// points = 0
/// cpu_seconds = 600
///
/// [scene.secret]
/// left = "left.png"
/// right = "right.png"
/// truth = "truth.pfm"
/// box = "10,10,400,300"
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Holdout {
    /// Function, largest disparity, thresholds, limit of CPU time.
    pub test: Test,
    /// Where the scene comes from. Files have absolute paths.
    pub source: SceneSource,
}

impl Holdout {
    /// Martian ground rendered from a seed that nobody knows, judged by the thresholds of Part 2 on
    /// Cones and Teddy. Of the kinds of scenes it tells good matchers from bad ones best: `clutter`
    /// is hard for all, `cards` easy. It may take so many seconds of CPU time.
    pub fn secret(cpu_seconds: f64) -> Result<Self, BoardError> {
        let seed = getrandom::u64()
            .map_err(|error| BoardError::Holdout(format!("gets no secret seed: {error}")))?;
        Ok(Self {
            test: Test {
                name: "Hold-out".into(),
                part: Part::Best,
                scene: "hold-out".into(),
                max_disparity: 64,
                max_e_rms: 5.0,
                max_p_bad: 0.11,
                points: 0.0,
                cpu_seconds,
            },
            source: SceneSource::Rendered {
                kind: "mars".into(),
                // TOML knows no larger numbers.
                seed: seed >> 1,
                columns: None,
                rows: None,
                // As in the course's scenes: what the right camera can see, away from the edges.
                bounds: Some("64,11,440,364".into()),
            },
        })
    }

    /// Reads a hold-out from TOML; files in it are relative to its folder.
    pub fn read(path: &Path) -> Result<Self, BoardError> {
        let wrong = |problem: String| BoardError::Holdout(format!("{}: {problem}", path.display()));
        let text = std::fs::read_to_string(path)
            .map_err(|error| wrong(format!("it cannot be read ({error})")))?;
        let scheme =
            Scheme::parse(&text, path).map_err(|error| BoardError::Holdout(error.to_string()))?;
        let [test] = &scheme.tests[..] else {
            return Err(wrong(format!(
                "it has {} tests; a hold-out is one [[test]]",
                scheme.tests.len()
            )));
        };
        if test.points != 0.0 {
            return Err(wrong(format!(
                "points is {}, but a hold-out gives none, it ranks: write 0",
                test.points
            )));
        }
        let source = scheme.scenes.get(&test.scene).ok_or_else(|| {
            wrong(format!("it has no [scene.{0}]; the test is on `{0}`", test.scene))
        })?;
        let folder = std::path::absolute(path).map_err(|error| wrong(error.to_string()))?;
        let folder = folder.parent().unwrap_or(Path::new("/"));
        let source = source.within(folder);
        if matches!(source, SceneSource::Files { .. }) && folder.to_str().is_none() {
            return Err(wrong(format!(
                "a board cannot remember files in {}, whose name is not UTF-8: rename that folder",
                folder.display()
            )));
        }
        Ok(Self { test: test.clone(), source })
    }

    /// Loads or renders the scene. `board` is the file that holds the secret: entrants must not
    /// reach it.
    pub fn load(&self, board: &Path, render: Render<'_>) -> Result<Scene, BoardError> {
        let mut scene = self
            .source
            .load(&self.test.scene, Path::new(""), render)
            .and_then(|scene| scene.check_range(self.test.max_disparity).map(|()| scene))
            .map_err(|problem| BoardError::Holdout(format!("cannot be used: {problem}")))?;
        // It holds the seed or, as pictures, the truth.
        scene.secrets.push(board.to_owned());
        Ok(scene)
    }

    /// The SHA-256 of what is asked and of every pixel of images and truth: two hold-outs are the
    /// same when this is.
    pub fn fingerprint(&self, scene: &Scene) -> String {
        let test = Test { name: String::new(), scene: String::new(), ..self.test.clone() };
        fingerprint(&[(test, scene)])
    }

    /// What may be said about it in public.
    pub fn describe(&self) -> String {
        let what = match &self.source {
            SceneSource::Files { .. } => "a pair of images".to_owned(),
            SceneSource::Rendered { kind, .. } => {
                format!("a scene of the kind {kind}, rendered from a secret seed")
            }
        };
        format!(
            "{what}; {} is asked for disparities from 0 to {}, within {} s of CPU time",
            self.test.part.function(),
            self.test.max_disparity,
            self.test.cpu_seconds
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::CaseData;
    use raster::{DisparityRange, Image, Plane};

    /// Renders a ramp that depends on the seed.
    fn render(
        kind: &str,
        seed: u64,
        columns: Option<usize>,
        rows: Option<usize>,
    ) -> Result<CaseData, String> {
        assert_eq!(kind, "clutter");
        let (columns, rows) = (columns.unwrap_or(8), rows.unwrap_or(4));
        let image = Image::Grey8(Plane::from_fn(columns, rows, |x, y| (x + y) as u8 ^ seed as u8));
        let range = DisparityRange::new(0, 4).unwrap();
        let mut data = CaseData::new(image.clone(), image, range);
        data.truth = Some(Plane::filled(columns, rows, 2.0));
        Ok(data)
    }

    #[test]
    fn seeds_are_drawn_anew_and_fit_toml() {
        let seed = |holdout: Holdout| match holdout.source {
            SceneSource::Rendered { seed, .. } => seed,
            SceneSource::Files { .. } => panic!("it is rendered"),
        };
        let (one, other) =
            (seed(Holdout::secret(600.0).unwrap()), seed(Holdout::secret(600.0).unwrap()));
        assert_ne!(one, other);
        assert!(i64::try_from(one).is_ok() && i64::try_from(other).is_ok());
    }

    #[test]
    fn the_fingerprint_is_that_of_pixels_and_question() {
        let board = Path::new("/boards/mine");
        let mut holdout = Holdout::secret(600.0).unwrap();
        holdout.source = SceneSource::Rendered {
            kind: "clutter".into(),
            seed: 1,
            columns: None,
            rows: None,
            bounds: None,
        };
        let scene = holdout.load(board, &render).unwrap();
        assert_eq!(scene.secrets, [board]);
        let print = holdout.fingerprint(&scene);
        assert_eq!(print.len(), 64);
        let mut renamed = holdout.clone();
        renamed.test.name = "Another name".into();
        assert_eq!(renamed.fingerprint(&scene), print);
        let mut harder = holdout.clone();
        harder.test.max_disparity = 63;
        assert_ne!(harder.fingerprint(&scene), print);
        let mut changed = scene.clone();
        changed.truth.samples_mut()[3] = 2.5;
        assert_ne!(holdout.fingerprint(&changed), print);
        let mut changed = scene;
        changed.bounds.x1 -= 1;
        assert_ne!(holdout.fingerprint(&changed), print);
    }

    #[test]
    fn a_file_is_one_test_with_its_scene() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("holdout.toml");
        let test = "name = 'h'\n[[test]]\nname = 'a'\npart = 'best'\nscene = 's'\n\
                    max_disparity = 9\nmax_e_rms = 1\nmax_p_bad = 0.1\npoints = 0\ncpu_seconds = 1\n";
        let refused = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Holdout::read(&path).unwrap_err().to_string()
        };
        assert!(refused(test).contains("it has no [scene.s]"));
        let again = test.replace("name = 'h'\n", "").replace("'a'", "'b'");
        assert!(refused(&format!("{test}{again}")).contains("it has 2 tests"));
        assert!(refused("nonsense").contains("holdout.toml"));
        let scene = "[scene.s]\nleft = 'l.png'\nright = 'r.png'\ntruth = 't.pfm'\n";
        let strictest = test.replace("max_p_bad = 0.1", "max_p_bad = 0");
        assert!(refused(&format!("{strictest}{scene}")).contains("max_p_bad is 0, but it must"));
        let paying = test.replace("points = 0", "points = 7");
        assert!(
            refused(&format!("{paying}{scene}")).contains("points is 7, but a hold-out gives none")
        );
        std::fs::write(&path, format!("{test}{scene}")).unwrap();
        let holdout = Holdout::read(&path).unwrap();
        let SceneSource::Files { left, .. } = &holdout.source else { panic!("files") };
        assert_eq!(*left, folder.path().join("l.png"));
        let error = holdout.load(Path::new("/b"), &render).unwrap_err().to_string();
        assert!(error.contains("l.png"), "{error}");
    }
}
