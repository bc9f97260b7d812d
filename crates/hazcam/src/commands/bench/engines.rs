//! Which engines run, and how.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, bail};
use arena::engine::{Definition, Engines, Limits, Programs};
use glob::Pattern;
use matching::Preset;

use crate::arguments;

/// The matchers that take part, and what they are allowed.
#[derive(clap::Args)]
#[command(next_help_heading = "Matchers")]
pub struct EngineArguments {
    /// Which of hazcam's own matchers run: fast, balanced, best, or none [default: all]
    #[arg(short, long, value_name = "NAME", value_delimiter = ',')]
    #[arg(value_parser = super::super::choice(["fast", "balanced", "best", "none"]))]
    matcher: Vec<String>,

    /// Other engines that run as well, by name; `*` and `?` as in a shell. One that is called by
    /// its whole name and answers on no scene makes the status 2
    #[arg(short, long, value_name = "NAME", value_delimiter = ',')]
    engine: Vec<String>,

    /// A folder with engines of your own, one TOML file each [env: HAZCAM_ENGINES]
    #[arg(long, value_name = "DIR")]
    engines: Option<PathBuf>,

    /// Threads that each engine may use
    #[arg(long, value_name = "N", default_value = "1", value_parser = arguments::threads)]
    #[arg(allow_negative_numbers = true)]
    pub threads: usize,

    /// How often each pair is matched; the times of the median run are shown [default: 1]
    #[arg(long, value_name = "N", value_parser = repeat, allow_negative_numbers = true)]
    repeat: Option<usize>,

    /// Seconds (wall time) after which an engine is killed
    #[arg(long, value_name = "S", default_value = "600")]
    #[arg(value_parser = seconds, allow_negative_numbers = true)]
    time_limit: u64,
}

/// How often a pair is matched.
fn repeat(text: &str) -> Result<usize, String> {
    arguments::whole(text, 1..=10_000)
}

/// How long a pair may take.
fn seconds(text: &str) -> Result<u64, String> {
    let count = text.parse().ok().filter(|&count| count > 0);
    count.ok_or_else(|| "give whole seconds, 1 or more".into())
}

impl EngineArguments {
    /// The engines in the order of their tables. `beside` join hazcam's own when nothing was chosen,
    /// `reference` joins always.
    pub fn definitions(
        &self,
        beside: &[&str],
        reference: Option<&str>,
    ) -> anyhow::Result<Vec<Definition>> {
        let mut known = Engines::built_in();
        if let Some(folder) = arguments::or_variable(self.engines.as_deref(), "HAZCAM_ENGINES") {
            let said_by = if self.engines.is_some() { "--engines" } else { "HAZCAM_ENGINES" };
            known.add_folder(&folder).with_context(|| said_by)?;
        }
        if self.matcher.len() > 1 && self.matcher.iter().any(|name| name == "none") {
            bail!("--matcher none goes with no other: leave it out, or the others");
        }
        let own = Preset::ALL.map(Preset::name);
        let mut wanted: Vec<&str> = match self.matcher.is_empty() {
            true => own.to_vec(),
            false => self.matcher.iter().map(String::as_str).filter(|n| *n != "none").collect(),
        };
        for name in &self.engine {
            let pattern = Pattern::new(name).with_context(|| format!("--engine {name}"))?;
            let before = wanted.len();
            wanted.extend(known.iter().map(|e| e.name.as_str()).filter(|n| pattern.matches(n)));
            if wanted.len() == before {
                known.named(name)?;
            }
        }
        if !self.are_chosen() {
            wanted.extend(beside);
        }
        wanted.extend(reference);
        let mut definitions: Vec<Definition> = Vec::new();
        for name in wanted {
            let definition = known.named(name)?;
            if !definitions.contains(definition) {
                definitions.push(definition.clone());
            }
        }
        if definitions.is_empty() {
            bail!("no matcher is left to run: name one with --matcher or --engine");
        }
        Ok(definitions)
    }

    /// The other engines that the user has called by their names, not by a pattern.
    pub fn called(&self) -> impl Iterator<Item = &str> {
        self.engine.iter().map(String::as_str).filter(|name| Pattern::escape(name) == **name)
    }

    /// The programs that engines may refer to: this one, and Python.
    pub fn programs() -> anyhow::Result<Programs> {
        let this = std::env::current_exe().context("cannot find this program's own file")?;
        Ok(Programs::find(this))
    }

    /// How long a pair may take.
    pub fn limits(&self) -> Limits {
        Limits { wall: Duration::from_secs(self.time_limit), ..Limits::default() }
    }

    /// How often each pair is matched.
    pub fn repeats(&self, default: usize) -> usize {
        self.repeat.unwrap_or(default)
    }

    /// Hazcam's own matchers that the user has chosen by name.
    pub fn presets(&self) -> anyhow::Result<Vec<Preset>> {
        Ok(self.matcher.iter().map(|name| name.parse()).collect::<Result<_, _>>()?)
    }

    /// Whether the user has chosen who runs.
    pub fn are_chosen(&self) -> bool {
        !(self.matcher.is_empty() && self.engine.is_empty())
    }
}
