//! `hazcam board add`: grades an entrant, runs it on the hold-out, enters it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, anyhow, bail};
use arena::board::{
    Added, Board, BoardError, Entry, Holdout, Owner, Picture, SceneTruth, is_owner, standings,
    tests_fingerprint,
};
use arena::grade::output::text;
use arena::grade::{Entrant, Outcome, Scene, Scheme};
use arena::record::Machine;
use arena::submission::{Part, is_secret_id};

use crate::commands::grade::entrant::EntrantArguments;
use crate::commands::grade::grading::{GradingArguments, Workshop};
use crate::commands::grade::scenes;
use crate::ui::Ui;

/// What an honest loop in plain Python may take on a scene as small as the rendered one, where no test says otherwise.
const CPU_SECONDS: f64 = 600.0;

const NAMELESS: &str =
    "it has no usable secret ID: mend secret_id.py, or give one with --secret-id";

/// Grade an entrant and enter it, in the place of its owner's earlier entry
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    entrant: EntrantArguments,

    #[command(flatten)]
    grading: GradingArguments,

    /// Whose entry it is: everybody has one. No page shows it, `hazcam board show --owners` does. Where it is
    /// not given, an earlier entry is replaced only by one of the same secret ID
    /// [default: the submission's name without its ending, or the engines']
    #[arg(long, value_name = "NAME", help_heading = "Entry")]
    owner: Option<String>,

    /// The name on the board, 4 to 32 printable characters, no space at an end
    /// [default: what secret_id() returns, or the engines' names]
    #[arg(long, value_name = "NAME", help_heading = "Entry")]
    secret_id: Option<String>,

    /// Show it for comparison only, without place and bonus
    #[arg(long, help_heading = "Entry")]
    baseline: bool,

    /// Grade a submission that is on the board already as it is, too: it is passed over otherwise, so that the loop
    /// over a class can be run again
    #[arg(long, help_heading = "Entry")]
    again: bool,

    /// The hold-out of a board that is begun now: a scheme with one test and its scene, as TOML
    /// [default: a scene rendered from a secret seed]
    #[arg(long, value_name = "FILE", help_heading = "Entry")]
    holdout: Option<PathBuf>,
}

