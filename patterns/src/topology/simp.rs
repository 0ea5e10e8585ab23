//! Optimization of a density per element.
//!
//! Order of the steps as in the 99 and the 88 lines: analyse, print, update; the
//! compliance that belongs to an iteration is that of the design before its update.

use super::{
    analysis::Analysis,
    build::Problem,
    config::{Cases, Config, Filter, Interpolation, Rules},
    design::{Design, Variant},
    interpolation::Law,
    update::{Functions, Update},
};
use crate::{Error, Result, State};
use solvers::optimize::OptimalityCriteria;

/// Tolerance of an iterative solver: this part of the last change of the design (Amir,
/// Stolpe & Sigmund 2010: a residual that is small beside the step does not change its way),
/// between the two bounds.
const TOLERANCE_PER_CHANGE: f64 = 2.5e-3;
const TOLERANCES: [f64; 2] = [1e-8, 5e-4];

/// Objective to which the moving asymptotes scale the first design's: they like 1 to 100.
const SCALED: f64 = 10.0;

/// State of a run.
pub(super) struct Simp {
    design: Design,
    update: Update,
    functions: Functions,
    /// Design variables.
    pub(super) x: Vec<f64>,
    /// Physical densities of `x`.
    pub(super) rho: Vec<f64>,
    pub(super) beta: f64,
    /// Penalization; it rises to the wanted one before beta rises.
    p: f64,
    /// Objective of the design before the last update, volume after it, greatest change.
    pub(super) objective: f64,
    pub(super) volume: f64,
    pub(super) change: f64,
    scale: f64,
    /// Iterations since the penalization was last raised, or the step sharpened.
    since: u64,
    work: Vec<f64>,
}

impl Simp {
    pub(super) fn new(config: &Config, problem: &Problem) -> Result<Self> {
        let n = problem.grid.len();
        let vanishes = config.rules == Rules::Lines88 || config.projection.is_some();
        if vanishes && config.interpolation == Interpolation::Simp {
            let reason = "`simp` has no stiffness at density 0, which the 88 rules and a \
                          projection reach; take `modified` or `ramp`";
            return Err(Error::config("interpolation", reason));
        }
        let design = Design::new(config, problem)?;
        let count = groups(config, problem);
        let update = Update::new(config, &design, n, count)?;
        let beta = config.projection.map_or(0.0, |projection| projection.beta);
        let mut simp = Self {
            functions: Functions::new(count, n),
            x: vec![config.volume; n],
            rho: vec![0.0; n],
            work: vec![0.0; n],
            beta,
            p: config.penalization_start.unwrap_or(config.penalization),
            objective: f64::NAN,
            volume: config.volume,
            change: 1.0,
            scale: 0.0,
            since: 0,
            design,
            update,
        };
        simp.design.fix(&mut simp.x);
        simp.design.physical(&simp.x, beta, Variant::Intermediate, &mut simp.rho)?;
        Ok(simp)
    }

