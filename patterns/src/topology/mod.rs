//! Topology optimization: material in a box that makes a structure stiff.
//!
//! Densities by optimality criteria or moving asymptotes (Sigmund 2001; Andreassen et
//! al. 2011; Svanberg 2007), or a front that moves by the shape derivative (Algorithm 2 of
//! Chattopadhyay & Mukherjee, made to work), on one finite-element model.
//!
//! Metrics: `compliance` (of the design before the last update, as the published programs
//! print it), `compliance_final` (of the design that is written), `compliance_thresholded`
//! (of its blackest elements, as many as the volume allows, with void 1e-9), `volume`,
//! `change`, `greyness`. What a stalled solver could not find is left out.

mod analysis;
mod build;
mod config;
mod database;
mod design;
mod filter;
mod front;
mod interpolation;
mod maps;
mod marks;
mod mechanism;
mod passive;
mod problem;
mod region;
mod simp;
mod speed_shape;
mod stress;
mod update;
mod view;

#[cfg(test)]
mod tests;

pub use config::{
    Cases, Config, Filter, Interpolation, LevelSetConfig, Method, Objective, Optimizer, Projection,
    Rules, Solver,
};
pub use problem::{Load, Material, Output, Passive, Physics, ProblemConfig, Spring, Support};
pub use region::Side;

use crate::{Artifact, Context, Error, Image, Metric, Model, Result, Run, State, Status};
use analysis::{Analysis, VOID};
use build::Problem;
use front::Front;
use interpolation::Law;
use simp::Simp;
use solvers::{
    Field,
    fem::{Choice, LinearSolver},
};

/// Registry entry.
pub static MODEL: Model = Model {
    name: "topopt",
    about: "Material in a box that makes a structure stiff: SIMP and level set",
    paper: "Sigmund 2001, doi:10.1007/s001580050176; Andreassen et al. 2011; \
            Chattopadhyay & Mukherjee, Algorithm 2 and Table 1.1",
    presets: database::presets,
    start,
};

/// Tolerance of the solve that gives `compliance_final`.
const FINAL_TOLERANCE: f64 = 1e-8;

/// Iterations that a run takes as a rule.
const EXPECTED: u64 = 100;

struct TopOpt {
    config: Config,
    problem: Problem,
    analysis: Analysis,
    way: Way,
    notes: Vec<String>,
    done: u64,
}

