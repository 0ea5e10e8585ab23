//! What is kept while a run goes on: frames of the animation and the log.

use crate::output::animation::Animation;
use anyhow::Result;
use patterns::{Artifact, Axis, Mark, Plot, Run, Series, State, observation_interval};

/// Keeps the log and the animation of a run, through checkpoints too.
pub struct Recorder {
    every: u64,
    frame_every: u64,
    /// Heading and unit of each column; empty until the first observation.
    columns: Vec<(String, &'static str)>,
    iterations: Vec<f64>,
    rows: Vec<f64>,
    animation: Animation,
    /// Whether there is an animation.
    frames: bool,
    /// Iteration of the last look.
    last: Option<u64>,
}

impl Recorder {
    /// For a run of about `iterations` steps and an animation of about `frames` frames.
    pub fn new(iterations: u64, frames: u64) -> Self {
        Self {
            every: observation_interval(iterations),
            frame_every: iterations.div_ceil(frames.max(1)).max(1),
            columns: Vec::new(),
            iterations: Vec::new(),
            rows: Vec::new(),
            animation: Animation::new(usize::try_from(frames).unwrap_or(usize::MAX)),
            frames: frames > 0,
            last: None,
        }
    }

    /// Looks at a run; costs nothing between two observations.
    ///
    /// # Errors
    /// If a frame cannot be drawn.
    pub fn observe(&mut self, run: &dyn Run, last: bool) -> Result<()> {
        let n = run.iterations();
        let seen = self.iterations.last() == Some(&(n as f64));
        // A step may make several iterations: what counts is that a multiple was reached.
        let due = |every: u64| self.last.is_none_or(|last| n / every > last / every);
        let (row_due, frame_due) = (due(self.every), due(self.frame_every));
        self.last = Some(n);
        if (row_due || last) && !seen {
            let metrics = run.observe();
            if self.columns.is_empty() {
                self.columns = metrics.iter().map(|m| (m.name.clone(), m.unit)).collect();
            }
            self.iterations.push(n as f64);
            self.rows.extend(metrics.iter().map(|m| m.value));
        }
        if self.frames
            && (frame_due || last)
            && let Some(image) = run.frame()
        {
            self.animation.push(&image)?;
        }
        Ok(())
    }

    /// The animation so far.
    pub fn animation(&self) -> &Animation {
        &self.animation
    }

    /// The log as a table and a plot of each column; nothing for a run that reports nothing.
    pub fn artifacts(&self) -> Vec<Artifact> {
        if self.columns.is_empty() {
            return Vec::new();
        }
        let mut columns = vec![("iteration".into(), self.iterations.clone())];
        for (c, (name, _)) in self.columns.iter().enumerate() {
            columns.push((name.clone(), self.column(c)));
        }
        let mut artifacts = vec![Artifact::Table { name: "log".into(), columns }];
        for (c, (name, unit)) in self.columns.iter().enumerate() {
            // What is not known before the first step, or between two looks, is NaN there.
            let points = self.iterations.iter().copied().zip(self.column(c));
            let points = points.filter(|(_, value)| value.is_finite()).map(|(x, y)| [x, y]);
            let points: Vec<[f64; 2]> = points.collect();
            if points.is_empty() {
                continue;
            }
            let label = if *unit == "1" { name.clone() } else { format!("{name} ({unit})") };
            artifacts.push(Artifact::Plot(Plot {
                name: format!("log-{}", name.replace('_', "-")),
                title: format!("{} against iteration", name.replace('_', " ")),
                x: Axis::linear("iteration"),
                y: Axis::linear(&label.replace('_', " ")),
                series: vec![Series { label: name.replace('_', " "), points, mark: Mark::Line }],
            }));
        }
        artifacts
    }

    fn column(&self, c: usize) -> Vec<f64> {
        self.rows.iter().skip(c).step_by(self.columns.len()).copied().collect()
    }

    /// Adds the log and the frames to a checkpoint.
    pub fn save(&self, state: &mut State) {
        state.put_f64("lab.iterations", &self.iterations);
        state.put_f64("lab.rows", &self.rows);
        state.put_u8("lab.frames", &self.animation.to_bytes());
        state.put_u64("lab.last", &self.last.map_or(vec![], |n| vec![n]));
    }

    /// Takes the log and the frames from a checkpoint.
    ///
    /// # Errors
    /// If they are missing or do not fit `run`.
    pub fn restore(&mut self, state: &State, run: &dyn Run) -> Result<()> {
        self.columns = run.observe().into_iter().map(|m| (m.name, m.unit)).collect();
        self.iterations = state.all_f64("lab.iterations")?.to_vec();
        self.rows = state.all_f64("lab.rows")?.to_vec();
        self.last = state.all_u64("lab.last")?.first().copied();
        self.animation = Animation::from_bytes(state.all_u8("lab.frames")?)?;
        Ok(())
    }
}
