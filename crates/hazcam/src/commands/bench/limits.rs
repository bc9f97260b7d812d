//! Figures that matchers are held to: a file of limits, scene by scene.
//!
//! ```toml
//! [fast."course/cones"]    # matcher, scene
//! E_RMS = 3.27             # measures as in `hazcam score`, over all pixels; shares from 0 to 1, or "5%"
//! p_bad = 0.083
//! ```
//! A scene or matcher that a file names and a run lacks is an error: nothing passes unseen.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use arena::record::Record;
use serde::Deserialize;

use crate::commands::score::threshold::Threshold;

/// Limits by matcher and scene.
pub struct Limits {
    path: PathBuf,
    by_engine: BTreeMap<String, BTreeMap<String, Vec<Threshold>>>,
}

/// A limit as it is written.
#[derive(Deserialize)]
#[serde(untagged)]
enum Figure {
    Number(f64),
    /// In per cent.
    Text(String),
}

impl Limits {
    /// Reads a file of limits. Errors when it is none, or names a measure that there is not.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let numbers: BTreeMap<String, BTreeMap<String, BTreeMap<String, Figure>>> =
            toml::from_str(&text).with_context(|| {
                format!(
                    "{} holds no limits: they look like [fast.\"course/cones\"] with lines like \
                     p_bad = 0.083 below",
                    path.display()
                )
            })?;
        let threshold = |(measure, value): (String, Figure)| {
            let threshold = match value {
                Figure::Number(value) => Threshold::new(&measure, value),
                Figure::Text(text) => format!("{measure}={text}").parse(),
            };
            threshold
                .map_err(anyhow::Error::msg)
                .with_context(|| format!("{}: {measure}", path.display()))
        };
        let mut by_engine = BTreeMap::<_, BTreeMap<_, _>>::new();
        for (engine, scenes) in numbers {
            let scenes_of_engine = by_engine.entry(engine).or_default();
            for (scene, figures) in scenes {
                let figures: Vec<_> =
                    figures.into_iter().map(threshold).collect::<Result<_, _>>()?;
                scenes_of_engine.insert(scene, figures);
            }
        }
        if by_engine.values().flat_map(BTreeMap::values).all(Vec::is_empty) {
            bail!(
                "{} holds no limits: with none, every run would pass; write lines like p_bad = 0.083 below \
                 [fast.\"course/cones\"]",
                path.display()
            );
        }
        Ok(Self { path: path.to_owned(), by_engine })
    }

    /// Every figure past its limit, in words. Errors when a scene or matcher is missing.
    pub fn broken(&self, records: &[Record]) -> anyhow::Result<Vec<String>> {
        let mut broken = Vec::new();
        for (engine, scenes) in &self.by_engine {
            for (scene, figures) in scenes {
                let Some(record) = records.iter().find(|r| r.engine == *engine && r.case == *scene)
                else {
                    bail!(
                        "{} holds {engine} to figures on {scene}, but that was not run: choose \
                         scenes and matchers so that it is",
                        self.path.display()
                    );
                };
                for limit in figures {
                    let value = record.value("all", limit.measure());
                    // Of what was not answered it says why.
                    let why = match value {
                        Some(_) => String::new(),
                        None => format!(" ({})", record.status.name()),
                    };
                    let over = limit.exceeded(value);
                    broken.extend(over.map(|over| format!("{engine} on {scene}: {over}{why}")));
                }
            }
        }
        Ok(broken)
    }
}
