//! The one loop: step, observe, checkpoint, stop.

use crate::{
    artifact, checkpoint,
    folder::Folder,
    inputs::FileInputs,
    manifest::{Manifest, RunStatus},
    memory, output,
    record::Recorder,
    request::{Request, find_model},
};
use anyhow::{Context as _, Result, bail};
use indicatif::{ProgressBar, ProgressStyle};
use patterns::{Context, Run, Status};
use std::{
    path::{Path, PathBuf},
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

/// Set by Ctrl-C and by termination signals; the runner saves and stops.
pub static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Checkpoints are this far apart unless `--checkpoint-every` counts iterations.
const CHECKPOINT_SECONDS: u64 = 60;

/// Format of the animation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Film {
    /// `animation.gif`.
    #[default]
    Gif,
    /// `animation.apng`.
    Apng,
}

impl Film {
    fn file(self) -> &'static str {
        match self {
            Self::Gif => "animation.gif",
            Self::Apng => "animation.apng",
        }
    }
}

/// How a run is watched and where it is written.
#[derive(Clone, Debug)]
pub struct Options {
    /// Output folder; `None`: `out/<command>-<n>`.
    pub out: Option<PathBuf>,
    /// Overwrite a folder that is not empty.
    pub force: bool,
    /// Steps between checkpoints; `None`: one a minute.
    pub checkpoint_every: Option<u64>,
    /// Frames of the animation, 0 for none.
    pub frames: u64,
    /// Format of the animation.
    pub film: Film,
    /// No progress bar.
    pub quiet: bool,
}

impl Default for Options {
    fn default() -> Self {
        let film = Film::default();
        Self { out: None, force: false, checkpoint_every: None, frames: 100, film, quiet: true }
    }
}

/// What a run left behind.
#[derive(Debug)]
pub struct Outcome {
    /// The output folder.
    pub folder: PathBuf,
    /// The content of its `run.json`.
    pub manifest: Manifest,
    /// Notes of the model.
    pub notes: Vec<String>,
    /// Seconds from the start to the last file.
    pub seconds: f64,
}

/// A run with all that goes with it.
struct Session<'a> {
    run: Box<dyn Run>,
    recorder: Recorder,
    folder: Folder,
    manifest: Manifest,
    options: &'a Options,
    /// Frames and format of the animation, of a resumed run those of its start.
    frames: u64,
    film: Film,
    start: Instant,
    /// Whether the folder holds a checkpoint, so that a failure keeps it.
    saved: bool,
}

/// Runs a request from its start.
///
/// # Errors
/// If the configuration, an input or the output folder cannot be used (nothing is
/// left behind), or a step fails (the last checkpoint stays, if there is one).
pub fn run(request: &Request, options: &Options) -> Result<Outcome> {
    let start = Instant::now();
    let model = find_model(&request.command)?;
    let inputs = FileInputs::new(request.base.clone());
    let context = Context { seed: request.seed, inputs: &inputs, memory: memory::available() };
    let run = (model.start)(&request.config, &context)
        .map_err(|error| refuse(request, options, error))?;
    let mut folder = Folder::create(options.out.as_deref(), model.name, options.force)?;
    let mut config = run.config();
    for file in inputs.into_files() {
        if let Err(error) = folder.write(&file.copy, &file.bytes) {
            folder.discard();
            return Err(error);
        }
        rename_input(&mut config, &file.given, &file.copy);
    }
    let manifest = Manifest {
        command: model.name.into(),
        version: env!("CARGO_PKG_VERSION").into(),
        config,
        seed: request.seed,
        status: RunStatus::Running,
        iterations: 0,
        metrics: std::collections::BTreeMap::new(),
        files: folder.files(),
        answer: None,
    };
    let Options { frames, film, .. } = *options;
    let recorder = Recorder::new(run.expected_iterations(), frames);
    Session { run, recorder, folder, manifest, options, frames, film, start, saved: false }.go()
}

