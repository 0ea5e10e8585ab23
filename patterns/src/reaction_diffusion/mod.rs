//! Reaction-diffusion and the curve that follows its pattern (Algorithm 1).
//!
//! `du_s/dt = f_s(u, x) + div(D_s grad u_s)` on cells of size 1. Metrics: `components`
//! (of at least 4 cells of ink), `mean_area` (cells), `ink_fraction`, `perimeter` (cells),
//! `euler_number`, `wavelength` (cells, peak of the radial spectrum of the species that
//! diffuses fastest); with a curve
//! `agreement` (share of cells), `contour_distance` (cells) and `settled_at` (iteration);
//! with `dispersion` `predicted_wavelength` (cells) and `predicted_growth` (1/time); on a
//! growing domain `scale` (its length over that of the start, 1): cells have grown with it.
//!
//! A new kinetics is one file in [`kinetics`] and one line in its registry.

pub mod config;
mod curve;
mod front;
mod general;
mod grown;
pub mod growth;
pub(crate) mod held;
pub mod kinetics;
mod measure;
mod perturb;
mod pictures;
mod resolve;
mod setup;
pub mod stepper;

use crate::{Artifact, Context, Error, Image, Metric, Model, Result, Run, State, Status};
use config::{Config, CurveSpeed};
use curve::{Border, Curve};
use measure::Prediction;
use setup::Start;
use solvers::Field;
use solvers::diffusion::Growth;
use solvers::spectral::RadialSpectrum;
use stepper::{Stepper, Stretch};

/// Registry entry.
pub static MODEL: Model = Model {
    name: "rd",
    about: "Reaction-diffusion patterns, and a level-set curve that follows their border",
    paper: "Turing 1952; Chattopadhyay & Mukherjee, Algorithm 1, equations (1.4)-(1.7), (1.16)",
    presets: kinetics::presets,
    start,
};

/// Iterations that one call of `step` makes at the most.
const CHUNK: u64 = 20;

/// Iterations between two looks at the signs, and the share of changes that counts as
/// settled; in the first thousand nothing moves, because the pattern is still growing.
const SETTLED: (u64, f64, u64) = (100, 0.002, 1000);

/// Rows that the history of a one-dimensional run aims at.
const HISTORY: u64 = 250;

struct Rd {
    config: Config,
    names: Vec<String>,
    stepper: Box<dyn Stepper>,
    note: Option<String>,
    prediction: Option<Prediction>,
    growth: Option<Growth>,
    /// The species whose spectrum is measured: the one that diffuses fastest, because
    /// the sharp borders of the others put their power into harmonics.
    wave: usize,
    /// The species whose border is followed, and its last concentration.
    ink: usize,
    c: Field,
    curve: Option<Curve>,
    done: u64,
    settled_at: Option<u64>,
    snapshots: Vec<(u64, Field)>,
    /// Concentrations of the ink's species across a row, at equal times.
    history: Vec<f64>,
}

fn start(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let config = resolve::resolve(table)?;
    let growth = config.growth()?;
    let start = Start::new(&config, context)?;
    let names = start.chemistry.species.clone();
    let ink = names.iter().position(|name| *name == config.ink.species).ok_or_else(|| {
        let reason = format!("no `{}` here; known: {}", config.ink.species, names.join(", "));
        Error::config("ink.species", reason)
    })?;
    let (mut stepper, note) = start.stepper(config.stepper)?;
    if growth.is_some() {
        // What cannot grow is refused before any work.
        stepper.stretch(Stretch { laplacian: 1.0, dilution: 1.0 })?;
    }
    let mut c = Field::constant(start.setup.grid, 0.0);
    stepper.copy_into(ink, &mut c);
    let curve = match config.curve.speed {
        CurveSpeed::Off => None,
        _ => {
            let phi = front::phi(&config.curve, start.setup.grid, context)?;
            Some(Curve::new(phi, config.boundary, &config.curve)?)
        }
    };
    if config.stop_when_settled && curve.is_none() {
        let reason = "needs a curve; set curve.speed to \"recipe\"";
        return Err(Error::config("stop_when_settled", reason));
    }
    let prediction = if config.dispersion { measure::predict(&start)? } else { None };
    let diffusion = &start.setup.diffusion;
    let wave = (0..diffusion.len()).fold(ink, |best, s| {
        if diffusion[s] > diffusion.get(best).copied().unwrap_or(0.0) { s } else { best }
    });
    let mut run = Rd {
        config,
        names,
        stepper,
        note,
        prediction,
        growth,
        wave,
        ink,
        c,
        curve,
        done: 0,
        settled_at: None,
        snapshots: Vec::new(),
        history: Vec::new(),
    };
    run.keep_snapshot();
    run.keep_history(0);
    Ok(Box::new(run))
}

