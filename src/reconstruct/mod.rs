//! `patterns reconstruct`: from a picture that is hidden in part to its model and its whole.

mod answer;
pub mod evaluate;
mod outputs;
mod search;
mod sources;

use crate::{
    database,
    folder::Folder,
    inputs::FileInputs,
    manifest::{Manifest, RunStatus},
    request::Request,
    runner::{self, Outcome},
};
use anyhow::{Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use patterns::{
    NoInputs,
    disocclusion::{
        Answer, Identifier, Normal, Quality, Scaled,
        fill::{Fill, Filled, fill},
        grey_levels, normalize,
        scores::Score,
    },
};
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use search::{Case, Limits, Search};
pub use sources::{Example, Source};

/// Part of the time budget after which the search for parameters ends.
const SEARCH: f64 = 0.4;

/// What is to be reconstructed, and how.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// File of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
    /// A picture that the program makes and hides in part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub example: Option<Example>,
    /// File of a mask of the picture's size: light is hidden.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<String>,
    /// Column, row, width and height of a hidden box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask_box: Option<[usize; 4]>,
    /// Column and row of the middle of a hidden disk, and its radius (pixels).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask_circle: Option<[f64; 3]>,
    /// File of the whole picture, to measure against.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<String>,
    /// Folder of further classes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub database: Option<String>,
    /// Most generations of the search for parameters; absent: five of a class with chance, whose
    /// later ones would follow its noise, 16 of one without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub generations: Option<u32>,
    /// Classes whose scores are computed.
    pub candidates: usize,
    /// Samples of what may be hidden; absent: one, and several of a wide hole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<usize>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            picture: None,
            example: None,
            mask: None,
            mask_box: None,
            mask_circle: None,
            truth: None,
            database: None,
            generations: None,
            candidates: 4,
            samples: None,
        }
    }
}

/// Where it goes and how long it may take.
#[derive(Clone, Debug)]
pub struct Options {
    /// Output folder; `None`: `out/reconstruct-<n>`.
    pub out: Option<PathBuf>,
    /// Overwrite a folder that is not empty.
    pub force: bool,
    /// No progress.
    pub quiet: bool,
    /// The search for parameters ends in time for the whole to take about this long.
    pub budget: Duration,
}

/// What was found.
pub(crate) struct Report {
    pub(crate) identifier: Identifier,
    pub(crate) source: Source,
    pub(crate) normal: Normal,
    pub(crate) answer: Answer,
    /// Of the class that was found, unless it is none.
    pub(crate) refined: Option<Search>,
    /// The class's own run by iteration.
    pub(crate) scores: Vec<Score>,
    /// Last scores of the first classes of the ranking.
    pub(crate) candidates: Vec<Score>,
    pub(crate) filled: Filled,
    pub(crate) quality: Option<Quality>,
}

impl Report {
    fn generations(&self) -> u32 {
        self.refined.as_ref().map_or(0, |r| r.generations)
    }
}

/// Reconstructs the picture that a request names.
///
/// # Errors
/// If a file or value cannot be used, or a model fails; nothing is left behind.
pub fn run(request: &Request, options: &Options) -> Result<Outcome> {
    let start = Instant::now();
    let config = parse(request)?;
    let inputs = FileInputs::new(request.base.clone());
    let source = sources::load(&config, request, &inputs)?;
    // Before the work, so that a folder that cannot be used is refused at once.
    let mut folder = Folder::create(options.out.as_deref(), "reconstruct", options.force)?;
    let done = reconstruct(&config, request, source, options, start).and_then(|report| {
        Ok((write(&mut folder, config, request.seed, inputs, &report)?, report))
    });
    match done {
        Ok((manifest, report)) => Ok(Outcome {
            folder: folder.path().to_path_buf(),
            manifest,
            notes: answer::notes(&report),
            seconds: start.elapsed().as_secs_f64(),
        }),
        Err(error) => {
            folder.discard();
            Err(error)
        }
    }
}

fn parse(request: &Request) -> Result<Config> {
    let value = toml::Value::Table(request.config.clone());
    let config: Config = serde_path_to_error::deserialize(value).map_err(|error| {
        let key = error.path().to_string();
        let reason = error.into_inner().to_string().trim().replace('\n', " ");
        request.locate(patterns::Error::config(&key, reason))
    })?;
    for (key, value, most) in [
        ("candidates", config.candidates, 1000),
        ("samples", config.samples.unwrap_or(1), 1000),
        ("generations", config.generations.unwrap_or(1) as usize, 10_000),
    ] {
        if value > most || (value == 0 && key != "generations") {
            let range = if key == "generations" { "[0, 10000]" } else { "[1, 1000]" };
            return Err(request.locate(patterns::Error::range(key, value as f64, range)));
        }
    }
    Ok(config)
}

