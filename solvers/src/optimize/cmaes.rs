//! Covariance matrix adaptation (CMA-ES), for few unknowns and no gradient.
//!
//! Hansen 2016, "The CMA evolution strategy: a tutorial", arXiv:1604.00772, figure 6 and
//! table 1, without negative weights.
//!
//! | symbol  | code      | meaning                                  |
//! |---------|-----------|------------------------------------------|
//! | m       | `mean`    | middle of the search                     |
//! | sigma   | `sigma`   | its overall width                        |
//! | C       | `c`       | its shape                                |
//! | lambda  | `points`  | points of a generation                   |

use crate::random::{Stream, normal, stream};
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// A search in progress: [`Cmaes::ask`] for points, [`Cmaes::tell`] their values.
pub struct Cmaes {
    mean: DVector<f64>,
    sigma: f64,
    c: DMatrix<f64>,
    path_c: DVector<f64>,
    path_sigma: DVector<f64>,
    /// Axes and lengths of C as of the last generation.
    axes: DMatrix<f64>,
    lengths: DVector<f64>,
    /// Least deviation along each coordinate.
    least: DVector<f64>,
    points: usize,
    asked: Vec<DVector<f64>>,
    random: Stream,
    generation: u32,
    best: Option<(Vec<f64>, f64)>,
    rates: Rates,
}

/// Weights and learning rates, table 1.
struct Rates {
    weights: Vec<f64>,
    mu_eff: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// Expected length of a standard normal vector.
    chi: f64,
}

impl Rates {
    fn new(n: f64, points: usize) -> Self {
        let raw: Vec<f64> = (1..=points / 2)
            .map(|i| libm::log(0.5 * (points as f64 + 1.0)) - libm::log(i as f64))
            .collect();
        let total: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|w| w / total).collect();
        let mu_eff = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + mu_eff);
        let c_mu = 2.0 * (0.25 + mu_eff + 1.0 / mu_eff - 2.0) / ((n + 2.0).powi(2) + mu_eff);
        Self {
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: c_mu.min(1.0 - c_1),
            chi: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
            weights,
        }
    }
}

impl Cmaes {
    /// A search from `start` with standard deviation `sigma` along each axis; generations of
    /// 4 + floor(3 ln n) points, as the tutorial's default.
    ///
    /// # Errors
    /// If there is no unknown, or `sigma` is not positive and finite.
    pub fn new(start: &[f64], sigma: f64, seed: u64) -> Result<Self> {
        if start.is_empty() {
            return Err(Error::out_of_range("unknowns", 0.0, "[1, inf)"));
        }
        if !(sigma > 0.0 && sigma.is_finite()) {
            return Err(Error::out_of_range("sigma", sigma, "(0, inf)"));
        }
        let n = start.len();
        let points = 4 + (3.0 * libm::log(n as f64)) as usize;
        Ok(Self {
            mean: DVector::from_column_slice(start),
            sigma,
            c: DMatrix::identity(n, n),
            path_c: DVector::zeros(n),
            path_sigma: DVector::zeros(n),
            axes: DMatrix::identity(n, n),
            lengths: DVector::from_element(n, 1.0),
            least: DVector::zeros(n),
            points,
            asked: Vec::with_capacity(points),
            random: stream(seed, "cmaes", 0),
            generation: 0,
            best: None,
            rates: Rates::new(n as f64, points),
        })
    }

    /// The same with `points` points a generation, at least 4: more look further.
    #[must_use]
    pub fn with_points(mut self, points: usize) -> Self {
        self.points = points.max(4);
        self.rates = Rates::new(self.mean.len() as f64, self.points);
        self
    }

    /// The same with a deviation of at least `least` along each coordinate: a coordinate that
    /// is rounded would rest between two steps else. After Hansen 2011, "A CMA-ES for
    /// mixed-integer nonlinear optimization", section 4.
    ///
    /// # Errors
    /// If there is not one value per coordinate.
    pub fn with_least_deviations(mut self, least: &[f64]) -> Result<Self> {
        if least.len() != self.mean.len() {
            return Err(Error::Shape {
                name: "least deviations".into(),
                actual: vec![least.len()],
                expected: vec![self.mean.len()],
            });
        }
        self.least = DVector::from_column_slice(least);
        Ok(self)
    }