impl Rd {
    fn border(&self) -> Border<'_> {
        let level = match self.config.ink.level {
            config::Level::Value(level) => Some(level),
            config::Level::Mean(_) => None,
        };
        Border { c: &self.c, level, below: self.config.ink.below }
    }

    /// phi of the ink: the curve's, or by threshold.
    fn phi(&self) -> Field {
        match &self.curve {
            Some(curve) => curve.phi().clone(),
            None => measure::threshold(self.border()),
        }
    }

    fn spectrum(&self) -> Option<RadialSpectrum> {
        let mut field = self.c.clone();
        self.stepper.copy_into(self.wave, &mut field);
        measure::spectrum(&field, self.config.boundary).ok()
    }

    /// The next iteration at which something happens, at most a chunk away.
    fn next_stop(&self) -> u64 {
        let chunk = (self.done / CHUNK + 1) * CHUNK;
        let snapshots = self.config.snapshots.iter().copied().filter(|&n| n > self.done);
        snapshots.chain([chunk, self.config.iterations]).min().unwrap_or(chunk)
    }

    /// The length of the domain over that of the start, if it grows.
    fn scale(&self) -> Option<f64> {
        self.growth.map(|growth| growth.scale(self.done as f64 * self.config.dt))
    }

    /// Lets the reaction do `steps` steps.
    fn react(&mut self, steps: u64) -> Result<()> {
        let Some(growth) = self.growth else {
            self.stepper.advance(steps)?;
            self.done += steps;
            return Ok(());
        };
        let (dt, dim) = (self.config.dt, self.c.grid().dim());
        let dilutes = self.config.growth.as_ref().is_some_and(|growth| growth.dilution);
        for _ in 0..steps {
            let t = self.done as f64 * dt;
            let dilution = if dilutes { growth.dilution(t, dt, dim) } else { 1.0 };
            let laplacian = growth.laplacian_factor(t, dt);
            self.stepper.stretch(Stretch { laplacian, dilution })?;
            self.stepper.advance(1)?;
            self.done += 1;
        }
        Ok(())
    }

    fn advance_to(&mut self, stop: u64) -> Result<()> {
        let Some(mut curve) = self.curve.take() else {
            self.react(stop - self.done)?;
            self.stepper.copy_into(self.ink, &mut self.c);
            return Ok(());
        };
        while self.done < stop {
            self.react(1)?;
            self.stepper.copy_into(self.ink, &mut self.c);
            curve.step(self.border())?;
        }
        self.curve = Some(curve);
        Ok(())
    }

    /// Looks at the signs when it is time; whether the curve has settled.
    fn settle(&mut self) -> bool {
        let (every, share, least) = SETTLED;
        let Some(curve) = &mut self.curve else { return false };
        if !self.done.is_multiple_of(every) {
            return self.settled_at.is_some();
        }
        let quiet = curve.changed_signs() < share && self.done >= least;
        self.settled_at = quiet.then(|| self.settled_at.unwrap_or(self.done));
        quiet
    }

    fn keep_snapshot(&mut self) {
        if self.config.snapshots.contains(&self.done) {
            self.snapshots.push((self.done, self.c.clone()));
        }
    }

    /// Iterations between two rows of the history.
    fn history_every(&self) -> u64 {
        self.config.iterations.div_ceil(HISTORY).max(1)
    }

    /// Keeps a row's concentrations whenever the iterations since `before` reach a multiple.
    fn keep_history(&mut self, before: u64) {
        let every = self.history_every();
        if self.c.grid().dim() == 1 && (self.done == 0 || self.done / every > before / every) {
            self.history.extend_from_slice(self.c.as_slice());
        }
    }

    fn finish(&mut self) -> Result<()> {
        if let Some(mut curve) = self.curve.take() {
            curve.finish(self.border(), self.config.curve.finish)?;
            self.curve = Some(curve);
        }
        Ok(())
    }
}