    /// One iteration; whether the design has come to rest.
    pub(super) fn step(
        &mut self,
        config: &Config,
        problem: &Problem,
        analysis: &mut Analysis,
    ) -> Result<bool> {
        // Every variant of a robust design has its own solves; the written one is intermediate.
        let tied = (TOLERANCE_PER_CHANGE * self.change).clamp(TOLERANCES[0], TOLERANCES[1]);
        let tolerance = config.solver_tolerance.unwrap_or(tied);
        let law = Law::new(config, self.p);
        let Self { design, update, functions, x, rho, work, .. } = self;
        let beta = self.beta;
        let mut evaluator =
            Evaluator { config, problem, analysis, design, law, beta, tolerance, rho };
        evaluator.evaluate(x, functions)?;
        self.objective = functions.greatest();
        if !self.objective.is_finite() {
            let reason = format!("the objective became {}", self.objective);
            return Err(solvers::Error::Invalid(reason).into());
        }
        if self.scale == 0.0 {
            self.scale = SCALED / self.objective.abs().max(f64::MIN_POSITIVE);
        }
        match update {
            Update::Oc(oc) => optimality_criteria(oc, &mut evaluator, functions, x, work)?,
            _ => {
                let next =
                    update.moving_asymptotes(x, self.scale, functions, |x| evaluator.values(x))?;
                work.copy_from_slice(&next);
            }
        }
        self.change = work.iter().zip(&*x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        x.copy_from_slice(work);
        design.physical(x, beta, Variant::Intermediate, rho)?;
        self.volume = mean(rho);
        self.since += 1;
        Ok(self.rests(config))
    }

    /// Whether the change is small, the penalization whole and the step sharp; raises the one,
    /// then the other when it is time.
    fn rests(&mut self, config: &Config) -> bool {
        let quiet = self.change <= config.tolerance;
        if self.p < config.penalization {
            if quiet || self.since >= config.penalization_every {
                self.p = (self.p + config.penalization_step).min(config.penalization);
                self.since = 0;
            }
            return false;
        }
        let Some(projection) = config.projection else { return quiet };
        if self.beta >= projection.beta_max {
            return quiet;
        }
        if quiet || self.since >= projection.every {
            self.beta = (2.0 * self.beta).min(projection.beta_max);
            self.since = 0;
        }
        false
    }

    pub(super) fn save(&self, state: &mut State) {
        state.put_f64("x", &self.x);
        let numbers = [self.beta, self.p, self.objective, self.volume, self.change, self.scale];
        state.put_f64("numbers", &numbers);
        state.put_u64("since", &[self.since]);
        state.put_u8("optimizer", &self.update.save());
    }

    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        state.get_f64("x", &mut self.x)?;
        let mut numbers = [0.0; 6];
        state.get_f64("numbers", &mut numbers)?;
        [self.beta, self.p, self.objective, self.volume, self.change, self.scale] = numbers;
        self.since = state.one_u64("since")?;
        self.update.restore(state.all_u8("optimizer")?)?;
        self.design.physical(&self.x, self.beta, Variant::Intermediate, &mut self.rho)
    }
}

/// The steps whose worst counts; the volume is that of the last.
fn variants(config: &Config) -> &'static [Variant] {
    match config.projection {
        Some(projection) if projection.delta > 0.0 => {
            &[Variant::Eroded, Variant::Intermediate, Variant::Dilated]
        }
        _ => &[Variant::Intermediate],
    }
}

/// Number of objectives whose greatest counts.
pub(super) fn groups(config: &Config, problem: &Problem) -> usize {
    let cases = if config.cases == Cases::Worst { problem.cases.len() } else { 1 };
    cases * variants(config).len()
}

/// Everything that the functions of a design depend on, but the design.
pub(super) struct Evaluator<'a> {
    pub(super) config: &'a Config,
    pub(super) problem: &'a Problem,
    pub(super) analysis: &'a mut Analysis,
    pub(super) design: &'a mut Design,
    pub(super) law: Law,
    pub(super) beta: f64,
    /// Relative residual asked of an iterative solver.
    pub(super) tolerance: f64,
    /// Physical densities of the variant at hand.
    pub(super) rho: &'a mut [f64],
}

