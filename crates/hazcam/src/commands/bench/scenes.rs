//! Which scenes on disk take part.

use std::path::PathBuf;

use anyhow::{Context, bail};
use arena::dataset::{self, Case, Purpose};
use glob::Pattern;

use crate::arguments::or_variable;
use crate::ui::Ui;

/// The scenes that take part.
#[derive(clap::Args)]
#[command(next_help_heading = "Scenes")]
pub struct SceneArguments {
    /// Folder with the data sets: a scenes.json, or the layouts of the course, Middlebury, ETH3D,
    /// KITTI [env: HAZCAM_DATA]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,

    /// Only scenes whose id matches, `*` and `?` as in a shell
    #[arg(long, value_name = "GLOB")]
    pub scenes: Option<String>,

    /// Only scenes of this use [default: all that have truth]
    #[arg(long = "use", value_name = "USE", id = "purpose")]
    #[arg(value_parser = super::super::choice(Purpose::ALL.map(Purpose::name)))]
    purpose: Option<String>,
}

impl SceneArguments {
    /// The chosen scenes, the course's first. Without `--use`, those of `default`.
    pub fn cases(&self, default: &[Purpose], ui: &Ui) -> anyhow::Result<Vec<Case>> {
        let Some((folder, mut cases)) = self.on_disk()? else {
            bail!(
                "there is no data: HAZCAM_DATA is not set and --data is not given; point either at \
                 a folder with Middlebury (vision.middlebury.edu/stereo/data), KITTI \
                 (cvlibs.net/datasets/kitti) or ETH3D (eth3d.net) scenes as they unpack, or run \
                 `hazcam demo`, which needs none"
            );
        };
        let others = match self.purpose {
            None => self.of_another_use(&cases, default),
            Some(_) => None,
        };
        match &self.purpose {
            Some(purpose) => {
                let purpose: Purpose = purpose.parse().map_err(anyhow::Error::msg)?;
                cases.retain(|case| case.purpose == purpose);
            }
            None => {
                cases.retain(|case| default.contains(&case.purpose));
                let (with, without): (Vec<_>, Vec<_>) =
                    cases.into_iter().partition(Case::has_truth);
                match without_truth(&without) {
                    Some(said) if with.is_empty() => bail!("{}: {said}", folder.display()),
                    Some(said) => ui.note(format_args!("left out of {}: {said}", folder.display())),
                    None => {}
                }
                cases = with;
            }
        }
        if cases.is_empty() && self.purpose.is_none() {
            bail!(
                "{} has no scene with truth: name its truth in scenes.json, or match pairs without \
                 any by --use rover",
                folder.display()
            );
        } else if cases.is_empty() {
            let purpose = self.purpose.as_deref().unwrap_or_default();
            bail!(
                "{} has no scene of the use that was asked for, --use {purpose}",
                folder.display()
            );
        }
        let chosen = matching(cases, |case| &case.id, self.scenes.as_deref());
        chosen.map_err(|error| others.map_or(error, anyhow::Error::msg))
    }

    /// Says that there are scenes that are asked for, but of a use that is not taken by default.
    fn of_another_use(&self, cases: &[Case], default: &[Purpose]) -> Option<String> {
        let text = self.scenes.as_deref()?;
        let pattern = Pattern::new(text).ok()?;
        let fits = |case: &&Case| !default.contains(&case.purpose) && pattern.matches(&case.id);
        let Case { id, purpose, .. } = cases.iter().find(fits)?;
        Some(format!(
            "`{text}` matches {id}, which is of the use {purpose}: give --use {purpose} too"
        ))
    }

    /// All scenes of the folder that is named, whatever their use; nothing when none is named.
    pub fn on_disk(&self) -> anyhow::Result<Option<(PathBuf, Vec<Case>)>> {
        let Some(folder) = or_variable(self.data.as_deref(), "HAZCAM_DATA") else {
            return Ok(None);
        };
        let said_by = if self.data.is_some() { "--data" } else { "HAZCAM_DATA" };
        let cases = dataset::open(&folder).with_context(|| said_by)?;
        Ok(Some((folder, cases)))
    }
}

/// What to say of scenes that have no truth.
fn without_truth(cases: &[Case]) -> Option<String> {
    let unscaled = cases.iter().find_map(|case| case.files()?.unscaled.as_deref());
    let first = cases.first()?;
    let others = match cases.len() - 1 {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    let why = unscaled.map_or_else(String::new, |path| {
        format!(
            "; {} is truth times a number that neither its folder nor its scene tells: put scenes of Middlebury 2005 \
             and 2006 below a folder ThirdSize, HalfSize or FullSize",
            path.display()
        )
    });
    Some(format!("{}{others} without truth{why}; truths can be named in scenes.json", first.id))
}

/// The scenes whose `id` matches. Errors when none does, naming some that there are.
pub fn matching<T>(
    scenes: Vec<T>,
    id: impl Fn(&T) -> &str,
    pattern: Option<&str>,
) -> anyhow::Result<Vec<T>> {
    let Some(text) = pattern else { return Ok(scenes) };
    let pattern = Pattern::new(text).with_context(|| format!("--scenes {text}"))?;
    let (chosen, rest): (Vec<_>, Vec<_>) =
        scenes.into_iter().partition(|scene| pattern.matches(id(scene)));
    if chosen.is_empty() {
        let known: Vec<_> = rest.iter().take(6).map(&id).collect();
        let more = rest.len().saturating_sub(known.len());
        bail!(
            "no scene matches `{text}`; there are {}{}",
            known.join(", "),
            if more > 0 { format!(" and {more} more") } else { String::new() }
        );
    }
    Ok(chosen)
}