impl Run for Rd {
    fn step(&mut self) -> Result<Status> {
        let before = self.done;
        self.advance_to(self.next_stop())?;
        self.c.check_finite(&self.names[self.ink], self.done as f64 * self.config.dt)?;
        self.keep_snapshot();
        self.keep_history(before);
        let settled = self.settle();
        let last = self.done == self.config.iterations;
        let ends = last || (settled && self.config.stop_when_settled);
        if !ends {
            return Ok(Status::Running);
        }
        self.finish()?;
        let given_up = self.config.stop_when_settled && !settled;
        Ok(if given_up { Status::NotConverged } else { Status::Done })
    }

    fn iterations(&self) -> u64 {
        self.done
    }

    fn max_iterations(&self) -> u64 {
        self.config.iterations
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn observe(&self) -> Vec<Metric> {
        let (mean, std) = self.c.mean_std();
        let name = &self.names[self.ink];
        let mut metrics = vec![
            Metric::new(&format!("{name}_mean"), mean, "concentration"),
            Metric::new(&format!("{name}_deviation"), std, "concentration"),
        ];
        metrics.extend(self.scale().map(|scale| Metric::new("scale", scale, "1")));
        metrics
    }

    fn metrics(&self) -> Vec<Metric> {
        let phi = self.phi();
        let mut metrics = measure::ink(&phi, self.config.boundary);
        metrics.extend(self.scale().map(|scale| Metric::new("scale", scale, "1")));
        if let Some(wavelength) = self.spectrum().and_then(|s| s.peak_wavelength()) {
            metrics.push(Metric::new("wavelength", wavelength, "cells"));
        }
        if self.curve.is_some() {
            let agreement = measure::agreement(&phi, self.border());
            metrics.push(Metric::new("agreement", agreement, "1"));
            if let Ok(Some(distance)) = measure::contour_distance(&phi, self.border()) {
                metrics.push(Metric::new("contour_distance", distance, "cells"));
            }
            if let Some(settled) = self.settled_at {
                metrics.push(Metric::new("settled_at", settled as f64, "iteration"));
            }
        }
        if let Some(prediction) = &self.prediction {
            metrics.push(Metric::new("predicted_growth", prediction.growth, "1/time"));
            if let Some(wavelength) = prediction.wavelength {
                metrics.push(Metric::new("predicted_wavelength", wavelength, "cells"));
            }
        }
        metrics
    }

    fn artifacts(&self) -> Vec<Artifact> {
        self.pictures()
    }

    fn frame(&self) -> Option<Image> {
        if self.curve.is_some() {
            return Some(self.ink_image(self.phi()));
        }
        let mut image = self.image(&self.names[self.ink], self.c.clone(), &self.c);
        image.contour = None;
        Some(image)
    }

    fn notes(&self) -> Vec<String> {
        self.note.iter().cloned().collect()
    }

    fn save(&self) -> State {
        let mut state = State::default();
        self.stepper.save(&self.names, &mut state);
        state.put_u64("done", &[self.done]);
        state.put_u64("settled_at", &self.settled_at.map_or(vec![], |n| vec![n]));
        for (n, field) in &self.snapshots {
            state.put_f64(&format!("snapshot.{n}"), field.as_slice());
        }
        state.put_f64("history", &self.history);
        if let Some(curve) = &self.curve {
            curve.save(&mut state);
        }
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        self.stepper.restore(&self.names, state)?;
        self.stepper.copy_into(self.ink, &mut self.c);
        self.done = state.one_u64("done")?;
        self.settled_at = state.all_u64("settled_at")?.first().copied();
        self.snapshots.clear();
        for &n in self.config.snapshots.iter().filter(|&&n| n <= self.done) {
            let mut field = self.c.clone();
            state.get_f64(&format!("snapshot.{n}"), field.as_mut_slice())?;
            self.snapshots.push((n, field));
        }
        self.history = state.all_f64("history")?.to_vec();
        if let Some(curve) = &mut self.curve {
            curve.restore(state)?;
        }
        Ok(())
    }
}