impl Evaluator<'_> {
    /// Functions and gradients by the design variables `x`.
    pub(super) fn evaluate(&mut self, x: &[f64], functions: &mut Functions) -> Result<()> {
        let Self { config, problem, law, beta, tolerance, .. } = *self;
        let (analysis, design, rho) = (&mut *self.analysis, &mut *self.design, &mut *self.rho);
        let n = x.len() as f64;
        let worst = config.cases == Cases::Worst;
        let groups = if worst { problem.cases.len() } else { 1 };
        let mut intermediate = 0.0;
        for (variant, objectives) in
            variants(config).iter().zip(functions.objectives.chunks_mut(groups))
        {
            design.physical(x, beta, *variant, rho)?;
            analysis.solve(problem, rho, law, tolerance)?;
            for (value, gradient) in objectives.iter_mut() {
                *value = 0.0;
                gradient.fill(0.0);
            }
            for (case, (weight, _)) in problem.cases.iter().enumerate() {
                let (value, gradient) = &mut objectives[if worst { case } else { 0 }];
                let case = (case, *weight);
                *value += weight * analysis.objective(problem, config, case, rho, law, gradient)?;
            }
            for (_, gradient) in objectives.iter_mut() {
                design.chain(beta, *variant, gradient)?;
                design.filter_sensitivity(x, gradient);
                problem.symmetrize(gradient);
            }
            if *variant == Variant::Intermediate {
                intermediate = mean(rho);
            }
        }
        let last = variants(config)[variants(config).len() - 1];
        let (excess, gradient) = &mut functions.volume;
        *excess = excess_volume(config, mean(rho), intermediate);
        gradient.fill(1.0 / n);
        design.chain(beta, last, gradient)?;
        problem.symmetrize(gradient);
        Ok(())
    }

    /// Objectives and excess volume of a trial, without gradients.
    fn values(&mut self, x: &[f64]) -> Result<(Vec<f64>, f64)> {
        let Self { config, problem, law, beta, tolerance, .. } = *self;
        let (analysis, design, rho) = (&mut *self.analysis, &mut *self.design, &mut *self.rho);
        let mut objectives = Vec::new();
        let mut intermediate = 0.0;
        for variant in variants(config) {
            design.physical(x, beta, *variant, rho)?;
            analysis.solve(problem, rho, law, tolerance)?;
            let cases = problem.cases.iter().enumerate();
            let values = cases
                .map(|(case, (weight, _))| weight * analysis.value(problem, config, case, rho));
            if config.cases == Cases::Worst {
                objectives.extend(values);
            } else {
                objectives.push(values.sum());
            }
            if *variant == Variant::Intermediate {
                intermediate = mean(rho);
            }
        }
        Ok((objectives, excess_volume(config, mean(rho), intermediate)))
    }
}

/// Volume of the last variant less its target, which is such that the intermediate design has
/// the wanted one.
fn excess_volume(config: &Config, last: f64, intermediate: f64) -> f64 {
    last - config.volume * last / intermediate
}

fn mean(rho: &[f64]) -> f64 {
    rho.iter().sum::<f64>() / rho.len() as f64
}

/// Writes the next design to `next`.
fn optimality_criteria(
    oc: &mut OptimalityCriteria,
    evaluator: &mut Evaluator<'_>,
    functions: &mut Functions,
    x: &[f64],
    next: &mut [f64],
) -> Result<()> {
    let Functions { objectives, volume: (_, dv) } = functions;
    let Some((_, gradient)) = objectives.first() else { return Ok(()) };
    let n = x.len() as f64;
    // Volume as a number of elements, as in the programs.
    dv.iter_mut().for_each(|d| *d *= n);
    let target = evaluator.config.volume * n;
    let (beta, rho, design) = (evaluator.beta, &mut *evaluator.rho, &mut *evaluator.design);
    let fixed = |e: usize| design.fixed(e);
    let plain = matches!(evaluator.config.filter, Filter::None | Filter::Sensitivity);
    let found = if plain {
        // Plain sums: fixed elements included, as Sigmund counts.
        let volume = |x: &[f64]| x.iter().sum::<f64>() - target;
        oc.update_sum(x, gradient, None, target, volume)?
    } else if evaluator.config.projection.is_none() {
        // A filter is linear: its volume is the product with the derivatives.
        let rest: f64 = (0..x.len()).filter_map(fixed).sum::<f64>() - target;
        let weights: &[f64] = dv;
        let volume = |x: &[f64]| x.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>() + rest;
        oc.update(x, gradient, Some(&positive(dv)), volume)?
    } else {
        let volume = |x: &[f64]| match design.physical(x, beta, Variant::Intermediate, rho) {
            Ok(()) => rho.iter().sum::<f64>() - target,
            Err(_) => f64::NAN,
        };
        oc.update(x, gradient, Some(&positive(dv)), volume)?
    };
    next.copy_from_slice(found);
    Ok(())
}

/// Derivatives of the volume may vanish far from a sharp step and beside fixed material; the
/// criteria divide by them.
fn positive(dv: &[f64]) -> Vec<f64> {
    dv.iter().map(|d| d.max(1e-12)).collect()
}
