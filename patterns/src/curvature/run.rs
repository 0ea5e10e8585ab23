//! One texture, grown.

use super::config::{Boundary, Config, Flow, Precision};
use super::descent::{Descent, Stored};
use super::energy::Energy;
use super::flow::{self, DescentConfig, Fast, Opened, Paper, PaperConfig, StepInfo};
use super::{Mask, Potential, presets, start, view, written};
use crate::observation_interval;
use crate::{Artifact, Context, Error, Image, Metric, Result, Run, State, Status, Surface};
use solvers::{
    Field, Grid,
    diffusion::explicit::Real,
    isosurface::{self, Caps},
    optimize::AdamConfig,
};
use std::cell::RefCell;

/// `(H - 20)^2 + 5 k2^2`, where the configuration names no energy.
const VESSELS: [f64; 6] = [1.0, 2.0, 6.0, -40.0, -40.0, 400.0];

/// Energy of the phase over that of its surface: 4 / (3 sqrt 2), what a unit of area has of
/// `epsilon |grad u|^2` in the profile tanh(d / (sqrt 2 epsilon)).
const SIGMA: f64 = 0.942_809_041_582_063_4;

/// Looks at what costs more than a step in a whole run, about.
const LOOKS: u64 = 12;

/// What is looked at.
const LOOKED: [&str; 4] = ["normalized_discrepancy", "mass", "genus", "components"];

/// Evaluations over which the change of the energy is compared with the tolerance.
const PATIENCE: usize = 50;

/// A flow and what it has seen.
struct Texture {
    config: Config,
    grid: Grid,
    flow: Box<dyn Descent>,
    /// Energy and norm of the gradient of each evaluation.
    history: Vec<[f64; 2]>,
    /// Whether there are no more steps to make.
    ended: bool,
    notes: Vec<String>,
    /// Number and values of the last look at what costs more than a step.
    looked: RefCell<Option<(usize, Vec<Metric>)>>,
}

/// Starts a run, its checks before any work.
pub(super) fn begin(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let mut config: Config = crate::from_table(&presets::expand(table)?)?;
    config.check()?;
    if config.coefficients.is_none() && config.squares.is_none() && config.along.is_none() {
        config.coefficients = Some(VESSELS);
    }
    let grid = Grid::new(&config.shape(), config.spacing)
        .map_err(|error| Error::config("size", error.to_string()))?;
    crate::check_memory("size", grid, config.bytes_per_voxel(), context)?;
    let notes = written::coefficients(&config)?.unbounded();
    let flow = match config.precision {
        Precision::F32 => descent::<f32>(&config, context)?,
        Precision::F64 => descent::<f64>(&config, context)?,
    };
    let notes = notes.into_iter().map(|why| format!("the energy has no lower bound: {why}"));
    Ok(Box::new(Texture {
        config,
        grid,
        flow,
        history: Vec::new(),
        notes: notes.collect(),
        ended: false,
        looked: RefCell::new(None),
    }))
}

fn descent<T: Stored>(config: &Config, context: &Context<'_>) -> Result<Box<dyn Descent>> {
    let energy = Energy::<T>::new(written::energy(config, context)?)?;
    let mask = mask::<T>(config, context)?;
    let rate = |default: f64| config.rate.unwrap_or(default);
    if config.flow == Flow::Paper {
        let adam = AdamConfig { rate: rate(1e-3), ..PaperConfig::default().adam };
        let mut flow = Paper::new(energy, potential(config)?, PaperConfig { adam }, context.seed)?;
        if let Some(mask) = mask {
            flow = flow.with_mask(mask);
        }
        return Ok(Box::new(flow));
    }
    let phase = start::phase(config, context)?;
    if config.flow == Flow::Fast {
        return fast(config, context, energy, mask, phase);
    }
    let u = match phase {
        Some(phase) => phase.into_iter().map(<T as Real>::from_f64).collect(),
        None => {
            let mass = written::mass(config);
            start::noise(config.shape(), config.spacing, config.blur, &mass, context.seed)?
        }
    };
    let keep_mass = config.flow == Flow::L2Mass;
    // The preconditioner is a spectrum, which wants a box without ends and no blur.
    let beta = (keep_mass && config.boundary == Boundary::Periodic).then_some(1.0);
    let sigma = (config.blur > 0.0 && beta.is_none()).then_some(config.blur);
    let settings = DescentConfig { sigma, keep_mass, beta, ..DescentConfig::default() };
    Ok(Box::new(flow::Descent::new(energy, settings, mask, u)?))
}

