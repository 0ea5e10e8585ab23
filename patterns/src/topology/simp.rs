//! Optimization of a density per element.
//!
//! Order of the steps as in the 99 and the 88 lines: analyse, print, update; the
//! compliance that belongs to an iteration is that of the design before its update.

use super::{
    analysis::Analysis,
    config::{Cases, Config, Interpolation, Rules},
    design::{Design, Variant},
    interpolation::Law,
    problem::Problem,
    update::{Functions, Update},
};
use crate::{Error, Result, State};

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
    /// Design variables.
    pub(super) x: Vec<f64>,
    /// Physical densities of `x`.
    pub(super) rho: Vec<f64>,
    pub(super) beta: f64,
    /// Objective of the design before the last update, volume after it, greatest change.
    pub(super) objective: f64,
    pub(super) volume: f64,
    pub(super) change: f64,
    scale: f64,
    /// Iterations since the step was last sharpened.
    since: u64,
}

impl Simp {
    pub(super) fn new(config: &Config, problem: &Problem) -> Result<Self> {
        let n = problem.grid.len();
        if config.rules == Rules::Lines88 && config.interpolation == Interpolation::Simp {
            let reason = "`simp` has no stiffness at density 0; take `modified`, or rules 99";
            return Err(Error::config("interpolation", reason));
        }
        let design = Design::new(config, problem)?;
        let update = Update::new(config, &design, n, groups(config, problem))?;
        let beta = config.projection.map_or(0.0, |projection| projection.beta);
        let mut simp = Self {
            x: vec![config.volume; n],
            rho: vec![0.0; n],
            beta,
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

    /// Relative residual asked of an iterative solver.
    fn tolerance(&self) -> f64 {
        (TOLERANCE_PER_CHANGE * self.change).clamp(TOLERANCES[0], TOLERANCES[1])
    }

    /// One iteration; whether the design has come to rest.
    pub(super) fn step(
        &mut self,
        config: &Config,
        problem: &Problem,
        analysis: &mut Analysis,
    ) -> Result<bool> {
        let law = Law::new(config, config.penalization);
        let functions = self.evaluate(config, problem, analysis, law)?;
        self.objective =
            functions.objectives.iter().map(|(f, _)| *f).fold(f64::NEG_INFINITY, f64::max);
        if !self.objective.is_finite() {
            return Err(solvers::Error::Invalid(format!(
                "the objective became {}",
                self.objective
            ))
            .into());
        }
        let next = match self.update.oc() {
            Some(_) => self.optimality_criteria(config, functions)?,
            None => self.moving_asymptotes(config, problem, analysis, law, &functions)?,
        };
        self.change = next.iter().zip(&self.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        self.x = next;
        self.design.physical(&self.x, self.beta, Variant::Intermediate, &mut self.rho)?;
        self.volume = self.rho.iter().sum::<f64>() / self.rho.len() as f64;
        self.since += 1;
        Ok(self.rests(config))
    }

    /// Whether the change is small and the step sharp; sharpens it when it is time.
    fn rests(&mut self, config: &Config) -> bool {
        let quiet = self.change <= config.tolerance;
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

    /// Functions and gradients by the design variables.
    pub(super) fn evaluate(
        &mut self,
        config: &Config,
        problem: &Problem,
        analysis: &mut Analysis,
        law: Law,
    ) -> Result<Functions> {
        let n = self.x.len();
        let mut objectives = Vec::new();
        let mut rho = vec![0.0; n];
        let mut volume = (0.0, vec![0.0; n]);
        for &variant in variants(config) {
            self.design.physical(&self.x, self.beta, variant, &mut rho)?;
            analysis.solve(problem, &rho, law, self.tolerance())?;
            let start = objectives.len();
            for (case, (weight, _)) in problem.cases.iter().enumerate() {
                if config.cases == Cases::Worst || case == 0 {
                    objectives.push((0.0, vec![0.0; n]));
                }
                let Some((value, gradient)) = objectives.last_mut() else { continue };
                *value += weight
                    * analysis.objective(problem, config, (case, *weight), &rho, law, gradient)?;
            }
            for (_, gradient) in &mut objectives[start..] {
                self.design.chain(self.beta, variant, gradient)?;
                self.design.filter_sensitivity(&self.x, gradient);
                self.design.symmetrize(gradient);
            }
            if Some(&variant) == variants(config).last() {
                volume.0 = rho.iter().sum::<f64>() / n as f64 - self.volume_target(config, &rho)?;
                volume.1.fill(1.0 / n as f64);
                self.design.chain(self.beta, variant, &mut volume.1)?;
                self.design.symmetrize(&mut volume.1);
            }
        }
        Ok(Functions { objectives, volume })
    }

    /// Volume that the last variant may have, so that the intermediate design has the wanted one.
    fn volume_target(&mut self, config: &Config, last: &[f64]) -> Result<f64> {
        if variants(config).len() == 1 {
            return Ok(config.volume);
        }
        let mut intermediate = vec![0.0; last.len()];
        self.design.physical(&self.x, self.beta, Variant::Intermediate, &mut intermediate)?;
        let ratio = last.iter().sum::<f64>() / intermediate.iter().sum::<f64>();
        // `chain` needs the filtered densities only, which do not depend on the variant.
        Ok(config.volume * ratio)
    }

    fn optimality_criteria(&mut self, config: &Config, functions: Functions) -> Result<Vec<f64>> {
        let Some((_, gradient)) = functions.objectives.first() else {
            return Ok(self.x.clone());
        };
        let n = self.x.len() as f64;
        // Volume as a number of elements, as in the programs.
        let dv: Vec<f64> = functions.volume.1.iter().map(|d| d * n).collect();
        let plain = dv.iter().zip(0..).all(|(&d, e)| d == 1.0 || self.design.fixed(e).is_some());
        let linear = self.design.linear_volume()?;
        let (design, beta) = (&mut self.design, self.beta);
        let Some(oc) = self.update.oc() else { return Ok(self.x.clone()) };
        let dv = (!plain).then(|| positive(dv));
        let target = config.volume * n;
        let next = match linear {
            // Plain sums: passive elements included, as Sigmund counts.
            Some(_) if plain => {
                let volume = |x: &[f64]| x.iter().sum::<f64>() - target;
                oc.update_sum(&self.x, gradient, dv.as_deref(), target, volume)?
            }
            Some(weights) => {
                let fixed: f64 = (0..weights.len()).filter_map(|e| design.fixed(e)).sum();
                let volume = |x: &[f64]| {
                    x.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>() + fixed - target
                };
                oc.update(&self.x, gradient, dv.as_deref(), volume)?
            }
            None => {
                let mut rho = vec![0.0; self.x.len()];
                let volume =
                    |x: &[f64]| match design.physical(x, beta, Variant::Intermediate, &mut rho) {
                        Ok(()) => rho.iter().sum::<f64>() - target,
                        Err(_) => f64::NAN,
                    };
                oc.update(&self.x, gradient, dv.as_deref(), volume)?
            }
        };
        Ok(next.to_vec())
    }

    fn moving_asymptotes(
        &mut self,
        config: &Config,
        problem: &Problem,
        analysis: &mut Analysis,
        law: Law,
        functions: &Functions,
    ) -> Result<Vec<f64>> {
        if self.scale == 0.0 {
            self.scale = SCALED / self.objective.abs().max(f64::MIN_POSITIVE);
        }
        let (x, scale) = (self.x.clone(), self.scale);
        // A move out of `self`, because a trial is evaluated with the rest of it.
        let mut update = std::mem::replace(&mut self.update, placeholder(x.len())?);
        let next = update.moving_asymptotes(&x, scale, functions, |trial| {
            self.x.copy_from_slice(trial);
            let functions = self.evaluate(config, problem, analysis, law)?;
            let values = functions.objectives.iter().map(|(f, _)| *f).collect();
            Ok((values, functions.volume.0))
        });
        self.update = update;
        self.x = x;
        next
    }

    pub(super) fn save(&self, state: &mut State) {
        state.put_f64("x", &self.x);
        let numbers = [self.beta, self.objective, self.volume, self.change, self.scale];
        state.put_f64("numbers", &numbers);
        state.put_u64("since", &[self.since]);
        state.put_u8("optimizer", &self.update.save());
    }

    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        state.get_f64("x", &mut self.x)?;
        let mut numbers = [0.0; 5];
        state.get_f64("numbers", &mut numbers)?;
        [self.beta, self.objective, self.volume, self.change, self.scale] = numbers;
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
fn groups(config: &Config, problem: &Problem) -> usize {
    let cases = if config.cases == Cases::Worst { problem.cases.len() } else { 1 };
    cases * variants(config).len()
}

/// Derivatives of the volume may vanish far from a sharp step; the criteria divide by them.
fn positive(mut dv: Vec<f64>) -> Vec<f64> {
    dv.iter_mut().for_each(|d| *d = d.max(1e-12));
    dv
}

/// Stands in for the optimizer while that is in use.
fn placeholder(n: usize) -> Result<Update> {
    let bounds = solvers::optimize::Bounds::uniform(n, 0.0, 1.0)?;
    let oc = solvers::optimize::OcConfig::top88();
    Ok(Update::Oc(Box::new(solvers::optimize::OptimalityCriteria::new(bounds, oc)?)))
}