/// Grades, showing each test as `grade` does, and enters the results.
pub fn run(path: &Path, args: &Args, ui: &Ui) -> anyhow::Result<ExitCode> {
    args.entrant.check()?;
    let guessed = args.entrant.owner();
    let owner = match &args.owner {
        Some(name) => Owner::Given(name),
        None => Owner::Guessed(&guessed),
    };
    if !is_owner(owner.name()) {
        let owner = owner.name();
        bail!(
            "`{owner}` cannot name an owner: give 1 to 200 printable characters, no space at an end, the first of \
             them none of = + - @, with --owner"
        );
    }
    if let Some(id) = args.secret_id.as_ref().filter(|id| !is_secret_id(id)) {
        bail!(BoardError::Name(id.clone()));
    }
    let workshop = Workshop::open(&args.grading)?;
    args.entrant.keep_from(workshop.scene_files())?;
    args.entrant.keep_from(&[std::path::absolute(path)?])?;
    let (name, entrant) = args.entrant.open(&workshop)?;
    let refused = || format!("{name} is not entered");
    // Only now: who is not there begins no board.
    let (mut board, holdout, scene) = open(path, args, &workshop)?;
    // What is refused in the end is refused before the work.
    let tests = tests_fingerprint(workshop.tests());
    board.admit_tests(owner, (&workshop.scheme().name, &tests))?;
    let handin = match &entrant {
        Entrant::Submission(submission) => Some(submission.digest()?),
        _ => None,
    };
    let kept = board.entry_of(owner.name())?;
    if !args.again
        && let Some(kept) = &kept
        && args.stands_as(kept, handin.as_ref(), &tests)
        && !has_longer(kept, workshop.scheme())
    {
        ui.print(&format!(
            "`{}` of {} stands as it is since {}: the same files, the same tests (--again grades them again)\n",
            kept.secret_id,
            owner.name(),
            kept.added
        ))?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Entrant::Refused(why) = &entrant
        && let Some(kept) = &kept
    {
        let stands = format!("{}; the entry `{}` of {}", refused(), kept.secret_id, owner.name());
        return Err(anyhow!("{why}").context(format!("{stands} stays as it is")));
    }
    let given = args.secret_id.clone().or(args.entrant.matcher()).filter(|id| is_secret_id(id));
    if let Some(id) = &given {
        board.admit(owner, id)?;
    }
    let mut grader = workshop.grader()?;
    // The scheme's tests must not tell what the hold-out is either.
    grader.secrets = scene.secrets.clone();
    args.grading.warn_if_unconfined(ui);
    ui.print(&text::header(&grader, &name))?;
    let mut inspection = grader.inspect(&entrant);
    ui.print(&text::findings(&inspection.findings))?;
    // A name that was given by `rename` stays, whatever the next hand-in calls itself.
    let renamed = match kept {
        Some(kept) if given.is_none() && kept.renamed => {
            // Whose a file is that is only called alike its content tells.
            let is_owners = matches!(owner, Owner::Given(_)) || kept.handin == handin;
            is_owners.then_some(kept.secret_id)
        }
        _ => None,
    };
    if renamed.is_some() {
        inspection.secret_id.clone_from(&renamed);
    }
    let secret_id = given.or(inspection.secret_id.clone());
    match (&secret_id, &entrant) {
        (Some(id), _) => board.admit(owner, id).with_context(refused)?,
        // What cannot be looked at has no findings: its results say why.
        (None, Entrant::Submission(_)) if !inspection.findings.is_empty() => {
            return Err(anyhow!(NAMELESS).context(refused()));
        }
        (None, _) => (),
    }
    let mut shown = Ok(());
    let report = grader.grade(&name, &entrant, inspection, &mut |event| {
        if shown.is_ok() {
            shown = ui.print(&text::event(&event));
        }
    });
    shown?;
    ui.print(&text::begins(&holdout.test))?;
    let result = grader.extra(&entrant, &holdout.test, &scene);
    ui.print(&text::ended(&result))?;
    ui.print(&text::summary(&report))?;
    if report.grader_failed() || result.outcome == Outcome::Xx {
        return Err(
            anyhow!("the grader failed: mend what it says and add again").context(refused())
        );
    }
    let secret_id = secret_id.context(NAMELESS).with_context(refused)?;
    let scenes: Vec<(String, &Scene)> =
        workshop.tests().map(|(test, scene)| (test.name.clone(), scene)).collect();
    let mut pictures: Vec<Picture> = report
        .tests
        .iter()
        .zip(&scenes)
        .filter_map(|(test, (_, scene))| Picture::of(test, scene))
        .collect();
    pictures.extend(Picture::of(&result, &scene));
    let mut truths: Vec<SceneTruth> =
        scenes.iter().filter_map(|(test, scene)| SceneTruth::of(test, scene)).collect();
    truths.extend(SceneTruth::of(&holdout.test.name, &scene));
    let entry = Entry {
        secret_id: secret_id.clone(),
        renamed: renamed.is_some(),
        baseline: args.baseline,
        added: String::new(),
        tests,
        handin,
        report,
        holdout: result,
        machine: describe(&Machine::this(None)),
    };
    let added = board.add(owner, &entry, &pictures, &truths)?;
    let standings = standings(board.entries()?, &holdout.test);
    let standing = standings.iter().find(|standing| standing.entry.secret_id == secret_id);
    let place = match standing.and_then(|standing| standing.place) {
        Some(place) => {
            let placed = standings.iter().filter(|standing| standing.place.is_some()).count();
            format!("place {place} of {placed}")
        }
        None if args.baseline => "a baseline".into(),
        None => "without a place, since it has no answer on the hold-out".into(),
    };
    let before = match added {
        Added::New => String::new(),
        Added::Replaced(before) => {
            let keeps = format!(" (--secret-id '{before}' keeps that name)");
            let keeps = if before == secret_id { "" } else { &keeps };
            format!(", in the place of the earlier entry `{before}` of {}{keeps}", owner.name())
        }
    };
    let kept = if renamed.is_some() {
        ", under the name that it was given (--secret-id gives another)"
    } else {
        ""
    };
    ui.print(&format!("Entered `{secret_id}`: {place}{before}{kept}\n"))?;
    for doubt in standing.map_or(&[][..], |standing| &standing.doubts) {
        ui.warn(format_args!("`{secret_id}` is doubtful: {doubt}"));
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    /// Whether an entry is what would be entered: the same files, graded by the same tests, under the same name.
    fn stands_as(&self, kept: &Entry, handin: Option<&String>, tests: &str) -> bool {
        let is_called_so = self.secret_id.as_ref().is_none_or(|id| *id == kept.secret_id);
        kept.is_of(handin.map(String::as_str), tests)
            && is_called_so
            && self.baseline == kept.baseline
    }
}

/// Whether a test that ran out of time would have longer now.
fn has_longer(kept: &Entry, scheme: &Scheme) -> bool {
    let ran_out = kept.report.tests.iter().filter(|test| test.outcome == Outcome::To);
    ran_out.into_iter().any(|test| {
        let now = scheme.tests.iter().find(|now| now.name == test.name);
        now.is_some_and(|now| now.cpu_seconds > test.cpu_limit_seconds)
    })
}

/// The board, begun if there is none, with its hold-out as it was when the board was begun.
fn open(path: &Path, args: &Args, workshop: &Workshop) -> anyhow::Result<(Board, Holdout, Scene)> {
    let scheme = workshop.scheme();
    let (path, given) = (&std::path::absolute(path)?, args.holdout.as_deref());
    let is_begun = path.metadata().is_ok_and(|found| found.len() > 0);
    let begun = is_begun.then(|| Board::open(path)).transpose()?;
    let holdout = match (given, &begun) {
        (Some(given), _) => Holdout::read(given)?,
        (None, Some(board)) => board.holdout()?.0,
        (None, None) => {
            // As long as the shortest test of the same part: it is a small scene, and what hangs there hangs here too.
            let of_best = scheme.tests.iter().filter(|test| test.part == Part::Best);
            let limits = of_best.map(|test| test.cpu_seconds);
            Holdout::secret(limits.reduce(f64::min).unwrap_or(CPU_SECONDS))?
        }
    };
    let name = &holdout.test.name;
    if scheme.tests.iter().any(|test| test.name == *name) {
        // An entry keeps one picture for each name.
        bail!(
            "the hold-out is called `{name}`, and so is a test of the scheme `{}`: give that test \
             another name{}",
            scheme.name,
            if begun.is_some() { "" } else { ", or the hold-out" },
        );
    }
    workshop.check_scenes()?;
    let mut scene = holdout.load(path, &scenes::render)?;
    // It may name the seed.
    scene.secrets.extend(given.map(Path::to_owned));
    args.entrant.keep_from(&scene.secrets)?;
    let fingerprint = holdout.fingerprint(&scene);
    let board = match begun {
        Some(board) => board,
        None => Board::open_or_begin(path, &holdout, &fingerprint)?,
    };
    if board.holdout()?.1 == fingerprint {
        return Ok((board, holdout, scene));
    }
    if !is_begun {
        // Somebody else began it in the meantime.
        return open(path, args, workshop);
    }
    bail!(
        "the board {} ranks on another hold-out{}: entries on different ones cannot be compared; \
         begin another board",
        path.display(),
        if given.is_some() { "" } else { ", or its files were changed since it was begun" },
    )
}

/// A machine in a line.
fn describe(machine: &Machine) -> String {
    let Machine { cpu, cores, architecture, system, .. } = machine;
    let cpu = cpu.as_deref().unwrap_or("unknown processor");
    format!("{cpu}, {cores} cores, {architecture}, {system}")
}
