//! Distances among many clouds: coarse while the temperature is high.

use super::anneal::{Pair, Side};
use super::{PointCloud, Sinkhorn};
use crate::{Error, Result};
use ndarray::Array2;
use rayon::prelude::*;

/// [`Sinkhorn`] for many pairs of clouds: the same annealing, on clouds seen at the
/// resolution of each temperature.
///
/// The clouds are binned ([`PointCloud::binned`]) with cells of side `cell`, and the sums at
/// temperature eps run over cells of `cell sqrt(eps) / blur`, rounded down to `cell` times a
/// power of two, so that only the last steps see all points (compare Feydy 2020, algorithm 3.6). The temperatures start at one `diameter` for all pairs, so that the
/// part of a cloud with itself is computed once.
#[derive(Clone, Debug)]
pub struct CoarseSinkhorn {
    sinkhorn: Sinkhorn,
    cell: f64,
    /// Temperatures, each with the level (power of two of the cell) that it is solved on.
    schedule: Vec<(f64, usize)>,
}

/// A cloud made ready for comparison by [`CoarseSinkhorn::prepare`].
#[derive(Clone, Debug)]
pub struct PreparedCloud<const D: usize> {
    levels: Levels<D>,
    /// Potential of OT(a, a) on the finest level.
    own: Vec<f64>,
}

/// A cloud at several resolutions, from fine to coarse.
#[derive(Clone, Debug)]
struct Levels<const D: usize> {
    clouds: Vec<PointCloud<D>>,
    /// For each level, of each point of the finest the point that it is part of; empty for the finest.
    parents: Vec<Vec<u32>>,
}

impl CoarseSinkhorn {
    /// Cells of side `cell` (length) at the last temperature: `blur` for distances within
    /// 1 % of [`Sinkhorn::distance`] and `blur / 2` within 0.3 %, for clouds much wider than
    /// the blur; twice the blur costs a quarter and is 2 % off.
    ///
    /// # Errors
    /// If a setting is outside its range, `sinkhorn.diameter` is `None`, or `cell` is not positive.
    pub fn new(sinkhorn: Sinkhorn, cell: f64) -> Result<Self> {
        sinkhorn.check()?;
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(Error::out_of_range("cell", cell, "(0, inf)"));
        }
        let Some(diameter) = sinkhorn.diameter else {
            return Err(Error::Invalid(
                "distances among many clouds need one diameter for all of them".into(),
            ));
        };
        let level = |eps: f64| libm::log2(eps.sqrt() / sinkhorn.blur).floor().max(0.0) as usize;
        let schedule = sinkhorn.temperatures(diameter).into_iter().map(|e| (e, level(e))).collect();
        Ok(Self { sinkhorn, cell, schedule })
    }

    /// Bins a cloud at all resolutions and solves its part with itself.
    ///
    /// # Errors
    /// None for a valid `self`; those of [`PointCloud::binned`].
    pub fn prepare<const D: usize>(&self, cloud: &PointCloud<D>) -> Result<PreparedCloud<D>> {
        let top = self.schedule.iter().map(|&(_, level)| level).max().unwrap_or(0);
        let mut levels = Levels { clouds: vec![cloud.binned(self.cell)?], parents: vec![vec![]] };
        for level in 1..=top {
            let (coarse, parents) =
                levels.clouds[0].coarsened(self.cell * libm::exp2(level as f64));
            levels.clouds.push(coarse);
            levels.parents.push(parents);
        }
        let own = self.anneal(&levels, &levels).f;
        Ok(PreparedCloud { levels, own })
    }

    /// The divergence S (length^2 mass), as [`Sinkhorn::divergence`].
    pub fn divergence<const D: usize>(&self, a: &PreparedCloud<D>, b: &PreparedCloud<D>) -> f64 {
        let pair = self.anneal(&a.levels, &b.levels);
        let cost = |cloud: &PreparedCloud<D>, pair: &[f64]| {
            self.sinkhorn.cost(&cloud.levels.clouds[0], &cloud.own, pair)
        };
        cost(a, &pair.f) + cost(b, &pair.g)
    }

    /// The distances `sqrt(|S|)` (length sqrt(mass)) among all `clouds`, shape `[n, n]`,
    /// symmetric, zero on the diagonal; pairs run in parallel.
    ///
    /// # Errors
    /// As [`CoarseSinkhorn::prepare`].
    pub fn matrix<const D: usize>(&self, clouds: &[PointCloud<D>]) -> Result<Array2<f64>> {
        let n = clouds.len();
        let ready: Vec<_> = clouds.par_iter().map(|c| self.prepare(c)).collect::<Result<_>>()?;
        let row = |i: usize| -> Vec<f64> {
            let distance = |j| self.divergence(&ready[i], &ready[j]).abs().sqrt();
            (i + 1..n).into_par_iter().map(distance).collect()
        };
        let rows: Vec<Vec<f64>> = (0..n).into_par_iter().map(row).collect();
        let value = |(i, j): (usize, usize)| match i.cmp(&j) {
            std::cmp::Ordering::Less => rows[i][j - i - 1],
            std::cmp::Ordering::Equal => 0.0,
            std::cmp::Ordering::Greater => rows[j][i - j - 1],
        };
        Ok(Array2::from_shape_fn((n, n), value))
    }

    fn anneal<const D: usize>(&self, a: &Levels<D>, b: &Levels<D>) -> Pair {
        let rho = self.sinkhorn.rho();
        let sides = |level| [a.side(level), b.side(level)];
        let (start, level) = self.schedule[0];
        let mut pair = Pair::new(sides(level), start, rho);
        for &(eps, level) in &self.schedule {
            pair.iterate(sides(level), eps, rho);
        }
        pair.extrapolate(sides(0), self.sinkhorn.eps(), rho);
        pair
    }
}

impl<const D: usize> Levels<D> {
    /// The finest level, as seen at level `level`.
    fn side(&self, level: usize) -> Side<'_, D> {
        let [rows, columns] = [0, level].map(|level| &self.clouds[level]);
        Side { rows, columns, parents: &self.parents[level] }
    }
}
