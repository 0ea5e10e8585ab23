//! From descriptors to a class, its parameters and how sure that is.
//!
//! Every class is two groups of samples, as made and with ink and paper exchanged. The
//! axes are those of linear discriminant analysis: they make the mean scatter inside the
//! groups the identity and that between them diagonal (Fisher 1936, Rao 1948), so that the
//! first tell groups apart and the rest tell how far a picture lies from all of them.

use crate::{Error, Result};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use solvers::texture::invert;

/// Axes on which groups are told apart; the between-group scatter beyond is below the noise.
const AXES: usize = 28;

/// Part of the pooled scatter in each group's own: few samples make a poor matrix.
const SHRINK: f64 = 0.5;

/// Added to the diagonal of the scatter inside the groups, relative to it and absolute
/// (descriptors are kept to four digits).
const FLOOR: (f64, f64) = (1e-3, 1e-6);

/// Divides log likelihoods before they become probabilities, because statistics of one
/// picture are not independent: set so that the confidence of held-out samples is their accuracy.
const TEMPERATURE: f64 = 3.0;

/// Parts of the samples that are left out in turn.
const FOLDS: usize = 6;

/// A descriptor of a known pattern.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Index of its class.
    pub class: usize,
    /// Shares of the class's ranges.
    pub point: Vec<f64>,
    /// Statistics as [`solvers::texture::Descriptor`] has them.
    pub values: Vec<f64>,
}

/// One answer of several.
#[derive(Clone, Debug)]
pub struct Ranked {
    /// Index of the class.
    pub class: usize,
    /// Probability among the classes, if the picture is of one of them.
    pub probability: f64,
    /// Squared distance from the class, in units of its scatter.
    pub distance: f64,
    /// Whether ink and paper are exchanged.
    pub inverted: bool,
    /// Shares of the class's ranges that fit best.
    pub point: Vec<f64>,
}

struct Group {
    class: usize,
    inverted: bool,
    /// On all axes.
    mean: DVector<f64>,
    /// Inverse of the scatter on the first [`AXES`] axes, and half of ln of its determinant.
    precision: DMatrix<f64>,
    half_log_det: f64,
}

/// Ridge regression of the points of a class on its axes.
struct Regression {
    weights: DMatrix<f64>,
}

/// What the samples say.
pub struct Classifier {
    center: DVector<f64>,
    axes: DMatrix<f64>,
    groups: Vec<Group>,
    regressions: Vec<Regression>,
}

impl Classifier {
    /// Learns from samples of classes 0 to `classes - 1`.
    ///
    /// # Errors
    /// [`Error::Config`] if a class has fewer than two samples, or lengths differ.
    pub fn new(samples: &[Sample], classes: usize) -> Result<Self> {
        let length = samples.first().map_or(0, |s| s.values.len());
        if samples.iter().any(|s| s.values.len() != length || s.class >= classes) {
            return Err(Error::config("calibration", "samples of several lengths"));
        }
        for class in 0..classes {
            let count = samples.iter().filter(|s| s.class == class).count();
            if count < 2 {
                let reason = format!("class {class} has {count} samples, at least 2 are wanted");
                return Err(Error::config("calibration", reason));
            }
        }
        let vectors: Vec<Vec<DVector<f64>>> = (0..2 * classes)
            .map(|group| {
                let of = samples.iter().filter(|s| s.class == group / 2);
                let turn = |s: &Sample| match group % 2 {
                    0 => DVector::from_column_slice(&s.values),
                    _ => DVector::from_vec(invert(&s.values)),
                };
                of.map(turn).collect()
            })
            .collect();
        let means: Vec<DVector<f64>> = vectors.iter().map(|v| mean(v)).collect();
        let center = mean(&means);
        let mut within = DMatrix::zeros(length, length);
        for (group, m) in vectors.iter().zip(&means) {
            within += scatter(group, m) / (2 * classes) as f64;
        }
        let between = scatter(&means, &center);
        let axes = discriminants(within, &between);
        let project = |v: &DVector<f64>| &axes * (v - &center);
        let first = AXES.min(length);
        let mut groups = Vec::new();
        for (index, group) in vectors.iter().enumerate() {
            let z: Vec<DVector<f64>> = group.iter().map(project).collect();
            let m = mean(&z);
            let own = scatter(&z, &m).view((0, 0), (first, first)).into_owned();
            let mixed = own * (1.0 - SHRINK) + DMatrix::identity(first, first) * SHRINK;
            let cholesky = mixed
                .cholesky()
                .ok_or_else(|| Error::config("calibration", "a scatter is not positive"))?;
            let half_log_det = cholesky.l_dirty().diagonal().iter().map(|d| libm::log(*d)).sum();
            let precision = cholesky.inverse();
            groups.push(Group {
                class: index / 2,
                inverted: index % 2 == 1,
                mean: m,
                precision,
                half_log_det,
            });
        }
        let mut learnt = Self { center, axes, groups, regressions: Vec::new() };
        for class in 0..classes {
            let own: Vec<&Sample> = samples.iter().filter(|s| s.class == class).collect();
            let regression = Regression::new(&own, |v| learnt.project(v));
            learnt.regressions.push(regression);
        }
        Ok(learnt)
    }

