//! Optimal transport between weighted point clouds: the unbalanced, debiased Sinkhorn
//! divergence, with the conventions of the geomloss library.
//!
//! | symbol | code | meaning | unit |
//! |---|---|---|---|
//! | a, b | `weights` | masses of the two clouds | mass |
//! | C(x, y) | | ground cost `|x - y|^2 / 2` | length^2 |
//! | sqrt(eps) | `blur` | resolution of the transport plan | length |
//! | sqrt(rho) | `reach` | how far mass travels before it is rather made and unmade | length |
//! | f, g | potentials | dual variables at the points of a and b | length^2 |
//!
//! `OT(a, b) = min over plans of <plan, C> + eps KL(plan, a b) + rho KL(row sums, a) + rho
//! KL(column sums, b)`, and the divergence is `S(a, b) = OT(a, b) - OT(a, a)/2 - OT(b, b)/2
//! + eps (mass(a) - mass(b))^2 / 2`: zero for equal clouds and positive otherwise.
//!
//! Sources: Feydy et al. 2019, "Interpolating between optimal transport and MMD using
//! Sinkhorn divergences"; Sejourne et al. 2019, "Sinkhorn divergences for unbalanced
//! optimal transport", proposition 12 (the cost from the potentials); Feydy 2020, thesis,
//! algorithm 3.5 (the symmetric, annealed iteration).

mod anneal;
mod cloud;
mod kernel;
mod matrix;
#[cfg(test)]
mod tests;

pub use cloud::PointCloud;
pub use matrix::{CoarseSinkhorn, PreparedCloud};

use crate::{Error, Result};
use anneal::{Pair, Side, self_potentials};

/// The Sinkhorn divergence; every number as in geomloss's `SamplesLoss("sinkhorn", p=2)`.
///
/// ```
/// use solvers::transport::{PointCloud, Sinkhorn};
/// let sinkhorn = Sinkhorn { reach: None, ..Sinkhorn::default() };
/// let a = PointCloud::new(&[[0.0, 0.0]], &[1.0])?;
/// let b = PointCloud::new(&[[3.0, 4.0]], &[1.0])?;
/// assert!((sinkhorn.divergence(&a, &b)? - 12.5).abs() < 1e-5); // |x - y|^2 / 2
/// # Ok::<(), solvers::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sinkhorn {
    /// Resolution sqrt(eps) of the plan (length), positive.
    pub blur: f64,
    /// Scale sqrt(rho) of the transport distance (length), positive; `None` keeps all mass.
    pub reach: Option<f64>,
    /// Ratio of successive blurs of the annealing, in (0, 1).
    pub scaling: f64,
    /// First blur (length), at least `blur`; `None` takes the diagonal of the box around both clouds.
    pub diameter: Option<f64>,
}

impl Default for Sinkhorn {
    /// Blur 1, reach 20, scaling 0.5: the settings of curvatubes for curvature diagrams.
    fn default() -> Self {
        Self { blur: 1.0, reach: Some(20.0), scaling: 0.5, diameter: None }
    }
}

impl Sinkhorn {
    /// The divergence S (length^2 mass), 0 for equal clouds; rounding may leave a negative
    /// number of 1e-6 of its terms.
    ///
    /// Sums of exponentials leave out terms below 2^-40 of their largest; the exponentials
    /// themselves are right to 1e-7. Cost at worst `O(n m log(diameter / blur))` in time,
    /// far less where the clouds are wide; `O(n + m)` in memory. Rows run in parallel; the
    /// bytes do not depend on the number of threads or the order of the points.
    ///
    /// # Errors
    /// If a setting is outside its range.
    pub fn divergence<const D: usize>(&self, a: &PointCloud<D>, b: &PointCloud<D>) -> Result<f64> {
        self.check()?;
        let temperatures = self.temperatures(self.diameter.unwrap_or_else(|| a.diameter(b)));
        let rho = self.rho();
        let alone =
            [self_potentials(a, &temperatures, rho), self_potentials(b, &temperatures, rho)];
        let sides = [Side::whole(a), Side::whole(b)];
        let mut pair = Pair::new(sides, temperatures[0], rho);
        for &eps in &temperatures {
            pair.iterate(sides, eps, rho);
        }
        pair.extrapolate(sides, self.eps(), rho);
        Ok(self.cost(a, &alone[0], &pair.f) + self.cost(b, &alone[1], &pair.g))
    }

    /// The distance `sqrt(|S|)` (length sqrt(mass)); cost and errors as [`Sinkhorn::divergence`].
    ///
    /// # Errors
    /// As [`Sinkhorn::divergence`].
    pub fn distance<const D: usize>(&self, a: &PointCloud<D>, b: &PointCloud<D>) -> Result<f64> {
        Ok(self.divergence(a, b)?.abs().sqrt())
    }

    /// Part of the divergence of one cloud, from its own potential and that of the pair.
    fn cost<const D: usize>(&self, cloud: &PointCloud<D>, own: &[f64], pair: &[f64]) -> f64 {
        let terms = cloud.weights().iter().zip(own.iter().zip(pair));
        match self.rho() {
            None => terms.map(|(w, (own, pair))| w * (pair - own)).sum(),
            // exp(-own/rho) - exp(-pair/rho), without cancellation where they are near.
            Some(rho) => {
                let part =
                    |own: f64, pair: f64| -libm::exp(-own / rho) * libm::expm1((own - pair) / rho);
                let sum: f64 = terms.map(|(w, (&own, &pair))| w * part(own, pair)).sum();
                (rho + 0.5 * self.eps()) * sum
            }
        }
    }

    fn eps(&self) -> f64 {
        self.blur * self.blur
    }

    fn rho(&self) -> Option<f64> {
        self.reach.map(|reach| reach * reach)
    }

    /// The annealing: `diameter^2` twice, divided by `scaling^-2` at each step down to
    /// `blur^2`, which comes last (the first entry twice as in geomloss).
    fn temperatures(&self, diameter: f64) -> Vec<f64> {
        let diameter = diameter.max(self.blur);
        let ratio = libm::log(diameter / self.blur) / -libm::log(self.scaling);
        // Diameters of a whole number of steps must not gain one by rounding.
        let steps = (ratio - 1e-12).ceil().max(0.0) as i32;
        let cooled = |k| diameter * diameter * libm::pow(self.scaling, 2.0 * f64::from(k));
        std::iter::once(diameter * diameter)
            .chain((0..steps).map(cooled))
            .chain([self.eps()])
            .collect()
    }

    fn check(&self) -> Result<()> {
        let positive = |name: &str, value: f64| match value > 0.0 && value.is_finite() {
            true => Ok(()),
            false => Err(Error::out_of_range(name, value, "(0, inf)")),
        };
        positive("blur", self.blur)?;
        positive("reach", self.reach.unwrap_or(1.0))?;
        if !(self.scaling > 0.0 && self.scaling < 1.0) {
            return Err(Error::out_of_range("scaling", self.scaling, "(0, 1)"));
        }
        match self.diameter {
            Some(d) if !(d >= self.blur && d.is_finite()) => {
                Err(Error::out_of_range("diameter", d, "[blur, inf)"))
            }
            _ => Ok(()),
        }
    }
}
