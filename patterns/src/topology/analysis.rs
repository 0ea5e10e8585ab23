//! Displacements of all load cases, objectives and their gradients.

use super::{
    build::Problem,
    config::{Config, Objective},
    interpolation::Law,
    stress,
};
use crate::{Result, State};
use solvers::fem::{LinearSolver, SolveReport};

/// Stiffness of void when designs of different methods are compared.
pub(super) const VOID: f64 = 1e-9;

/// Relative residual of such an analysis, enough to tell designs apart: the compliance's
/// error is of second order in it.
const BLACK_TOLERANCE: f64 = 1e-5;

/// Relative residual of the adjoints, whose error enters the gradient in full.
const ADJOINT_TOLERANCE: f64 = 1e-8;

/// Displacements and adjoints, with the solver that finds them.
pub(super) struct Analysis {
    pub(super) solver: LinearSolver,
    /// Displacements of each case; the next solve starts from them.
    pub(super) u: Vec<Vec<f64>>,
    /// Adjoint of each case, for objectives that need one.
    adjoint: Vec<Vec<f64>>,
    /// E_e, relative to solid.
    pub(super) stiffness: Vec<f64>,
    force: Vec<f64>,
    energies: Vec<f64>,
    /// Room for a sum of energies over the cases.
    density: Vec<f64>,
    product: Vec<f64>,
    /// The last solves: most iterations and greatest residual.
    pub(super) report: SolveReport,
    /// Iterations of all solves.
    pub(super) total_iterations: u64,
}

/// Adds the weight of elements of density `rho(e)` to nodal forces.
pub(super) fn add_body_force(problem: &Problem, rho: impl Fn(usize) -> f64, force: &mut [f64]) {
    let Some(per_node) = problem.body_force else { return };
    let lattice = problem.system.lattice();
    let components = problem.system.element().components();
    for element in 0..lattice.element_count() {
        let (first, rho) = (lattice.first_node(element), rho(element));
        for offset in &lattice.offsets()[..lattice.corners()] {
            for axis in 0..components {
                force[(first + offset) * components + axis] += rho * per_node[axis];
            }
        }
    }
}

impl Analysis {
    pub(super) fn new(problem: &Problem, solver: LinearSolver) -> Self {
        let unknowns = vec![0.0; problem.system.unknowns()];
        let elements = vec![0.0; problem.grid.len()];
        Self {
            solver,
            u: vec![unknowns.clone(); problem.cases.len()],
            adjoint: vec![unknowns.clone(); problem.cases.len()],
            stiffness: elements.clone(),
            force: unknowns.clone(),
            density: elements.clone(),
            energies: elements,
            product: unknowns,
            report: SolveReport::default(),
            total_iterations: 0,
        }
    }

