//! The convex separable subproblem, by a primal-dual interior-point method.
//!
//! | symbol          | code                   | meaning                                          |
//! |-----------------|------------------------|--------------------------------------------------|
//! | epsilon         | `epsilon`              | relaxation of the complementarity conditions     |
//! | xi, eta         | `xi`, `eta`            | multipliers of `alpha <= x` and `x <= beta`      |
//! | lambda, s       | `multipliers`, `s`     | multipliers of the constraints, slacks           |
//! | mu, zeta        | `mu`, `zeta`           | multipliers of `y >= 0` and `z >= 0`             |
//! | G_ij            | `slope`                | derivative of constraint i at x_j                |
//! | D_j             | `1 / weight`           | second derivative of the Lagrangian with barrier |
//! | b_i             | `b`                    | right-hand side of constraint i                  |
//!
//! Every Newton system is reduced to the multipliers and z, m + 1 unknowns, since the
//! Hessian is diagonal (Svanberg 2007, section 5).

use super::block::{Block, TO_BOUNDARY};
use super::expansion::BLOCK;
use super::point::Point;
use super::{Artificial, Asymptotes, MovingLimits};
use crate::optimize::Bounds;
use crate::optimize::check::Evaluation;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Blocks from which on threads are worth waking.
const PARALLEL_BLOCKS: usize = 8;

/// Factor between relaxations, and residual at which one counts as solved, in epsilons.
const SHRINK: f64 = 0.1;
const SOLVED: f64 = 0.9;

/// Newton steps per relaxation and halvings per step, as published; three and none are usual.
const NEWTON_STEPS: usize = 200;
const HALVINGS: usize = 50;

/// What a subproblem is made from.
pub(in crate::optimize) struct Model<'a> {
    /// The point.
    pub(in crate::optimize) x: &'a [f64],
    /// Functions there.
    pub(in crate::optimize) values: Evaluation<'a>,
    /// Additional curvature of f_0, then of the constraints.
    pub(in crate::optimize) curvature: &'a [f64],
    pub(in crate::optimize) bounds: &'a Bounds,
    pub(in crate::optimize) history: &'a Asymptotes,
    pub(in crate::optimize) limits: &'a MovingLimits,
}

/// How a subproblem was solved, and its dual solution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solve {
    /// Newton steps done.
    pub newton_steps: usize,
    /// Largest violation of the optimality conditions, absolute.
    pub residual: f64,
    /// Whether that is within the tolerance; if not, the functions are scaled badly.
    pub converged: bool,
    /// Lagrange multipliers of the constraints.
    pub multipliers: Vec<f64>,
    /// Violations that the subproblem left, 0 to the tolerance where a constraint can be met.
    pub y: Vec<f64>,
    /// Common artificial variable, the greatest function of a min-max problem.
    pub z: f64,
}

/// Work space that is kept from step to step.
#[derive(Clone, Debug, Default)]
pub(in crate::optimize) struct Subproblem {
    blocks: Vec<Block>,
    b: Vec<f64>,
}

/// Residuals of all conditions, and the approximated constraints without `b`.
struct Residual {
    g: Vec<f64>,
    norm: f64,
    largest: f64,
}

impl Subproblem {
    /// Approximates the model's functions; allocates if the shape of the problem is new.
    pub(in crate::optimize) fn build(&mut self, model: &Model<'_>) {
        let m = model.values.g.len();
        if self.blocks.is_empty() {
            let free: Vec<usize> =
                (0..model.x.len()).filter(|&j| !model.bounds.is_fixed(j)).collect();
            self.blocks = free.chunks(BLOCK).map(|index| Block::new(index, m)).collect();
        }
        self.each(|block| block.build(model));
        self.b = self.summed(m);
        self.b.iter_mut().zip(model.values.g).for_each(|(b, g)| *b -= g);
    }

    /// Solves the approximated problem; the primal solution stays inside.
    pub(in crate::optimize) fn solve(&mut self, costs: &Artificial, tolerance: f64) -> Solve {
        self.each(Block::start);
        let mut point = Point::start(costs);
        let mut newton_steps = 0;
        let mut epsilon = 1.0;
        loop {
            let mut residual = self.residual(0.0, &point, costs, epsilon);
            for _ in 0..NEWTON_STEPS {
                if residual.largest <= SOLVED * epsilon {
                    break;
                }
                // At round-off no step makes the residual smaller.
                let Some(next) = self.newton(&point, &residual, costs, epsilon) else { break };
                (point, residual) = next;
                newton_steps += 1;
            }
            // The complementary products are off by the relaxation itself besides.
            if (1.0 + SOLVED) * epsilon <= tolerance {
                break;
            }
            epsilon *= SHRINK;
        }
        let residual = self.residual(0.0, &point, costs, 0.0).largest;
        let Point { multipliers, y, z, .. } = point;
        Solve { newton_steps, residual, converged: residual <= tolerance, multipliers, y, z }
    }

    /// Writes the solution to `x`, fixed variables at their values.
    pub(in crate::optimize) fn write_solution(&self, bounds: &Bounds, x: &mut Vec<f64>) {
        x.clear();
        x.extend_from_slice(bounds.lower());
        for block in &self.blocks {
            for (&j, &value) in block.index.iter().zip(&block.x) {
                x[j] = value;
            }
        }
    }

