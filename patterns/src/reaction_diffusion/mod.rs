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
mod general;
mod grown;
pub mod kinetics;
mod measure;
mod setup;
pub mod stepper;

use crate::contour;
use crate::{
    Artifact, Axis, Colors, Context, Error, Image, Mark, Metric, Model, Plot, Result, Run, Series,
    State, Status,
};
use config::{Config, CurveSpeed};
use curve::{Border, Curve};
use measure::Prediction;
use setup::Start;
use solvers::diffusion::Growth;
use solvers::level_set::Shape;
use solvers::spectral::RadialSpectrum;
use solvers::{Field, Grid, isosurface, random};
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
    let config = config::resolve(table)?;
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
            let phi = first_curve(&config.curve, start.setup.grid, context)?;
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

/// phi of the curve at the start: from lines, by name, or negative in the dark half of a picture.
fn first_curve(curve: &config::Curve, grid: Grid, context: &Context<'_>) -> Result<Field> {
    if let Some(path) = &curve.contour {
        return contour::phi("curve.contour", path, grid, context);
    }
    let axes: Vec<f64> = grid.axes().iter().map(|&n| n as f64).collect();
    let least = axes.iter().copied().fold(f64::INFINITY, f64::min);
    let center = solvers::level_set::shapes::Point(grid.center());
    match curve.start.as_str() {
        // Radius 30 on the paper's 80 x 80 cells.
        "circle" => Ok(Shape::Circle { center, radius: 0.375 * least }.field(grid)?),
        "border" => Ok(Field::from_fn(grid, |p| {
            let to_border = |axis: usize| {
                let n = grid.shape()[2 - axis] as f64;
                if n == 1.0 { f64::INFINITY } else { p[axis].min(n - 1.0 - p[axis]) }
            };
            // Inside is all but the outermost cells.
            1.5 - (0..3).map(to_border).fold(f64::INFINITY, f64::min)
        })),
        "seeds" => {
            let mut places = random::stream(context.seed, "curve seeds", 0);
            let shapes = (0..16)
                .map(|_| {
                    let at = [0, 1, 2].map(|axis| {
                        random::uniform(&mut places) * (grid.shape()[2 - axis] - 1) as f64
                    });
                    let center = solvers::level_set::shapes::Point(at);
                    Shape::Circle { center, radius: (0.04 * least).max(1.5) }
                })
                .collect();
            Ok(Shape::Union { shapes }.field(grid)?)
        }
        path => {
            let key = "curve.start";
            let mut image = context.inputs.field(key, path)?;
            image
                .check_shape(&format!("`{path}`"), grid)
                .map_err(|error| Error::config(key, error.to_string()))?;
            image.as_mut_slice().iter_mut().for_each(|v| *v -= 0.5);
            Ok(image)
        }
    }
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

    /// The history of a row as a picture: x to the right, time downwards.
    fn history_artifact(&self) -> Option<Artifact> {
        let nx = self.c.as_slice().len();
        let grid = Grid::new(&[self.history.len() / nx, nx], 1.0).ok()?;
        let field = Field::from_vec(grid, self.history.clone()).ok()?;
        let name = &self.names[self.ink];
        Some(Artifact::Image(Image {
            name: "history".into(),
            field,
            label: format!(
                "{name} (concentration), a row down every {} iterations",
                self.history_every()
            ),
            colors: Colors::Sequential,
            range: None,
            contour: None,
        }))
    }

    fn finish(&mut self) -> Result<()> {
        if let Some(mut curve) = self.curve.take() {
            curve.finish(self.border(), self.config.curve.finish)?;
            self.curve = Some(curve);
        }
        Ok(())
    }

    fn image(&self, name: &str, field: Field, phi: &Field) -> Image {
        Image {
            name: name.into(),
            field,
            label: format!("{name} (concentration)"),
            colors: Colors::Sequential,
            range: None,
            contour: Some(phi.clone()),
        }
    }

    fn ink_image(&self, phi: Field) -> Image {
        Image {
            name: "ink".into(),
            field: phi.clone(),
            label: "ink".into(),
            colors: Colors::Ink,
            range: None,
            contour: Some(phi),
        }
    }

    /// Snapshots as panels of a plot (1D) or as pictures.
    fn snapshot_artifacts(&self, phi: &Field) -> Vec<Artifact> {
        let name = &self.names[self.ink];
        if self.c.grid().dim() > 1 {
            let image = |(n, field): &(u64, Field)| {
                let mut image = self.image(&format!("{name}-{n}"), field.clone(), phi);
                image.contour = None;
                Artifact::Image(image)
            };
            return self.snapshots.iter().map(image).collect();
        }
        if self.snapshots.is_empty() {
            return Vec::new();
        }
        let series = |(n, field): &(u64, Field)| Series {
            label: format!("iteration {n}"),
            points: field.as_slice().iter().enumerate().map(|(i, &v)| [i as f64, v]).collect(),
            mark: if *n == 0 { Mark::Dashed } else { Mark::Line },
        };
        vec![Artifact::Plot(Plot {
            name: "snapshots".into(),
            title: format!("Concentration of {name} across the row"),
            x: Axis::linear("x (cells)"),
            y: Axis::linear(&format!("{name} (concentration)")),
            series: self.snapshots.iter().map(series).collect(),
        })]
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
        let phi = self.phi();
        let grid = phi.grid();
        let mut artifacts = vec![Artifact::Image(self.ink_image(phi.clone()))];
        for (species, name) in self.names.iter().enumerate() {
            let mut field = Field::constant(grid, 0.0);
            self.stepper.copy_into(species, &mut field);
            artifacts.push(Artifact::Image(self.image(name, field, &phi)));
        }
        match grid.dim() {
            2 => artifacts.push(Artifact::contour("contour", &phi)),
            3 => {
                if let Ok(mesh) = isosurface::triangulate(&phi, 0.0, isosurface::Caps::Closed) {
                    artifacts.push(Artifact::Mesh { name: "surface".into(), mesh });
                }
            }
            _ => {}
        }
        let predicted = self.prediction.as_ref().and_then(|p| p.wavelength);
        if let Some(spectrum) = self.spectrum() {
            artifacts.push(Artifact::Plot(measure::spectrum_plot(&spectrum, predicted)));
            if let Some(prediction) = &self.prediction {
                let plot = measure::dispersion_plot(prediction, spectrum.peak_wavelength());
                artifacts.push(Artifact::Plot(plot));
            }
        }
        artifacts.extend(self.snapshot_artifacts(&phi));
        if grid.dim() == 1 {
            artifacts.extend(self.history_artifact());
        }
        artifacts
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
