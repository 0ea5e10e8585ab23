//! The symmetric, annealed Sinkhorn iteration (Feydy 2020, algorithm 3.5).

use super::PointCloud;
use super::kernel::{Source, softmin};

/// How much of a step the unbalanced problem takes, `1 / (1 + eps / rho)`.
fn damping(eps: f64, rho: Option<f64>) -> f64 {
    rho.map_or(1.0, |rho| 1.0 / (1.0 + eps / rho))
}

/// Potentials of OT(a, b): `f` at the points of a, `g` at those of b.
#[derive(Debug)]
pub(super) struct Pair {
    pub f: Vec<f64>,
    pub g: Vec<f64>,
    next: [Vec<f64>; 2],
    means: Vec<f64>,
    source: Source,
}

/// A cloud in one step: where its potential is wanted, and as what the other sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<'a, const D: usize> {
    pub rows: &'a PointCloud<D>,
    /// The same cloud, or a coarser one.
    pub columns: &'a PointCloud<D>,
    /// Of each row the column that it is part of; empty if the clouds are the same.
    pub parents: &'a [u32],
}

impl<'a, const D: usize> Side<'a, D> {
    /// A cloud seen as it is.
    pub(super) fn whole(cloud: &'a PointCloud<D>) -> Self {
        Self { rows: cloud, columns: cloud, parents: &[] }
    }

    /// A potential at the columns: the mean of those of their rows.
    fn restricted<'b>(&self, potential: &'b [f64], means: &'b mut Vec<f64>) -> &'b [f64] {
        if self.parents.is_empty() || potential.is_empty() {
            return potential;
        }
        means.clear();
        means.resize(self.columns.len(), 0.0);
        let rows = self.parents.iter().zip(potential.iter().zip(self.rows.weights()));
        rows.for_each(|(&parent, (value, weight))| means[parent as usize] += value * weight);
        means.iter_mut().zip(self.columns.weights()).for_each(|(mean, mass)| *mean /= mass);
        means
    }
}

impl Pair {
    /// The start: one step from zero at temperature `eps`.
    pub(super) fn new<const D: usize>(sides: [Side<'_, D>; 2], eps: f64, rho: Option<f64>) -> Self {
        let (f, g) = (Vec::new(), Vec::new());
        let (next, means, source) = Default::default();
        let mut pair = Self { f, g, next, means, source };
        pair.extrapolate(sides, eps, rho);
        pair
    }

    /// Both potentials half way to what the other asks for.
    pub(super) fn iterate<const D: usize>(
        &mut self,
        sides: [Side<'_, D>; 2],
        eps: f64,
        rho: Option<f64>,
    ) {
        self.answer(sides, eps, rho);
        let Self { f, g, next: [next_f, next_g], .. } = self;
        for (old, next) in [(f, next_f), (g, next_g)] {
            old.iter_mut().zip(&*next).for_each(|(old, next)| *old = 0.5 * (*old + next));
        }
    }

    /// Both potentials all the way, without averaging.
    pub(super) fn extrapolate<const D: usize>(
        &mut self,
        sides: [Side<'_, D>; 2],
        eps: f64,
        rho: Option<f64>,
    ) {
        self.answer(sides, eps, rho);
        let [f, g] = &mut self.next;
        std::mem::swap(&mut self.f, f);
        std::mem::swap(&mut self.g, g);
    }

    /// Leaves in `next` what each potential asks of the other.
    fn answer<const D: usize>(&mut self, [a, b]: [Side<'_, D>; 2], eps: f64, rho: Option<f64>) {
        let Self { f, g, next: [next_f, next_g], means, source } = self;
        let factor = damping(eps, rho);
        softmin(source, a.rows, b.columns, b.restricted(g, means), eps, factor, next_f);
        softmin(source, b.rows, a.columns, a.restricted(f, means), eps, factor, next_g);
    }
}

/// Potential of OT(a, a), annealed through `temperatures`.
pub(super) fn self_potentials<const D: usize>(
    a: &PointCloud<D>,
    temperatures: &[f64],
    rho: Option<f64>,
) -> Vec<f64> {
    let mut source = Source::default();
    let (mut f, mut next) = (Vec::new(), Vec::new());
    softmin(&mut source, a, a, &[], temperatures[0], damping(temperatures[0], rho), &mut f);
    for &eps in temperatures {
        softmin(&mut source, a, a, &f, eps, damping(eps, rho), &mut next);
        f.iter_mut().zip(&next).for_each(|(f, next)| *f = 0.5 * (*f + next));
    }
    let last = temperatures[temperatures.len() - 1];
    softmin(&mut source, a, a, &f, last, damping(last, rho), &mut next);
    next
}
