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

    /// Objective of a case.
    pub(super) fn value(
        &mut self,
        problem: &Problem,
        config: &Config,
        case: usize,
        rho: &[f64],
    ) -> f64 {
        match config.objective {
            Objective::Compliance => self.compliance(problem, case, rho),
            Objective::Displacement => self.output(problem, case),
            Objective::Stress => {
                stress::Norm::new(problem, config.stress_exponent, &self.u[case], rho).value
            }
        }
    }

    /// As [`Analysis::value`]; adds the derivatives by the physical densities to `gradient`,
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
        let tolerance = config.solver_tolerance.unwrap_or(ADJOINT_TOLERANCE);
        match config.objective {
            Objective::Compliance => {
                let value = self.compliance(problem, case, rho);
                for ((g, energy), &x) in gradient.iter_mut().zip(&self.energies).zip(rho) {
                    *g -= weight * law.derivative(x) * energy;
                }
                add_weight_derivative(problem, 2.0 * weight, &self.u[case], gradient);
                Ok(value)
            }
            Objective::Displacement => {
                let output = problem.output.as_deref().unwrap_or_default();
                let value = self.output(problem, case);
                self.adjoint(problem, case, output, tolerance)?;
                self.add_adjoint(problem, (case, weight), rho, law, gradient);
                Ok(value)
            }
            Objective::Stress => {
                // `product` is free after the solves.
                let mut right = std::mem::take(&mut self.product);
                right.fill(0.0);
                let norm = stress::Norm::new(problem, config.stress_exponent, &self.u[case], rho);
                norm.add_derivatives(problem, rho, weight, &mut right, gradient);
                let solved = self.adjoint(problem, case, &right, tolerance);
                self.product = right;
                solved?;
                self.add_adjoint(problem, (case, weight), rho, law, gradient);
                Ok(norm.value)
            }
        }
    }

    fn output(&self, problem: &Problem, case: usize) -> f64 {
        let output = problem.output.as_deref().unwrap_or_default();
        output.iter().zip(&self.u[case]).map(|(l, u)| l * u).sum()
    }

    /// `c = 2 f.u - u.K u`: `f.u`, less the work of prescribed displacements, as in
    /// Niu, Xu & Cheng 2011; its derivative `2 df.u - u.dK u` needs no adjoint. Leaves
    /// `u_e . K_e u_e` at stiffness 1 in `energies`.
    pub(super) fn compliance(&mut self, problem: &Problem, case: usize, rho: &[f64]) -> f64 {
        let u = &self.u[case];
        problem.system.energies(u, u, &mut self.energies);
        let parts = self.stiffness.iter().zip(&self.energies).map(|(e, energy)| e * energy);
        let elastic: f64 = parts.sum();
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
        2.0 * work - elastic - springs
    }

    /// Solves `K m = l` for the adjoint of a case.
    fn adjoint(&mut self, problem: &Problem, case: usize, l: &[f64], tolerance: f64) -> Result<()> {
        let m = &mut self.adjoint[case];
        let report = self.solver.solve(&problem.system, l, m, tolerance)?;
        self.note(report);
        Ok(())
    }

    /// Adds `weight d(l . u)/d rho` for `l` constant: with `K m = l` it is `-m . dK u + m . df`.
    fn add_adjoint(
        &mut self,
        problem: &Problem,
        (case, weight): (usize, f64),
        rho: &[f64],
        law: Law,
        gradient: &mut [f64],
    ) {
        let m = &self.adjoint[case];
        problem.system.energies(m, &self.u[case], &mut self.energies);
        for ((g, energy), &x) in gradient.iter_mut().zip(&self.energies).zip(rho) {
            *g -= weight * law.derivative(x) * energy;
        }
        add_weight_derivative(problem, weight, m, gradient);
    }

    /// Compliance of densities 0 and 1 with the void that designs are compared with.
    pub(super) fn black_and_white(&mut self, problem: &Problem, black: &[f64]) -> Result<f64> {
        self.solve(problem, black, Law::linear(VOID), BLACK_TOLERANCE)?;
        Ok(self.compliances(problem, black))
    }

    /// Weighted sum of the cases' compliances.
    pub(super) fn compliances(&mut self, problem: &Problem, rho: &[f64]) -> f64 {
        let cases = problem.cases.iter().enumerate();
        cases.map(|(case, (weight, _))| weight * self.compliance(problem, case, rho)).sum()
    }

    /// What solid is worth at each element: minus the derivative of the compliances by the
    /// density where an element is solid, and as much less as it is not:
    /// `E_e u_e . K_e u_e - 2 u . db/d rho_e`, b the weight.
    pub(super) fn worth(&mut self, problem: &Problem, worth: &mut [f64]) {
        worth.fill(0.0);
        for (case, (weight, _)) in problem.cases.iter().enumerate() {
            let u = &self.u[case];
            problem.system.energies(u, u, &mut self.energies);
            let parts = self.stiffness.iter().zip(&self.energies);
            worth.iter_mut().zip(parts).for_each(|(w, (e, energy))| *w += weight * (e * energy));
            add_weight_derivative(problem, -2.0 * weight, u, worth);
        }
    }
}

/// Adds `factor v . db/d rho_e` for the weight b.
pub(super) fn add_weight_derivative(
    problem: &Problem,
    factor: f64,
    v: &[f64],
    gradient: &mut [f64],
) {
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
