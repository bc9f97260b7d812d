//! `hazcam.Matcher`: a [`matching::Matcher`] that several Python threads may share.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use matching::{MatchError, Options};
use numpy::PyArray2;
use pyo3::prelude::*;
use raster::{BoundingBox, Image, Plane};

use crate::arguments;
use crate::arrays::from_plane;
use crate::detached::detached;
use crate::doubts;
use crate::errors::{HazcamError, of_matching};
use crate::images::image;

/// A matcher with the options that it was built from.
#[pyclass(frozen, module = "hazcam._hazcam")]
pub struct Matcher {
    options: Options,
    /// Where its threads are: a process that was forked off has none of them.
    process: u32,
    /// Taken out while it works, so that none is left here if it panics; the next frame then makes
    /// another.
    matcher: Mutex<Option<matching::Matcher>>,
    /// Whether pictures of its cameras have been looked at for what is wrong with them.
    has_looked: AtomicBool,
}

/// What was mended of the rows: coefficients, root mean square, largest.
type Vertical = ([f64; 6], f64, f64);

/// A copy of the answer to one pair.
struct Answer {
    values: Plane<f32>,
    reasons: Plane<u8>,
    confidence: Plane<f32>,
    vertical: Option<Vertical>,
    /// What is doubtful about it.
    doubts: Vec<String>,
}

impl Answer {
    fn of(matcher: &matching::Matcher, doubts: Vec<String>) -> Self {
        let (map, vertical) = (matcher.map(), matcher.vertical_disparity());
        Self {
            values: map.values.clone(),
            reasons: map.reasons.map(|&reason| reason as u8),
            confidence: map.confidence.clone(),
            vertical: vertical.map(|v| (v.coefficients(), v.root_mean_square(), v.largest())),
            doubts,
        }
    }
}

/// The same as arrays.
type Arrays<'py> = (
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray2<u8>>,
    Bound<'py, PyArray2<f32>>,
    Option<Vertical>,
    Vec<String>,
);

#[pymethods]
impl Matcher {
    #[new]
    fn new(
        py: Python<'_>,
        preset: &Bound<'_, PyAny>,
        max_disparity: &Bound<'_, PyAny>,
        min_disparity: &Bound<'_, PyAny>,
        threads: &Bound<'_, PyAny>,
        memory: &Bound<'_, PyAny>,
        holes: &Bound<'_, PyAny>,
        without: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let preset = arguments::text("preset", preset, "it must be one of fast, balanced, best")?;
        let range = arguments::range(max_disparity, min_disparity)?;
        let mut options = Options::new(preset.parse().map_err(of_matching)?, range);
        if let Some(threads) = arguments::count("threads", threads, "it must be from 1 to 1024")? {
            options.threads = threads;
        }
        options.memory = arguments::count(
            "memory",
            memory,
            "it must be a number of bytes, such as 400_000_000",
        )?;
        options.holes = arguments::holes(holes)?;
        options.without = arguments::without(without)?;
        let matcher = detached(py, || matching::Matcher::new(options.clone()))?;
        let matcher = Mutex::new(Some(matcher.map_err(of_matching)?));
        Ok(Self { options, process: process::id(), matcher, has_looked: AtomicBool::new(false) })
    }

    fn compute<'py>(
        &self,
        py: Python<'py>,
        left: &Bound<'py, PyAny>,
        right: &Bound<'py, PyAny>,
        r#box: &Bound<'py, PyAny>,
    ) -> PyResult<Arrays<'py>> {
        if process::id() != self.process {
            return Err(HazcamError::new_err(
                "this Matcher was made before the process was forked, and its threads stayed behind: \
                 make one in each process",
            ));
        }
        let (left, right) = (image("left", left)?, image("right", right)?);
        let bounds = arguments::bounding_box(r#box)?;
        let answer = detached(py, || self.answer(&left, &right, bounds))?.map_err(of_matching)?;
        Ok((
            from_plane(py, answer.values),
            from_plane(py, answer.reasons),
            from_plane(py, answer.confidence),
            answer.vertical,
            answer.doubts,
        ))
    }
}

impl Matcher {
    /// Waits for its turn where other threads have given it frames, and matches.
    fn answer(
        &self,
        left: &Image,
        right: &Image,
        bounds: Option<BoundingBox>,
    ) -> Result<Answer, MatchError> {
        let mut kept = self.matcher.lock().unwrap_or_else(PoisonError::into_inner);
        let mut matcher = match kept.take() {
            Some(matcher) => matcher,
            None => matching::Matcher::new(self.options.clone())?,
        };
        let matched = matcher.compute(left, right, bounds).map(|_| ());
        let answer = matched.map(|()| {
            let mut words = doubts::in_words(&matcher, left, right, bounds);
            // Cameras stay what they are, but a first frame may show nothing: a cap on a lens, the dark.
            if !self.has_looked.load(Ordering::Relaxed) {
                self.has_looked.store(words.is_empty(), Ordering::Relaxed);
                words.extend(doubts::of_images(left, right));
            }
            Answer::of(&matcher, words)
        });
        *kept = Some(matcher);
        answer
    }
}
