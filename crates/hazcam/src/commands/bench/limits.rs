//! Figures that matchers are held to: a file of limits, scene by scene.
//!
//! ```toml
//! [fast."course/cones"]    # matcher, scene
//! E_RMS = 3.27             # measures as in `hazcam score`, over all pixels; shares from 0 to 1
//! p_bad = 0.083
//! ```
//! A scene or matcher that a file names and a run lacks is an error: nothing passes unseen.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use arena::record::Record;
use score::{Measure, Unit};

type Figures = BTreeMap<String, f64>;

/// Limits by matcher and scene.
pub struct Limits {
    path: PathBuf,
    by_engine: BTreeMap<String, BTreeMap<String, Figures>>,
}

impl Limits {
    /// Reads a file of limits. Errors when it is none, or names a measure that there is not.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text =
            fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let by_engine: BTreeMap<String, BTreeMap<String, Figures>> = toml::from_str(&text)
            .with_context(|| {
                format!(
                    "{} holds no limits: they look like [fast.\"course/cones\"] with lines like \
                     p_bad = 0.083 below",
                    path.display()
                )
            })?;
        for (name, limit) in by_engine.values().flat_map(BTreeMap::values).flatten() {
            let Some(measure) = Measure::named(name) else {
                let known: Vec<_> = Measure::ALL.iter().map(|measure| measure.name).collect();
                bail!(
                    "{}: there is no measure `{name}`; there are {}",
                    path.display(),
                    known.join(", ")
                );
            };
            if measure.unit == Unit::Share && *limit > 1.0 {
                // It would never be exceeded.
                bail!(
                    "{}: {name} is a share from 0 to 1, but its limit is {limit}",
                    path.display()
                );
            }
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
                for (measure, &limit) in figures {
                    match record.value("all", measure) {
                        Some(value) if value <= limit => {}
                        Some(value) => broken.push(format!(
                            "{engine} on {scene}: {measure} is {value:.4}, over {limit}"
                        )),
                        None => broken.push(format!(
                            "{engine} on {scene}: there is no {measure} ({})",
                            record.status.name()
                        )),
                    }
                }
            }
        }
        Ok(broken)
    }
}