    /// Values of the approximations at the solution, f_0 first, and its distance (eq. 4.7).
    pub(in crate::optimize) fn approximations(&mut self, model: &Model<'_>) -> (Vec<f64>, f64) {
        self.each(|block| block.changes(model));
        let m = model.values.g.len();
        let mut values = self.summed(m + 2);
        let distance = values.pop().unwrap_or(0.0);
        let centers = std::iter::once(&model.values.f0).chain(model.values.g);
        values.iter_mut().zip(centers).for_each(|(change, center)| *change += center);
        (values, distance)
    }

    fn each(&mut self, work: impl Fn(&mut Block) + Send + Sync) {
        if self.blocks.len() < PARALLEL_BLOCKS {
            self.blocks.iter_mut().for_each(work);
        } else {
            self.blocks.par_iter_mut().for_each(work);
        }
    }

    /// Sums over the blocks, in their order.
    fn summed(&self, count: usize) -> Vec<f64> {
        let mut sums = vec![0.0; count];
        for block in &self.blocks {
            sums.iter_mut().zip(&block.sums).for_each(|(sum, part)| *sum += part);
        }
        sums
    }

    fn residual(&mut self, t: f64, point: &Point, costs: &Artificial, epsilon: f64) -> Residual {
        self.each(|block| block.residual(t, &point.multipliers, epsilon));
        let g = self.summed(costs.len());
        let own = point.residuals(costs, &self.b, &g, epsilon);
        let (mut square, mut largest) = (0.0, 0.0_f64);
        for block in &self.blocks {
            square += block.square;
            largest = largest.max(block.largest);
        }
        for residual in own {
            square += residual * residual;
            largest = largest.max(residual.abs());
        }
        Residual { g, norm: square.sqrt(), largest }
    }

    /// One Newton step, shortened until the residual falls; none if it does not.
    fn newton(
        &mut self,
        point: &Point,
        residual: &Residual,
        costs: &Artificial,
        epsilon: f64,
    ) -> Option<(Point, Residual)> {
        self.each(|block| block.newton(&point.multipliers, epsilon));
        let step = self.reduced_step(point, residual, costs, epsilon)?;
        self.each(|block| block.direction(&step.multipliers, epsilon));
        let used = TO_BOUNDARY * point.used_by(&step);
        let used = self.blocks.iter().fold(used, |used, block| used.max(block.largest));
        let mut t = 1.0 / used.max(1.0);
        for _ in 0..HALVINGS {
            let trial = point.moved(t, &step);
            let next = self.residual(t, &trial, costs, epsilon);
            if next.norm <= residual.norm {
                self.each(|block| block.commit(t));
                return Some((trial, next));
            }
            t *= 0.5;
        }
        None
    }

    /// Step of the unknowns whose number does not grow with n (Svanberg 2007, section 5):
    /// `(G D^-1 G^T + s/lambda + 1/(d + mu/y)) dlambda + a dz` and `a dlambda - (zeta/z) dz`
    /// are known; the rest follows.
    fn reduced_step(
        &self,
        point: &Point,
        residual: &Residual,
        costs: &Artificial,
        epsilon: f64,
    ) -> Option<Point> {
        let m = costs.len();
        let Point { multipliers, s, y, mu, z, zeta } = point;
        let mut matrix = self.gram(m);
        let mut right = DVector::from_vec(self.summed(m)).insert_row(m, 0.0);
        let curvature: Vec<f64> = (0..m).map(|i| costs.d[i] + mu[i] / y[i]).collect();
        let force = |i: usize| costs.c[i] + costs.d[i] * y[i] - multipliers[i] - epsilon / y[i];
        right[m] = costs.a0 - epsilon / z;
        matrix[(m, m)] = -zeta / z;
        for i in 0..m {
            let (a, lambda) = (costs.a[i], multipliers[i]);
            let violation = residual.g[i] - a * z - y[i] - self.b[i] + epsilon / lambda;
            right[i] = violation + force(i) / curvature[i] - right[i];
            right[m] -= a * lambda;
            matrix[(i, i)] += s[i] / lambda + 1.0 / curvature[i];
            (matrix[(i, m)], matrix[(m, i)]) = (a, a);
        }
        let solution = matrix.lu().solve(&right)?;
        let dlambda = &solution.as_slice()[..m];
        let dz = solution[m];
        let dy: Vec<f64> = (0..m).map(|i| (dlambda[i] - force(i)) / curvature[i]).collect();
        Some(Point {
            multipliers: dlambda.to_vec(),
            s: (0..m).map(|i| (epsilon - s[i] * dlambda[i]) / multipliers[i] - s[i]).collect(),
            mu: (0..m).map(|i| (epsilon - mu[i] * dy[i]) / y[i] - mu[i]).collect(),
            y: dy,
            z: dz,
            zeta: (epsilon - zeta * dz) / z - zeta,
        })
    }

    /// `G D^-1 G^T`, with a row and a column of zeros for z.
    fn gram(&self, m: usize) -> DMatrix<f64> {
        let mut sums = vec![0.0; m * (m + 1) / 2];
        for block in &self.blocks {
            sums.iter_mut().zip(&block.gram).for_each(|(sum, part)| *sum += part);
        }
        let at = |i: usize, k: usize| sums[i.max(k) * (i.max(k) + 1) / 2 + i.min(k)];
        DMatrix::from_fn(m + 1, m + 1, |i, k| if i.max(k) < m { at(i, k) } else { 0.0 })
    }
}