fn start(table: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>> {
    let config: Config = crate::from_table(&database::expand(table)?)?;
    config.check()?;
    let mut problem = Problem::new(&config, context)?;
    let mut notes = mechanism::hold(&mut problem)?;
    let solver = LinearSolver::new(&problem.system, choice(&config), problem.memory)
        .map_err(|error| Error::config("problem.elements", error.to_string()))?;
    notes.push(format!("{} unknowns, solved by {}", problem.system.unknowns(), solver.name()));
    let analysis = Analysis::new(&problem, solver);
    let way = match config.method {
        Method::Simp => Way::Simp(Box::new(Simp::new(&config, &problem)?)),
        Method::LevelSet => Way::LevelSet(Box::new(Front::new(&config, &problem)?)),
    };
    Ok(Box::new(TopOpt { config, problem, analysis, way, notes, done: 0 }))
}

fn choice(config: &Config) -> Choice {
    match config.solver {
        Solver::Auto => Choice::Auto,
        Solver::Direct => Choice::Direct,
        Solver::Multigrid => Choice::Multigrid,
    }
}

/// The two methods behind one door.
enum Way {
    Simp(Box<Simp>),
    LevelSet(Box<Front>),
}

impl Way {
    /// Physical densities.
    fn rho(&self) -> &[f64] {
        match self {
            Self::Simp(simp) => &simp.rho,
            Self::LevelSet(front) => &front.rho,
        }
    }

    /// Objective, volume and change.
    fn numbers(&self) -> [f64; 3] {
        match self {
            Self::Simp(simp) => [simp.objective, simp.volume, simp.change],
            Self::LevelSet(front) => [front.objective, front.volume, front.change],
        }
    }
}

impl TopOpt {
    /// Objective of the design that is written, and of black and white with its volume.
    fn yardsticks(&self) -> Option<[f64; 2]> {
        let own = self.evaluate(self.way.rho(), self.law())?;
        let order: Vec<f64> = match &self.way {
            Way::Simp(simp) => simp.rho.iter().map(|x| -x).collect(),
            Way::LevelSet(front) => front.phi().as_slice().to_vec(),
        };
        let black = view::threshold(&order, self.config.volume);
        Some([own, self.evaluate(&black, Law::linear(VOID))?])
    }

    /// Objective of densities, by a solver of its own: looking must not change the run.
    fn evaluate(&self, rho: &[f64], law: Law) -> Option<f64> {
        let mut analysis = self.analyse(rho, law)?;
        let cases = self.problem.cases.iter().enumerate();
        let values = cases.map(|(case, (weight, _))| {
            weight * analysis.value(&self.problem, &self.config, case, rho)
        });
        Some(match self.config.cases {
            Cases::Sum => values.sum(),
            Cases::Worst => values.fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// Displacements for densities.
    fn analyse(&self, rho: &[f64], law: Law) -> Option<Analysis> {
        let (system, memory) = (&self.problem.system, self.problem.memory);
        let solver = LinearSolver::new(system, choice(&self.config), memory).ok()?;
        let mut analysis = Analysis::new(&self.problem, solver);
        analysis.solve(&self.problem, rho, law, FINAL_TOLERANCE).ok()?;
        Some(analysis)
    }

    /// Stiffness of the design that is written.
    fn law(&self) -> Law {
        match self.config.method {
            Method::Simp => Law::new(&self.config, self.config.penalization),
            // The front's ersatz material is linear in the solid part.
            Method::LevelSet => Law::linear(self.config.level_set.ersatz),
        }
    }

    fn density(&self) -> Result<Field> {
        Ok(Field::from_vec(self.problem.grid, self.way.rho().to_vec())?)
    }

    /// Name of the objective among the metrics.
    fn name(&self) -> &'static str {
        match self.config.objective {
            Objective::Compliance => "compliance",
            Objective::Displacement => "displacement",
            Objective::Stress => "stress",
        }
    }

    /// Its unit, whatever force and length are in the problem.
    fn unit(&self) -> &'static str {
        match (self.config.objective, self.config.problem.physics) {
            (_, Physics::Heat) => "heat x temperature",
            (Objective::Compliance, _) => "force x length",
            (Objective::Displacement, _) => "length",
            (Objective::Stress, _) => "force / length^2",
        }
    }
}

impl Run for TopOpt {
    fn step(&mut self) -> Result<Status> {
        let (config, problem, analysis) = (&self.config, &self.problem, &mut self.analysis);
        let rests = match &mut self.way {
            Way::Simp(simp) => simp.step(config, problem, analysis)?,
            Way::LevelSet(front) => front.step(config, problem, analysis)?,
        };
        self.done += 1;
        Ok(if rests {
            Status::Done
        } else if self.done >= self.config.iterations {
            Status::NotConverged
        } else {
            Status::Running
        })
    }

    fn iterations(&self) -> u64 {
        self.done
    }

    fn max_iterations(&self) -> u64 {
        self.config.iterations
    }

    fn expected_iterations(&self) -> u64 {
        EXPECTED.min(self.config.iterations)
    }

    fn config(&self) -> toml::Table {
        crate::to_table(&self.config)
    }

    fn observe(&self) -> Vec<Metric> {
        let [objective, volume, change] = self.way.numbers();
        vec![
            Metric::new(self.name(), objective, self.unit()),
            Metric::new("volume", volume, "1"),
            Metric::new("change", change, "1"),
        ]
    }

    fn metrics(&self) -> Vec<Metric> {
        let mut metrics = self.observe();
        if let Some([written, black]) = self.yardsticks() {
            metrics.push(Metric::new(&format!("{}_final", self.name()), written, self.unit()));
            let name = format!("{}_thresholded", self.name());
            metrics.push(Metric::new(&name, black, self.unit()));
        }
        metrics.push(Metric::new("greyness", view::greyness(self.way.rho()), "1"));
        if self.analysis.total_iterations > 0 {
            let total = self.analysis.total_iterations as f64;
            metrics.push(Metric::new("solver_iterations", total, "1"));
            metrics.push(Metric::new("residual", self.analysis.report.residual, "1"));
        }
        metrics
    }

    fn artifacts(&self) -> Vec<Artifact> {
        let Ok(density) = self.density() else { return Vec::new() };
        let mut artifacts = view::artifacts(&self.problem, &density);
        if let Some(analysis) = self.analyse(self.way.rho(), self.law()) {
            let physics = self.config.problem.physics;
            artifacts.extend(maps::artifacts(&self.problem, physics, &analysis, &density));
        }
        artifacts
    }

    fn frame(&self) -> Option<Image> {
        self.density().ok().map(view::ink)
    }

    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn save(&self) -> State {
        let mut state = State::default();
        state.put_u64("done", &[self.done]);
        self.analysis.save(&mut state);
        match &self.way {
            Way::Simp(simp) => simp.save(&mut state),
            Way::LevelSet(front) => front.save(&mut state),
        }
        state
    }

    fn restore(&mut self, state: &State) -> Result<()> {
        self.done = state.one_u64("done")?;
        self.analysis.restore(state)?;
        match &mut self.way {
            Way::Simp(simp) => simp.restore(state),
            Way::LevelSet(front) => front.restore(state),
        }
    }
}