/// Goes on with the run of an output folder from its checkpoint.
///
/// # Errors
/// If the folder holds no unfinished run, or as [`run`].
pub fn resume(path: &Path, options: &Options) -> Result<Outcome> {
    let start = Instant::now();
    let manifest = read_manifest(path)?;
    if matches!(manifest.status, RunStatus::Done | RunStatus::NotConverged) {
        bail!(
            "--resume {}: the run is finished (iteration {})",
            path.display(),
            manifest.iterations
        );
    }
    let state = checkpoint::read(&path.join(checkpoint::FILE))?;
    let model = find_model(&manifest.command)?;
    let inputs = FileInputs::new(vec![path.to_path_buf()]);
    let context = Context { seed: manifest.seed, inputs: &inputs, memory: memory::available() };
    let mut run = (model.start)(&manifest.config, &context)
        .with_context(|| format!("{}", path.join("run.json").display()))?;
    run.restore(&state)?;
    let frames = state.all_u64("lab.frames_wanted")?.first().copied().unwrap_or(0);
    let apng = state.all_u64("lab.apng")?.first() == Some(&1);
    let film = if apng { Film::Apng } else { Film::Gif };
    let mut recorder = Recorder::new(run.expected_iterations(), frames);
    recorder.restore(&state, run.as_ref())?;
    let mut folder = Folder::open(path);
    folder.adopt(&manifest.files);
    Session { run, recorder, folder, manifest, options, frames, film, start, saved: true }.go()
}

/// Says where a refused value was given; the motion of a mechanism is drawn beside the
/// output folder, which is not made.
fn refuse(request: &Request, options: &Options, error: patterns::Error) -> anyhow::Error {
    let patterns::Error::Mechanism { picture, .. } = &error else {
        return request.locate(error);
    };
    let place = options.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&request.command));
    let path = PathBuf::from(format!("{}-mechanism.png", place.display()));
    let drawn = artifact::encode_all(std::slice::from_ref(picture.as_ref())).and_then(|files| {
        path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        files.first().map_or(Ok(()), |(_, bytes)| output::save_bytes(&path, bytes))
    });
    let located = request.locate(error);
    match drawn {
        // The refusal matters more than its picture.
        Err(_) => located,
        Ok(()) => anyhow::anyhow!("{located:#} (the motion is drawn in {})", path.display()),
    }
}

/// The manifest of an output folder.
///
/// # Errors
/// If there is none, or it is broken.
pub fn read_manifest(path: &Path) -> Result<Manifest> {
    let file = path.join("run.json");
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("`{}` holds no run: cannot read run.json", path.display()))?;
    Manifest::parse(&text).with_context(|| format!("`{}` is broken", file.display()))
}