    /// The points of the next generation.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        let n = self.mean.len();
        let lacks: Vec<f64> = (self.deviations().iter().zip(&self.least))
            .map(|(is, least)| (least * least - is * is).max(0.0).sqrt())
            .collect();
        self.asked = (0..self.points)
            .map(|_| {
                let z = DVector::from_fn(n, |_, _| normal(&mut self.random));
                let mut x = &self.mean + self.sigma * (&self.axes * z.component_mul(&self.lengths));
                for (x, &lack) in x.iter_mut().zip(&lacks).filter(|(_, lack)| **lack > 0.0) {
                    *x += lack * normal(&mut self.random);
                }
                x
            })
            .collect();
        self.asked.iter().map(|x| x.as_slice().to_vec()).collect()
    }

    /// The values at the points asked for, in their order; less is better, NaN is worst.
    ///
    /// # Errors
    /// If there is not one value per point.
    pub fn tell(&mut self, values: &[f64]) -> Result<()> {
        if values.len() != self.asked.len() || values.is_empty() {
            return Err(Error::Shape {
                name: "values".into(),
                actual: vec![values.len()],
                expected: vec![self.asked.len()],
            });
        }
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let first = order[0];
        if self.best.as_ref().is_none_or(|(_, value)| values[first] < *value) {
            self.best = Some((self.asked[first].as_slice().to_vec(), values[first]));
        }
        let n = self.mean.len() as f64;
        let r = &self.rates;
        let steps: Vec<DVector<f64>> = order[..r.weights.len()]
            .iter()
            .map(|&i| (&self.asked[i] - &self.mean) / self.sigma)
            .collect();
        let mut step = DVector::zeros(self.mean.len());
        steps.iter().zip(&r.weights).for_each(|(y, w)| step += *w * y);
        self.mean += self.sigma * &step;
        self.generation += 1;
        // C^(-1/2) y, by the axes of C.
        let white = &self.axes * (self.axes.transpose() * &step).component_div(&self.lengths);
        self.path_sigma = (1.0 - r.c_sigma) * &self.path_sigma
            + (r.c_sigma * (2.0 - r.c_sigma) * r.mu_eff).sqrt() * white;
        let length = self.path_sigma.norm();
        let passed = 1.0 - (1.0 - r.c_sigma).powi(2 * self.generation as i32);
        // A path that is long because sigma is too small must not stretch C.
        let slow = length / passed.sqrt() < (1.4 + 2.0 / (n + 1.0)) * r.chi;
        let h = if slow { 1.0 } else { 0.0 };
        self.path_c =
            (1.0 - r.c_c) * &self.path_c + h * (r.c_c * (2.0 - r.c_c) * r.mu_eff).sqrt() * &step;
        let lost = (1.0 - h) * r.c_c * (2.0 - r.c_c);
        self.c *= 1.0 - r.c_1 - r.c_mu + r.c_1 * lost;
        self.c.ger(r.c_1, &self.path_c, &self.path_c, 1.0);
        for (y, w) in steps.iter().zip(&r.weights) {
            self.c.ger(r.c_mu * w, y, y, 1.0);
        }
        self.sigma *= libm::exp(r.c_sigma / r.d_sigma * (length / r.chi - 1.0));
        let eigen = SymmetricEigen::new(self.c.clone());
        self.lengths = eigen.eigenvalues.map(|v| v.max(1e-20).sqrt());
        self.axes = eigen.eigenvectors;
        Ok(())
    }

    /// The best point so far and its value.
    pub fn best(&self) -> Option<(&[f64], f64)> {
        self.best.as_ref().map(|(point, value)| (point.as_slice(), *value))
    }

    /// The middle of the search.
    pub fn mean(&self) -> &[f64] {
        self.mean.as_slice()
    }

    /// Standard deviation of the next generation along each coordinate: sigma sqrt(C_ii).
    pub fn deviations(&self) -> Vec<f64> {
        self.c.diagonal().iter().map(|v| self.sigma * v.sqrt()).collect()
    }

    /// The present width of the search.
    pub fn sigma(&self) -> f64 {
        self.sigma
    }
}