/// The fast flow: from noise after an opening, from a phase at once.
fn fast<T: Stored>(
    config: &Config,
    context: &Context<'_>,
    energy: Energy<T>,
    mask: Option<Mask<T>>,
    phase: Option<Vec<f64>>,
) -> Result<Box<dyn Descent>> {
    let settings = config.opened();
    let Some(phase) = phase else {
        let mut flow = Opened::new(energy, potential(config)?, settings, context.seed)?;
        if let Some(mask) = mask {
            flow = flow.with_mask(mask);
        }
        return Ok(Box::new(flow));
    };
    let u = phase.into_iter().map(<T as Real>::from_f64).collect();
    let mut flow = Fast::new(energy, settings.fast, u)?;
    if let Some(mask) = mask {
        flow = flow.with_mask(mask);
    }
    Ok(Box::new(flow))
}

fn potential<T: Stored>(config: &Config) -> Result<Potential<T>> {
    let mass = written::mass(config);
    Ok(Potential::new(config.shape(), config.spacing, config.blur, &mass)?)
}

/// u = 1 where the shape must be, -1 where it must not.
fn mask<T: Stored>(config: &Config, context: &Context<'_>) -> Result<Option<Mask<T>>> {
    if config.include.is_none() && config.exclude.is_none() {
        return Ok(None);
    }
    let mut values = vec![f64::NAN; config.shape().iter().product()];
    for (key, path, value) in
        [("include", &config.include, 1.0), ("exclude", &config.exclude, -1.0)]
    {
        let Some(path) = path else { continue };
        let field = start::field(key, path, config, context)?;
        for (n, (given, &inside)) in values.iter_mut().zip(field.as_slice()).enumerate() {
            if inside > 0.5 && !given.is_nan() {
                let reason = format!("voxel {n} is in `include` too");
                return Err(Error::config(key, reason));
            }
            if inside > 0.5 {
                *given = value;
            }
        }
    }
    Ok(Some(Mask::new(values.into_iter().map(<T as Real>::from_f64).collect())?))
}

impl Texture {
    /// The surface, closed at the box's faces or open.
    fn surface(&self, closed: bool) -> isosurface::Surface {
        let caps = match (self.config.boundary, closed) {
            (Boundary::Periodic, false) => Caps::Periodic,
            (Boundary::Periodic, true) => Caps::PeriodicClosed,
            (_, false) => Caps::Open,
            (_, true) => Caps::Closed,
        };
        view::surface(self.phase(), self.config.level, caps)
    }

    /// Lengths of the box along x, y, z.
    fn size(&self) -> [f64; 3] {
        let [nz, ny, nx] = self.grid.shape().map(|n| n as f64 * self.config.spacing);
        [nx, ny, nz]
    }

    fn phase(&self) -> Field {
        Field::from_vec(self.grid, self.flow.phase())
            .unwrap_or_else(|_| Field::constant(self.grid, 0.0))
    }

    fn last(&self) -> [f64; 2] {
        self.history.last().copied().unwrap_or([f64::NAN; 2])
    }

    /// What costs more than a step: known at the end and at some observations, NaN at the others.
    fn looks(&self) -> Vec<Metric> {
        let (n, all) = (self.iterations(), self.config.evaluations);
        let every = all.div_ceil(LOOKS).next_multiple_of(observation_interval(all));
        // The surface of the noise at the start is large and means nothing.
        if self.ended || (n > 0 && n.is_multiple_of(every)) {
            return self.look();
        }
        LOOKED.map(|name| Metric::new(name, f64::NAN, "1")).to_vec()
    }

