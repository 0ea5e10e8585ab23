//! The variables of a subproblem, in blocks that are worked on beside each other.

use super::expansion::{BLOCK, Expansion, add_scaled, dot};
use super::subproblem::Model;

/// Part of the positive and of the negative slope that goes to the other pole as well, which
/// makes every approximation strictly convex (Svanberg 2007, eqs. 3.3 and 3.4).
const BOTH_POLES: f64 = 0.001;

/// Width below which a box counts as this wide where it divides, as published.
pub(super) const LEAST_WIDTH: f64 = 1e-5;

/// A step may use up this part of the way to a bound, as published: 1/1.01.
pub(super) const TO_BOUNDARY: f64 = 1.01;

/// Up to [`BLOCK`] free variables: their approximations, their state in the interior-point
/// method, and the sums over them.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// Which variables these are.
    pub(super) index: Vec<usize>,
    low: Vec<f64>,
    upp: Vec<f64>,
    alpha: Vec<f64>,
    beta: Vec<f64>,
    p0: Vec<f64>,
    q0: Vec<f64>,
    /// Rows of constraints, `[m, len]`.
    p: Vec<f64>,
    q: Vec<f64>,
    slope: Vec<f64>,
    pub(super) x: Vec<f64>,
    /// Multipliers of `alpha <= x` and `x <= beta`, and the steps of all three.
    xi: Vec<f64>,
    eta: Vec<f64>,
    dx: Vec<f64>,
    dxi: Vec<f64>,
    deta: Vec<f64>,
    /// Gradient of the barrier function, and the inverse of its second derivative.
    force: Vec<f64>,
    weight: Vec<f64>,
    /// Sums over the block, by constraint or by pair of constraints.
    pub(super) sums: Vec<f64>,
    pub(super) gram: Vec<f64>,
    /// Sum of squared residuals and the greatest, or the greatest fraction of a step.
    pub(super) square: f64,
    pub(super) largest: f64,
}

impl Block {
    pub(super) fn new(index: &[usize], m: usize) -> Self {
        let n = index.len();
        let (row, rows) = (vec![0.0; n], vec![0.0; m * n]);
        let mut block = Self { index: index.to_vec(), ..Self::default() };
        for array in block.arrays() {
            array.clone_from(&row);
        }
        (block.p, block.q, block.slope) = (rows.clone(), rows.clone(), rows);
        block.sums = vec![0.0; m + 2];
        block.gram = vec![0.0; m * (m + 1) / 2];
        block
    }

    fn arrays(&mut self) -> [&mut Vec<f64>; 14] {
        let Self {
            low, upp, alpha, beta, p0, q0, x, xi, eta, dx, dxi, deta, force, weight, ..
        } = self;
        [low, upp, alpha, beta, p0, q0, x, xi, eta, dx, dxi, deta, force, weight]
    }

    /// Approximates the functions at the model's point (Svanberg 2007, eqs. 3.2 to 3.7); sums
    /// their parts there by constraint.
    pub(super) fn build(&mut self, model: &Model<'_>) {
        let (len, n) = (self.index.len(), model.x.len());
        for k in 0..len {
            let j = self.index[k];
            let [low, upp] = model.history.at(j);
            let (lower, upper) = (model.bounds.lower()[j], model.bounds.upper()[j]);
            (self.low[k], self.upp[k]) = (low, upp);
            [self.alpha[k], self.beta[k]] =
                model.limits.step_bounds(model.x[j], low, upp, lower, upper);
            let slope = model.values.df0[j];
            [self.p0[k], self.q0[k]] = model.poles(j, slope, model.curvature[0]);
        }
        for (i, slopes) in model.values.dg.chunks_exact(n).enumerate() {
            let mut sum = 0.0;
            for (k, &j) in self.index.iter().enumerate() {
                let [p, q] = model.poles(j, slopes[j], model.curvature[i + 1]);
                (self.p[i * len + k], self.q[i * len + k]) = (p, q);
                sum += p / (self.upp[k] - model.x[j]) + q / (model.x[j] - self.low[k]);
            }
            self.sums[i] = sum;
        }
    }