    /// Displacements of every case for physical densities `rho`.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        rho: &[f64],
        law: Law,
        tolerance: f64,
    ) -> Result<()> {
        self.stiffness.iter_mut().zip(rho).for_each(|(e, &x)| *e = law.stiffness(x));
        self.solve_stiffness(problem, rho, tolerance)
    }

    /// As [`Analysis::solve`], for the stiffnesses that stand in `self.stiffness`.
    pub(super) fn solve_stiffness(
        &mut self,
        problem: &Problem,
        rho: &[f64],
        tolerance: f64,
    ) -> Result<()> {
        self.solver.prepare(&problem.system, &self.stiffness)?;
        self.report = SolveReport::default();
        for case in 0..problem.cases.len() {
            self.force.copy_from_slice(&problem.cases[case].1);
            add_body_force(problem, |e| rho[e], &mut self.force);
            if let Some(values) = &problem.prescribed {
                problem.system.multiply(&self.stiffness, values, &mut self.product);
                self.force.iter_mut().zip(&self.product).for_each(|(f, p)| *f -= p);
            }
            let u = &mut self.u[case];
            let report = self.solver.solve(&problem.system, &self.force, u, tolerance)?;
            if let Some(values) = &problem.prescribed {
                u.iter_mut().zip(values).for_each(|(u, v)| *u += v);
            }
            self.note(report);
        }
        Ok(())
    }

    /// Displacements and adjoints: the next solves start from them.
    pub(super) fn save(&self, state: &mut State) {
        for (case, (u, m)) in self.u.iter().zip(&self.adjoint).enumerate() {
            state.put_f64(&format!("u{case}"), u);
            state.put_f64(&format!("adjoint{case}"), m);
        }
        state.put_u64("solver_iterations", &[self.total_iterations]);
    }

    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        for (case, (u, m)) in self.u.iter_mut().zip(&mut self.adjoint).enumerate() {
            state.get_f64(&format!("u{case}"), u)?;
            state.get_f64(&format!("adjoint{case}"), m)?;
        }
        self.total_iterations = state.one_u64("solver_iterations")?;
        Ok(())
    }

    fn note(&mut self, report: SolveReport) {
        self.report.iterations = self.report.iterations.max(report.iterations);
        self.report.residual = self.report.residual.max(report.residual);
        self.total_iterations += report.iterations as u64;
    }

    /// Objective of a case; adds its derivatives by the physical densities to `gradient`,
    /// times `weight`.
    pub(super) fn objective(
        &mut self,
        problem: &Problem,
        config: &Config,
        (case, weight): (usize, f64),
        rho: &[f64],
        law: Law,
        gradient: &mut [f64],
    ) -> Result<f64> {
        match config.objective {
            Objective::Compliance => Ok(self.compliance(problem, case, weight, rho, law, gradient)),
            Objective::Displacement => {
                let output = problem.output.as_deref().unwrap_or_default();
                let value: f64 = output.iter().zip(&self.u[case]).map(|(l, u)| l * u).sum();
                self.add_adjoint(problem, (case, weight), output, rho, law, gradient)?;
                Ok(value)
            }
            Objective::Stress => {
                // `product` is free after the solves.
                let mut right = std::mem::take(&mut self.product);
                right.fill(0.0);
                let u = &self.u[case];
                let exponent = config.stress_exponent;
                let value = stress::p_norm(problem, exponent, u, rho, weight, &mut right, gradient);
                let added = self.add_adjoint(problem, (case, weight), &right, rho, law, gradient);
                self.product = right;
                added.map(|()| value)
            }
        }
    }

    /// `c = 2 f.u - u.K u`: `f.u`, less the work of prescribed displacements, as in
    /// Niu, Xu & Cheng 2011; its derivative needs no adjoint.
    fn compliance(
        &mut self,
        problem: &Problem,
        case: usize,
        weight: f64,
        rho: &[f64],
        law: Law,
        gradient: &mut [f64],
    ) -> f64 {
        let u = &self.u[case];
        problem.system.energies(u, u, &mut self.energies);
        let parts = self.stiffness.iter().zip(&self.energies).map(|(e, energy)| e * energy);
        let elastic: f64 = parts.sum();
        for ((g, energy), &x) in gradient.iter_mut().zip(&self.energies).zip(rho) {
            *g -= weight * law.derivative(x) * energy;
        }
        if problem.prescribed.is_none()
            && problem.body_force.is_none()
            && problem.system.springs().is_empty()
        {
            // The same number, summed as the published programs do.
            return elastic;
        }
        self.force.copy_from_slice(&problem.cases[case].1);
        add_body_force(problem, |e| rho[e], &mut self.force);
        let springs: f64 = problem.system.springs().iter().zip(u).map(|(k, u)| k * u * u).sum();
        let work: f64 = self.force.iter().zip(u).map(|(f, u)| f * u).sum();
        add_weight_derivative(problem, 2.0 * weight, u, gradient);
        2.0 * work - elastic - springs
    }

    /// Adds `weight d(l . u)/d rho` for `l` constant: with `K m = l` it is `-m . dK u + m . df`.
    fn add_adjoint(
        &mut self,
        problem: &Problem,
        (case, weight): (usize, f64),
        l: &[f64],
        rho: &[f64],
        law: Law,
        gradient: &mut [f64],
    ) -> Result<()> {
        let m = &mut self.adjoint[case];
        let report = self.solver.solve(&problem.system, l, m, ADJOINT_TOLERANCE)?;
        problem.system.energies(m, &self.u[case], &mut self.energies);
        for ((g, energy), &x) in gradient.iter_mut().zip(&self.energies).zip(rho) {
            *g -= weight * law.derivative(x) * energy;
        }
        add_weight_derivative(problem, weight, &self.adjoint[case], gradient);
        self.note(report);
        Ok(())
    }

    /// Compliance of densities 0 and 1 with the void that designs are compared with.
    pub(super) fn black_and_white(&mut self, problem: &Problem, black: &[f64]) -> Result<f64> {
        self.solve(problem, black, Law::linear(VOID), BLACK_TOLERANCE)?;
        let mut energy = std::mem::take(&mut self.density);
        self.energy_density(problem, &mut energy);
        let value = energy.iter().zip(&self.stiffness).map(|(w, e)| w * e).sum();
        self.density = energy;
        Ok(value)
    }

    /// Energy `u_e . K_e u_e` of each element at stiffness 1, summed over the cases by weight.
    pub(super) fn energy_density(&mut self, problem: &Problem, density: &mut [f64]) {
        density.fill(0.0);
        for (case, (weight, _)) in problem.cases.iter().enumerate() {
            problem.system.energies(&self.u[case], &self.u[case], &mut self.energies);
            density.iter_mut().zip(&self.energies).for_each(|(d, e)| *d += weight * e);
        }
    }
}

/// Adds `factor v . db/d rho_e` for the weight b.
fn add_weight_derivative(problem: &Problem, factor: f64, v: &[f64], gradient: &mut [f64]) {
    let Some(per_node) = problem.body_force else { return };
    let components = problem.system.element().components();
    let n = problem.system.element().unknowns();
    let mut local = [0.0; 24];
    for (element, g) in gradient.iter_mut().enumerate() {
        problem.system.gather(element, v, &mut local[..n]);
        let work: f64 =
            local[..n].iter().enumerate().map(|(m, v)| v * per_node[m % components]).sum();
        *g += factor * work;
    }
}