    /// Every class, the likeliest first.
    pub fn rank(&self, values: &[f64]) -> Vec<Ranked> {
        let z = self.project(values);
        let first = AXES.min(z.len());
        let scores: Vec<(f64, f64)> = self
            .groups
            .iter()
            .map(|group| {
                let d = (&z - &group.mean).rows(0, first).into_owned();
                let square = (&group.precision * &d).dot(&d);
                let rest = (&z - &group.mean).rows(first, z.len() - first).norm_squared();
                ((-0.5 * square - group.half_log_det) / TEMPERATURE, square + rest)
            })
            .collect();
        let best = scores.iter().fold(f64::MIN, |a, s| a.max(s.0));
        let weights: Vec<f64> = scores.iter().map(|s| libm::exp(s.0 - best)).collect();
        let total: f64 = weights.iter().sum();
        let mut ranked: Vec<Ranked> = (0..self.regressions.len())
            .map(|class| {
                let of = || (0..self.groups.len()).filter(|&g| self.groups[g].class == class);
                let probability = of().map(|g| weights[g]).sum::<f64>() / total;
                let group = of().max_by(|&a, &b| scores[a].0.total_cmp(&scores[b].0)).unwrap_or(0);
                let inverted = self.groups[group].inverted;
                let point = self.estimate(class, inverted, values);
                Ranked { class, probability, distance: scores[group].1, inverted, point }
            })
            .collect();
        ranked.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        ranked
    }

    /// Shares of the ranges of `class` by regression, within the ranges.
    fn estimate(&self, class: usize, inverted: bool, values: &[f64]) -> Vec<f64> {
        let fit = self.summary(class, inverted, values);
        fit.into_iter().map(|v| v.clamp(0.0, 1.0)).collect()
    }

    /// Shares of the ranges of `class` by regression, as it gives them.
    pub fn summary(&self, class: usize, inverted: bool, values: &[f64]) -> Vec<f64> {
        let values = if inverted { invert(values) } else { values.to_vec() };
        self.regressions[class].at(&self.project(&values))
    }

    /// Standard error of [`Classifier::summary`] for a picture that it has not learnt from:
    /// regressions without each sixth of `samples` in turn, which it predicts. Samples of one
    /// pattern, which have one point, stay together.
    pub fn deviations(&self, class: usize, samples: &[Sample]) -> Vec<f64> {
        let own: Vec<&Sample> = samples.iter().filter(|s| s.class == class).collect();
        let mut fold = 0;
        let folds: Vec<usize> = (0..own.len())
            .map(|n| {
                fold += usize::from(n > 0 && own[n].point != own[n - 1].point);
                fold % FOLDS
            })
            .collect();
        let mut squares = vec![0.0; own[0].point.len()];
        for left_out in 0..FOLDS {
            let part = |out: bool| -> Vec<&Sample> {
                let pairs = own.iter().zip(&folds);
                pairs.filter(|(_, f)| (**f == left_out) == out).map(|(s, _)| *s).collect()
            };
            let (rest, out) = (part(false), part(true));
            if rest.is_empty() {
                continue;
            }
            let regression = Regression::new(&rest, |v| self.project(v));
            for sample in out {
                let fit = regression.at(&self.project(&sample.values));
                for ((sum, a), b) in squares.iter_mut().zip(&fit).zip(&sample.point) {
                    *sum += (a - b).powi(2) / own.len() as f64;
                }
            }
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    fn project(&self, values: &[f64]) -> DVector<f64> {
        &self.axes * (DVector::from_column_slice(values) - &self.center)
    }
}

impl Regression {
    fn new(of: &[&Sample], project: impl Fn(&[f64]) -> DVector<f64>) -> Self {
        let rows: Vec<DVector<f64>> = of.iter().map(|s| extended(&project(&s.values))).collect();
        let (size, outputs) = (rows[0].len(), of[0].point.len());
        let mut normal = DMatrix::identity(size, size) * (0.1 * rows.len() as f64);
        // The mean is not held back.
        normal[(size - 1, size - 1)] = 1e-6;
        let mut right = DMatrix::zeros(size, outputs);
        for (row, sample) in rows.iter().zip(of) {
            normal += row * row.transpose();
            right += row * DVector::from_column_slice(&sample.point).transpose();
        }
        let weights =
            normal.cholesky().map_or_else(|| DMatrix::zeros(size, outputs), |c| c.solve(&right));
        Self { weights }
    }

    fn at(&self, z: &DVector<f64>) -> Vec<f64> {
        (self.weights.transpose() * extended(z)).as_slice().to_vec()
    }
}

/// The axes and a constant.
fn extended(z: &DVector<f64>) -> DVector<f64> {
    z.clone().push(1.0)
}

fn mean(vectors: &[DVector<f64>]) -> DVector<f64> {
    let mut sum = DVector::zeros(vectors[0].len());
    vectors.iter().for_each(|v| sum += v);
    sum / vectors.len() as f64
}

fn scatter(vectors: &[DVector<f64>], mean: &DVector<f64>) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(mean.len(), mean.len());
    for v in vectors {
        let d = v - mean;
        sum.ger(1.0 / vectors.len() as f64, &d, &d, 1.0);
    }
    sum
}

/// Rows that make `within` the identity and `between` diagonal, its greatest value first.
fn discriminants(mut within: DMatrix<f64>, between: &DMatrix<f64>) -> DMatrix<f64> {
    let n = within.nrows();
    for d in 0..n {
        within[(d, d)] += FLOOR.1 + FLOOR.0 * within[(d, d)];
    }
    let inside = SymmetricEigen::new(within);
    let scale = inside.eigenvalues.map(|v| 1.0 / v.max(1e-12).sqrt());
    let whiten = DMatrix::from_diagonal(&scale) * inside.eigenvectors.transpose();
    let between = SymmetricEigen::new(&whiten * between * whiten.transpose());
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| between.eigenvalues[b].total_cmp(&between.eigenvalues[a]));
    let rows: Vec<_> =
        order.iter().map(|&c| (between.eigenvectors.column(c).transpose()) * &whiten).collect();
    DMatrix::from_rows(&rows)
}