    /// Starts in the middle of the step's bounds.
    pub(super) fn start(&mut self) {
        for k in 0..self.index.len() {
            let x = 0.5 * (self.alpha[k] + self.beta[k]);
            self.x[k] = x;
            self.xi[k] = (1.0 / (x - self.alpha[k])).max(1.0);
            self.eta[k] = (1.0 / (self.beta[k] - x)).max(1.0);
        }
    }

    /// What the residuals and the Newton system share, at a fraction `t` of the step.
    fn expand(&self, t: f64, multipliers: &[f64]) -> Expansion {
        let len = self.index.len();
        let mut at = Expansion::new();
        at.p[..len].copy_from_slice(&self.p0);
        at.q[..len].copy_from_slice(&self.q0);
        for (i, &multiplier) in multipliers.iter().enumerate() {
            add_scaled(multiplier, &self.p[i * len..][..len], &mut at.p);
            add_scaled(multiplier, &self.q[i * len..][..len], &mut at.q);
        }
        for k in 0..len {
            let x = moved(self.x[k], t, self.dx[k]);
            at.above[k] = 1.0 / (self.upp[k] - x);
            at.below[k] = 1.0 / (x - self.low[k]);
        }
        at
    }

    /// Residuals of the conditions on x, xi and eta at a fraction `t` of the step, and the
    /// sums `sum_j p_ij/(u_j - x_j) + q_ij/(x_j - l_j)` (Svanberg 2007, section 5).
    pub(super) fn residual(&mut self, t: f64, multipliers: &[f64], epsilon: f64) {
        let len = self.index.len();
        let at = self.expand(t, multipliers);
        let (mut square, mut largest) = (0.0, 0.0_f64);
        for k in 0..len {
            let x = moved(self.x[k], t, self.dx[k]);
            let xi = moved(self.xi[k], t, self.dxi[k]);
            let eta = moved(self.eta[k], t, self.deta[k]);
            let slope = at.p[k] * at.above[k] * at.above[k] - at.q[k] * at.below[k] * at.below[k];
            let stationary = slope - xi + eta;
            let lower = xi * (x - self.alpha[k]) - epsilon;
            let upper = eta * (self.beta[k] - x) - epsilon;
            square += stationary * stationary + lower * lower + upper * upper;
            largest = largest.max(stationary.abs().max(lower.abs()).max(upper.abs()));
        }
        (self.square, self.largest) = (square, largest);
        for i in 0..multipliers.len() {
            let row = i * len..(i + 1) * len;
            self.sums[i] =
                dot(&self.p[row.clone()], &at.above[..len]) + dot(&self.q[row], &at.below[..len]);
        }
    }

    /// The block's part of the Newton system after x, xi and eta are eliminated: the Gram
    /// matrix `G D^-1 G^T`, upper triangle by rows, and `G D^-1 (gradient of the barrier)`.
    pub(super) fn newton(&mut self, multipliers: &[f64], epsilon: f64) {
        let len = self.index.len();
        let at = self.expand(0.0, multipliers);
        let mut scaled = [0.0; BLOCK];
        for k in 0..len {
            let (above, below) = (at.above[k] * at.above[k], at.below[k] * at.below[k]);
            let (from, to) = self.barriers(k);
            let (p, q) = (at.p[k] * above, at.q[k] * below);
            let curvature = 2.0 * (p * at.above[k] + q * at.below[k]);
            self.force[k] = p - q - epsilon * from + epsilon * to;
            self.weight[k] = 1.0 / (curvature + self.xi[k] * from + self.eta[k] * to);
        }
        let mut pair = 0;
        for i in 0..multipliers.len() {
            let row = i * len;
            for (k, scaled) in scaled[..len].iter_mut().enumerate() {
                let slope = self.p[row + k] * at.above[k] * at.above[k]
                    - self.q[row + k] * at.below[k] * at.below[k];
                self.slope[row + k] = slope;
                *scaled = slope * self.weight[k];
            }
            self.sums[i] = dot(&scaled[..len], &self.force);
            for other in 0..=i {
                self.gram[pair] = dot(&scaled[..len], &self.slope[other * len..][..len]);
                pair += 1;
            }
        }
    }