/// The stages, one after the other.
fn reconstruct(
    config: &Config,
    request: &Request,
    mut source: Source,
    options: &Options,
    start: Instant,
) -> Result<Report> {
    let stages = Stages::new(options.quiet);
    let base = config.database.as_ref().map(|folder| sources::find(request, folder));
    let (classes, calibration) = database::load(base.as_deref())?;
    let identifier = Identifier::new(classes, &calibration)?;
    stages.say("comparing with every class");
    let compared = identifier.identify_at_scales(&source.work, &source.work_visible, &NoInputs);
    let Scaled { factor, picture, visible, normal, mut answer } =
        compared.map_err(|e| request.locate(e))?;
    source.factor *= factor;
    (source.work, source.work_visible) = (picture, visible);
    let plain = normalize(&source.work, &source.work_visible).map_err(|e| request.locate(e))?;
    if plain.threshold != normal.threshold {
        source.split_truth_at_mean();
    }
    stages.check()?;
    let search = Duration::try_from_secs_f64(options.budget.as_secs_f64() * SEARCH);
    let deadline = search.unwrap_or(Duration::MAX);
    let case = Case {
        identifier: &identifier,
        normal: &normal,
        wavelength: answer.wavelength,
        seed: request.seed,
    };
    let limits = Limits {
        generations: config.generations,
        stages: &stages,
        time: &|| start.elapsed() < deadline,
    };
    let refined = case.refine(&mut answer, &limits)?;
    let found = answer.ranking.first().filter(|_| !answer.none);
    stages.say("scoring the candidates");
    let (candidates, scores) = rayon::join(
        || case.candidates(&answer.ranking, config.candidates),
        || match (found, &refined) {
            (Some(found), Some(refined)) => case.scores(found, &refined.found.point),
            _ => Ok(Vec::new()),
        },
    );
    let (candidates, scores) = (candidates?, scores?);
    stages.check()?;
    stages.say("filling");
    let settings = Fill {
        seed: request.seed,
        samples: config.samples,
        inverted: found.is_some_and(|f| f.inverted),
        angle: found.and_then(|f| f.angle).unwrap_or(0.0),
        grey: grey_levels(&source.work, &normal),
    };
    let class = found.map(|f| identifier.class(f));
    let point = refined.as_ref().map_or(&[][..], |r| &r.found.point);
    let filled = fill(&normal, class, point, &settings, &NoInputs)?;
    stages.end();
    let quality = None;
    let mut report =
        Report { identifier, source, normal, answer, refined, scores, candidates, filled, quality };
    report.quality = quality_of(&report)?;
    Ok(report)
}

/// Against the truth, if there is one.
fn quality_of(report: &Report) -> Result<Option<Quality>> {
    let Some(truth) = &report.source.truth else { return Ok(None) };
    let found = outputs::whole(report);
    let seen = &report.source.visible;
    Ok(Some(Quality::new(report.source.shape(), &found, truth, seen)?))
}

fn write(
    folder: &mut Folder,
    mut config: Config,
    seed: u64,
    inputs: FileInputs,
    report: &Report,
) -> Result<Manifest> {
    let files = outputs::encode(report)?;
    config.generations = Some(report.generations());
    let mut table = toml::Table::try_from(config)?;
    for file in inputs.into_files() {
        folder.write(&file.copy, &file.bytes)?;
        runner::rename_input(&mut table, &file.given, &file.copy);
    }
    for (name, bytes) in files {
        folder.write(&name, &bytes)?;
    }
    let mut metrics: BTreeMap<String, f64> = BTreeMap::new();
    let first = report.answer.ranking.first();
    metrics.insert("confidence".into(), first.map_or(0.0, |m| m.confidence));
    metrics.insert("hidden".into(), report.source.hidden());
    metrics.insert("none".into(), f64::from(u8::from(report.answer.none)));
    metrics.extend(report.quality.iter().flat_map(Quality::metrics).map(|m| (m.name, m.value)));
    let manifest = Manifest {
        command: "reconstruct".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        config: table,
        seed,
        status: RunStatus::Done,
        iterations: u64::from(report.generations()),
        metrics,
        files: folder.files(),
        answer: Some(answer::json(report)),
    };
    folder.write_hidden("run.json", manifest.to_json()?.as_bytes())?;
    Ok(manifest)
}

/// A line on standard error that tells the stage, and only on a terminal.
struct Stages(ProgressBar);

impl Stages {
    fn new(quiet: bool) -> Self {
        if quiet {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    fn say(&self, text: &str) {
        self.0.set_message(text.to_owned());
    }

    /// Refuses to go on after Ctrl-C.
    fn check(&self) -> Result<()> {
        if runner::INTERRUPTED.load(Ordering::Relaxed) {
            self.end();
            bail!("interrupted; nothing was written");
        }
        Ok(())
    }

    fn end(&self) {
        self.0.finish_and_clear();
    }
}
