//! L-BFGS with a line search that only goes down.

use crate::{Error, Float, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Constants of [`Lbfgs`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LbfgsConfig {
    /// Pairs of steps and gradient changes that are kept, at least 1.
    pub history: usize,
    /// Evaluations of one line search, at least 1.
    pub searches: usize,
}

impl Default for LbfgsConfig {
    fn default() -> Self {
        Self { history: 10, searches: 25 }
    }
}

/// Share of the linear decrease that a step must reach (Armijo).
const DECREASE: f64 = 1e-4;
/// Share of the initial slope that may be left (Wolfe).
const SLOPE: f64 = 0.9;
/// Numbers that are summed together.
const PART: usize = 4096;

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsStep {
    /// Value before the step.
    pub value: f64,
    /// Euclidean norm of the gradient before the step.
    pub gradient_norm: f64,
    /// Length of the step along its direction; 0 if no lower point was found, not even along
    /// the (preconditioned) gradient.
    pub length: f64,
    /// Evaluations of this step.
    pub evaluations: usize,
}

/// Limited-memory BFGS: Nocedal and Wright 2006, algorithms 7.4 and 7.5, with the bisection
/// for weak Wolfe points of Lewis and Overton 2013. A value that is not finite counts as too
/// high, so that the value never rises and the state never leaves finite numbers.
#[derive(Clone, Debug)]
pub struct Lbfgs<T> {
    config: LbfgsConfig,
    x: Vec<T>,
    gradient: Vec<T>,
    value: Option<f64>,
    /// Whether the evaluation at `x` was counted before a checkpoint.
    counted: bool,
    /// Steps and gradient changes, oldest first, and the inverse of their products.
    pairs: Vec<(Vec<T>, Vec<T>, f64)>,
    direction: Vec<T>,
    trial: Vec<T>,
    trial_gradient: Vec<T>,
}

/// Multiplies in place.
type Apply<'a, T> = &'a mut dyn FnMut(&mut [T]);

impl<T: Float> Lbfgs<T> {
    /// Starts at `x`.
    ///
    /// # Errors
    /// If a constant is out of its range.
    pub fn new(config: LbfgsConfig, x: Vec<T>) -> Result<Self> {
        for (name, value) in [("history", config.history), ("searches", config.searches)] {
            if value == 0 {
                return Err(Error::out_of_range(name, 0.0, "[1, inf)"));
            }
        }
        let zeros = || vec![T::from_f64(0.0); x.len()];
        let (gradient, direction, trial, trial_gradient) = (zeros(), zeros(), zeros(), zeros());
        let (value, counted, pairs) = (None, false, Vec::new());
        Ok(Self { config, x, gradient, value, counted, pairs, direction, trial, trial_gradient })
    }

    /// The current point.
    pub fn x(&self) -> &[T] {
        &self.x
    }

    /// Its gradient, once a step has been made.
    pub fn gradient(&self) -> &[T] {
        &self.gradient
    }

    /// Steps and gradient changes, oldest first: with [`Lbfgs::x`] all that a checkpoint needs.
    pub fn pairs(&self) -> impl Iterator<Item = (&[T], &[T])> {
        self.pairs.iter().map(|(s, y, _)| (&s[..], &y[..]))
    }

    /// Takes up a state; the value and gradient at `x` are evaluated anew, which counts if no step
    /// had been made.
    ///
    /// # Panics
    /// If a slice has another length.
    pub fn restore(&mut self, x: Vec<T>, pairs: Vec<(Vec<T>, Vec<T>)>, steps: u64) {
        let n = self.x.len();
        let fits = pairs.iter().all(|(s, y)| s.len() == n && y.len() == n);
        assert!(x.len() == n && fits, "one number per variable");
        self.x = x;
        (self.value, self.counted) = (None, steps > 0);
        self.pairs = pairs
            .into_iter()
            .map(|(s, y)| {
                let product = dot(&s, &y);
                (s, y, 1.0 / product)
            })
            .collect();
    }

    /// One step. `evaluate(x, gradient)` returns the value and writes the gradient;
    /// `precondition` multiplies by a positive approximation of the inverse Hessian, in place
    /// (`None`: a multiple of the identity, from the last pair).
    ///
    /// # Errors
    /// If the value or gradient at the start is not finite.
    pub fn step(
        &mut self,
        mut evaluate: impl FnMut(&[T], &mut [T]) -> f64,
        mut precondition: Option<Apply<'_, T>>,
    ) -> Result<LbfgsStep> {
        let mut evaluations = 0;
        let value = match self.value {
            Some(value) => value,
            None => {
                evaluations += usize::from(!self.counted);
                evaluate(&self.x, &mut self.gradient)
            }
        };
        let gradient_norm = dot(&self.gradient, &self.gradient).sqrt();
        if !(value.is_finite() && gradient_norm.is_finite()) {
            return Err(Error::Invalid(format!(
                "the value is {value} and the gradient's norm {gradient_norm} at the start of a \
                 step; both must be finite"
            )));
        }
        self.value = Some(value);
        let mut length = 0.0;
        while length == 0.0 && gradient_norm > 0.0 {
            let slope = self.find_direction(&mut precondition);
            let fresh = self.pairs.is_empty();
            if slope < 0.0 {
                // Without knowledge of the Hessian the first step has length 1 at most.
                let longest = dot(&self.direction, &self.direction).sqrt();
                let first =
                    if fresh && precondition.is_none() { 1.0 / longest.max(1.0) } else { 1.0 };
                length = self.search(value, slope, first, &mut evaluate, &mut evaluations);
            }
            if length == 0.0 {
                if fresh {
                    break;
                }
                self.pairs.clear();
            }
        }
        Ok(LbfgsStep { value, gradient_norm, length, evaluations })
    }

    /// The two-loop recursion; returns the slope along the direction.
    fn find_direction(&mut self, precondition: &mut Option<Apply<'_, T>>) -> f64 {
        let d = &mut self.direction;
        d.par_iter_mut().zip(&self.gradient).for_each(|(d, &g)| *d = -g);
        let mut alphas = Vec::with_capacity(self.pairs.len());
        for (s, y, rho) in self.pairs.iter().rev() {
            let alpha = rho * dot(s, d);
            add(d, -alpha, y);
            alphas.push(alpha);
        }
        match (precondition, self.pairs.last()) {
            (Some(apply), _) => apply(d),
            (None, Some((_, y, rho))) => {
                let scale = T::from_f64(1.0 / (rho * dot(y, y)));
                d.par_iter_mut().for_each(|d| *d = scale * *d);
            }
            (None, None) => {}
        }
        for ((s, y, rho), alpha) in self.pairs.iter().zip(alphas.iter().rev()) {
            let beta = rho * dot(y, d);
            add(d, alpha - beta, s);
        }
        dot(d, &self.gradient)
    }

    /// Bisection for a weak Wolfe point; goes there and returns its length, or that of the
    /// farthest point low enough, or 0.
    fn search(
        &mut self,
        value: f64,
        slope: f64,
        first: f64,
        evaluate: &mut impl FnMut(&[T], &mut [T]) -> f64,
        evaluations: &mut usize,
    ) -> f64 {
        let (mut low, mut high, mut length) = (0.0, f64::INFINITY, first);
        for search in 0..self.config.searches {
            let last = search + 1 == self.config.searches;
            let (x, d, t) = (&self.x, &self.direction, T::from_f64(length));
            let points = self.trial.par_iter_mut().zip(x).zip(d);
            points.for_each(|((trial, &x), &d)| *trial = x + t * d);
            let found = evaluate(&self.trial, &mut self.trial_gradient);
            *evaluations += 1;
            let along = dot(&self.trial_gradient, &self.direction);
            let enough = found <= value + DECREASE * length * slope && along.is_finite();
            if enough && (along >= SLOPE * slope || last || length == low) {
                self.accept(found);
                return length;
            }
            *(if enough { &mut low } else { &mut high }) = length;
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * length };
            // The last try is at a point known to be low enough.
            if search + 2 == self.config.searches && low > 0.0 {
                length = low;
            }
        }
        0.0
    }

    /// Moves to the trial point and keeps the pair if its curvature is positive.
    fn accept(&mut self, value: f64) {
        let n = self.x.len();
        let (mut s, mut y) = if self.pairs.len() == self.config.history {
            let (s, y, _) = self.pairs.remove(0);
            (s, y)
        } else {
            (vec![T::from_f64(0.0); n], vec![T::from_f64(0.0); n])
        };
        let (x, trial) = (&self.x, &self.trial);
        s.par_iter_mut().zip(trial).zip(x).for_each(|((s, &a), &b)| *s = a - b);
        let (old, new) = (&self.gradient, &self.trial_gradient);
        y.par_iter_mut().zip(new).zip(old).for_each(|((y, &a), &b)| *y = a - b);
        let product = dot(&s, &y);
        if product > 1e-12 * (dot(&s, &s) * dot(&y, &y)).sqrt() {
            self.pairs.push((s, y, 1.0 / product));
        }
        std::mem::swap(&mut self.x, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        self.value = Some(value);
    }
}

/// Product of two vectors, summed in f64 in fixed parts: the same bytes for any number of
/// threads.
fn dot<T: Float>(a: &[T], b: &[T]) -> f64 {
    let part = |(a, b): (&[T], &[T])| {
        let mut lanes = [0.0; 8];
        for (a, b) in a.chunks(8).zip(b.chunks(8)) {
            for ((lane, &a), &b) in lanes.iter_mut().zip(a).zip(b) {
                *lane += a.to_f64() * b.to_f64();
            }
        }
        lanes.iter().sum::<f64>()
    };
    let parts: Vec<f64> = a.par_chunks(PART).zip(b.par_chunks(PART)).map(part).collect();
    parts.iter().sum()
}

/// `a += factor b`.
fn add<T: Float>(a: &mut [T], factor: f64, b: &[T]) {
    let factor = T::from_f64(factor);
    a.par_chunks_mut(PART).zip(b.par_chunks(PART)).for_each(|(a, b)| {
        for (a, &b) in a.iter_mut().zip(b) {
            *a = *a + factor * b;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::{Lbfgs, LbfgsConfig};

    /// Rosenbrock's valley in 10 dimensions, minimum 0 at (1, ..., 1).
    #[test]
    fn valley() {
        let mut count = 0;
        let mut evaluate = |x: &[f64], g: &mut [f64]| {
            count += 1;
            g.fill(0.0);
            let mut f = 0.0;
            for i in 0..x.len() - 1 {
                let (a, b) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
                f += 100.0 * a * a + b * b;
                g[i] -= 400.0 * a * x[i] + 2.0 * b;
                g[i + 1] += 200.0 * a;
            }
            f
        };
        let mut solver = Lbfgs::new(LbfgsConfig::default(), vec![-1.2; 10]).unwrap();
        let mut last = f64::INFINITY;
        for _ in 0..150 {
            let step = solver.step(&mut evaluate, None).unwrap();
            assert!(step.value <= last);
            last = step.value;
            if step.gradient_norm < 1e-9 {
                break;
            }
        }
        assert!(solver.x().iter().all(|x| (x - 1.0).abs() < 1e-8), "{:?}", solver.x());
        assert!(count < 300, "{count} evaluations");
    }

    /// A barrier that is infinite beyond 1: the search must stay inside.
    #[test]
    fn walls_are_not_crossed() {
        let evaluate = |x: &[f64], g: &mut [f64]| {
            g[0] = -1.0 + 1e-3 / (1.0 - x[0]);
            if x[0] < 1.0 { -x[0] - 1e-3 * libm::log(1.0 - x[0]) } else { f64::NAN }
        };
        let mut solver = Lbfgs::new(LbfgsConfig::default(), vec![-30.0]).unwrap();
        for _ in 0..60 {
            solver.step(evaluate, None).unwrap();
        }
        assert!((solver.x()[0] - 0.999).abs() < 1e-6, "{:?}", solver.x());
    }
}