    /// The block's step for a step of the multipliers, and the greatest fraction of the way to
    /// a bound that it takes, times [`TO_BOUNDARY`].
    pub(super) fn direction(&mut self, dmultipliers: &[f64], epsilon: f64) {
        let len = self.index.len();
        self.dx.copy_from_slice(&self.force);
        for (i, &step) in dmultipliers.iter().enumerate() {
            add_scaled(step, &self.slope[i * len..][..len], &mut self.dx);
        }
        let mut largest = 0.0_f64;
        for k in 0..len {
            let (from, to) = self.barriers(k);
            let (xi, eta) = (self.xi[k], self.eta[k]);
            let dx = -self.dx[k] * self.weight[k];
            let dxi = (epsilon - xi * dx) * from - xi;
            let deta = (epsilon + eta * dx) * to - eta;
            (self.dx[k], self.dxi[k], self.deta[k]) = (dx, dxi, deta);
            let used = (-dx * from).max(dx * to).max(-dxi / xi).max(-deta / eta);
            largest = largest.max(used);
        }
        self.largest = TO_BOUNDARY * largest;
    }

    /// `1/(x - alpha)` and `1/(beta - x)`.
    fn barriers(&self, k: usize) -> (f64, f64) {
        (1.0 / (self.x[k] - self.alpha[k]), 1.0 / (self.beta[k] - self.x[k]))
    }

    /// Takes a fraction `t` of the step.
    pub(super) fn commit(&mut self, t: f64) {
        for k in 0..self.index.len() {
            self.x[k] += t * self.dx[k];
            self.xi[k] += t * self.dxi[k];
            self.eta[k] += t * self.deta[k];
        }
    }

    /// Sums of the approximations' changes from the model's point to x: f_0, then the
    /// constraints, then the distance of eq. 4.7.
    ///
    /// Differences are taken term by term: those of the whole functions would be round-off
    /// near an optimum, where conservative trials must be told from others.
    pub(super) fn changes(&mut self, model: &Model<'_>) {
        let len = self.index.len();
        self.sums.fill(0.0);
        let m = self.sums.len() - 2;
        for (k, &j) in self.index.iter().enumerate() {
            let (x, center, low, upp) = (self.x[k], model.x[j], self.low[k], self.upp[k]);
            let above = (x - center) / ((upp - x) * (upp - center));
            let below = (x - center) / ((x - low) * (center - low));
            self.sums[0] += self.p0[k] * above - self.q0[k] * below;
            for i in 0..m {
                self.sums[i + 1] += self.p[i * len + k] * above - self.q[i * len + k] * below;
            }
            let distance = (upp - low) * (x - center).powi(2) / ((upp - x) * (x - low));
            self.sums[m + 1] += distance / model.width(j);
        }
    }
}

impl Model<'_> {
    /// Width of a variable's box where it divides.
    fn width(&self, j: usize) -> f64 {
        (self.bounds.upper()[j] - self.bounds.lower()[j]).max(LEAST_WIDTH)
    }

    /// Coefficients p and q of a function with this slope (Svanberg 2007, eqs. 3.3 and 3.4).
    fn poles(&self, j: usize, slope: f64, curvature: f64) -> [f64; 2] {
        let [low, upp] = self.history.at(j);
        let (up, down) = (slope.max(0.0), (-slope).max(0.0));
        let both = BOTH_POLES * (up + down) + curvature / self.width(j);
        let (above, below) = (upp - self.x[j], self.x[j] - low);
        [above * above * (up + both), below * below * (down + both)]
    }
}

/// `value + t step`, without touching a step that was never computed.
fn moved(value: f64, t: f64, step: f64) -> f64 {
    if t == 0.0 { value } else { value + t * step }
}