    /// Measures the current state, once.
    fn look(&self) -> Vec<Metric> {
        let n = self.history.len();
        let mut looked = self.looked.borrow_mut();
        match &*looked {
            Some((at, metrics)) if *at == n => metrics.clone(),
            _ => looked.insert((n, self.measure())).1.clone(),
        }
    }

    fn measure(&self) -> Vec<Metric> {
        let mesh = if self.config.boundary == Boundary::Periodic {
            self.surface(false).mesh.on_torus(self.size())
        } else {
            self.surface(true).mesh
        };
        let genus = mesh.genus().map_or(f64::NAN, |genus| genus as f64);
        let values = [self.flow.discrepancy(), self.mass(), genus, mesh.components() as f64];
        LOOKED.iter().zip(values).map(|(name, value)| Metric::new(name, value, "1")).collect()
    }

    fn mass(&self) -> f64 {
        let phase = self.phase();
        solvers::field::sum(phase.as_slice(), |u| u) / phase.as_slice().len() as f64
    }
}

impl Run for Texture {
    fn step(&mut self) -> Result<Status> {
        let (StepInfo { energy, gradient_norm, .. }, stuck) = self.flow.step()?;
        self.history.push([energy, gradient_norm]);
        let n = self.history.len();
        let before = n.checked_sub(PATIENCE).map(|before| self.history[before][0]);
        let still = before
            .is_some_and(|before| (before - energy).abs() < self.config.tolerance * before.abs());
        self.ended = stuck || still || self.flow.evaluations() >= self.config.evaluations;
        Ok(if self.ended { Status::Done } else { Status::Running })
    }

    fn iterations(&self) -> u64 {
        self.history.len() as u64
    }

    fn max_iterations(&self) -> u64 {
        self.config.evaluations
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn metrics(&self) -> Vec<Metric> {
        let [energy, gradient] = self.last();
        let mut metrics = vec![
            Metric::new("energy", energy, "1"),
            Metric::new("surface_energy", energy / SIGMA, "1"),
            Metric::new("gradient_norm", gradient, "1"),
            Metric::new("area", self.surface(false).mesh.area(), "length^2"),
            Metric::new("volume", self.surface(true).mesh.volume(), "length^3"),
            Metric::new("evaluations", self.flow.evaluations() as f64, "1"),
        ];
        metrics.extend(self.look());
        metrics
    }

    fn observe(&self) -> Vec<Metric> {
        let [energy, gradient] = self.last();
        let mut metrics =
            vec![Metric::new("energy", energy, "1"), Metric::new("gradient_norm", gradient, "1")];
        metrics.extend(self.looks());
        metrics
    }

    fn artifacts(&self) -> Vec<Artifact> {
        // Large boxes have large meshes: never two of them at once.
        let diagram = self.flow.diagram(&self.surface(false).mesh);
        let mut artifacts = diagram.map_or_else(|_| Vec::new(), view::diagram);
        let shape = view::shape("shape", self.surface(true), self.size());
        artifacts.extend([
            Artifact::Surface(Surface { turntable: self.config.turntable, ..shape }),
            view::phase(self.phase()),
            view::history(&self.history),
        ]);
        artifacts
    }

    fn frame(&self) -> Option<Image> {
        Some(view::slice(&self.phase(), self.config.level))
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = self.notes.clone();
        match self.flow.halvings() {
            0 => {}
            n => notes.push(format!(
                "the energy rose above that at which the fast flow began: the rate was halved, {n} times in all"
            )),
        }
        notes
    }

    fn save(&self) -> State {
        let mut state = State::default();
        state.put_f64("history", self.history.as_flattened());
        self.flow.save(&mut state);
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        let history = state.all_f64("history")?;
        if history.len() % 2 != 0 {
            return Err(Error::Checkpoint("`history` holds half an evaluation".into()));
        }
        self.history = history.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        self.flow.restore(state)
    }
}