impl Session<'_> {
    fn go(mut self) -> Result<Outcome> {
        let result = self.run_and_write();
        match result {
            Ok(()) => Ok(Outcome {
                folder: self.folder.path().to_path_buf(),
                manifest: self.manifest,
                notes: self.run.notes(),
                seconds: self.start.elapsed().as_secs_f64(),
            }),
            Err(error) if self.saved => {
                self.manifest.status = RunStatus::Failed;
                // The error that stopped the run matters more than one on this last write.
                let _ = self.write_manifest();
                let folder = self.folder.path().display().to_string();
                Err(error.context(format!("stopped; the last checkpoint is in {folder}")))
            }
            Err(error) => {
                self.folder.discard();
                Err(error)
            }
        }
    }

    fn run_and_write(&mut self) -> Result<()> {
        let status = self.steps()?;
        self.manifest.iterations = self.run.iterations();
        let Some(status) = status else {
            self.manifest.status = RunStatus::Interrupted;
            return self.save_checkpoint();
        };
        self.manifest.status =
            if status == Status::Done { RunStatus::Done } else { RunStatus::NotConverged };
        self.write_results()
    }

    /// Steps until the run ends, or `None` if it was interrupted.
    fn steps(&mut self) -> Result<Option<Status>> {
        let bar = progress_bar(self.run.as_ref(), self.options.quiet);
        let mut last_save = Instant::now();
        self.recorder.observe(self.run.as_ref(), false)?;
        let status = loop {
            let before = self.run.iterations();
            let status = self.run.step()?;
            let n = self.run.iterations();
            bar.set_position(n);
            let ended = status != Status::Running;
            self.recorder.observe(self.run.as_ref(), ended)?;
            if ended {
                break Some(status);
            }
            if INTERRUPTED.load(Ordering::Relaxed) {
                break None;
            }
            let due = match self.options.checkpoint_every {
                Some(every) => n / every.max(1) > before / every.max(1),
                None => last_save.elapsed() >= Duration::from_secs(CHECKPOINT_SECONDS),
            };
            if due {
                self.save_checkpoint()?;
                last_save = Instant::now();
            }
        };
        bar.finish_and_clear();
        Ok(status)
    }

    fn save_checkpoint(&mut self) -> Result<()> {
        let mut state = self.run.save();
        self.recorder.save(&mut state);
        state.put_u64("lab.frames_wanted", &[self.frames]);
        state.put_u64("lab.apng", &[u64::from(self.film == Film::Apng)]);
        self.manifest.iterations = self.run.iterations();
        // First the manifest: a checkpoint without one could not be resumed.
        self.write_manifest()?;
        self.folder.write_hidden(checkpoint::FILE, &checkpoint::to_bytes(&state)?)?;
        self.saved = true;
        Ok(())
    }

    fn write_manifest(&mut self) -> Result<()> {
        self.manifest.files = self.folder.files();
        let text = self.manifest.to_json()?;
        self.folder.write_hidden("run.json", text.as_bytes())
    }

    fn write_results(&mut self) -> Result<()> {
        let computed = self.start.elapsed().as_secs_f64();
        let finite = self.run.metrics().into_iter().filter(|m| m.value.is_finite());
        self.manifest.metrics = finite.map(|m| (m.name, m.value)).collect();
        let mut artifacts = self.run.artifacts();
        artifacts.extend(self.recorder.artifacts());
        artifact::write_all(&artifacts, &mut self.folder)?;
        drop(artifacts);
        if self.recorder.animation().len() > 1 {
            let (mut film, file) = (Vec::new(), self.film.file());
            self.recorder.animation().write(Path::new(file), &mut film)?;
            self.folder.write(file, &film)?;
        }
        self.write_manifest()?;
        let timing = serde_json::json!({
            "run_seconds": computed,
            "total_seconds": self.start.elapsed().as_secs_f64(),
            "threads": rayon::current_num_threads(),
        });
        self.folder.write_hidden("timing.json", format!("{timing:#}\n").as_bytes())?;
        self.folder.remove(checkpoint::FILE);
        Ok(())
    }
}

/// A bar on standard error that appears after two seconds, and only on a terminal.
fn progress_bar(run: &dyn Run, quiet: bool) -> ProgressBar {
    if quiet || run.max_iterations() == 0 {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(run.max_iterations()).with_position(run.iterations());
    let template = "{bar:30} {pos}/{len} iterations, {per_sec}, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.reset_eta();
    bar
}

/// Replaces the path that a configuration names by the copy in the output folder.
pub(crate) fn rename_input(config: &mut toml::Table, from: &str, to: &str) {
    config.iter_mut().for_each(|(_, value)| rename_in(value, from, to));
}

fn rename_in(value: &mut toml::Value, from: &str, to: &str) {
    match value {
        toml::Value::String(text) if text == from => *text = to.into(),
        toml::Value::Table(table) => rename_input(table, from, to),
        toml::Value::Array(list) => list.iter_mut().for_each(|value| rename_in(value, from, to)),
        _ => {}
    }
}
