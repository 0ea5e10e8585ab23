use super::Artificial;

/// Unknowns whose number does not grow with n; also a step of them.
#[derive(Clone)]
pub(super) struct Point {
    pub(super) multipliers: Vec<f64>,
    pub(super) s: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) mu: Vec<f64>,
    pub(super) z: f64,
    pub(super) zeta: f64,
}

impl Point {
    pub(super) fn start(costs: &Artificial) -> Self {
        let ones = || vec![1.0; costs.len()];
        let mu = costs.c.iter().map(|c| (0.5 * c).max(1.0)).collect();
        Self { multipliers: ones(), s: ones(), y: ones(), mu, z: 1.0, zeta: 1.0 }
    }

    pub(super) fn moved(&self, t: f64, step: &Self) -> Self {
        let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + t * b).collect();
        Self {
            multipliers: add(&self.multipliers, &step.multipliers),
            s: add(&self.s, &step.s),
            y: add(&self.y, &step.y),
            mu: add(&self.mu, &step.mu),
            z: self.z + t * step.z,
            zeta: self.zeta + t * step.zeta,
        }
    }

    /// Greatest part of its way to 0 that an unknown goes in a whole step.
    pub(super) fn used_by(&self, step: &Self) -> f64 {
        let pairs = [
            (&self.multipliers, &step.multipliers),
            (&self.s, &step.s),
            (&self.y, &step.y),
            (&self.mu, &step.mu),
        ];
        let used = pairs.into_iter().flat_map(|(v, d)| v.iter().zip(d)).map(|(v, d)| -d / v);
        used.fold((-step.z / self.z).max(-step.zeta / self.zeta), f64::max)
    }

    /// Residuals of the conditions on these unknowns (Svanberg 2007, section 5).
    pub(super) fn residuals(
        &self,
        costs: &Artificial,
        b: &[f64],
        g: &[f64],
        epsilon: f64,
    ) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(4 * g.len() + 2);
        let mut z_row = costs.a0 - self.zeta;
        for i in 0..g.len() {
            let (lambda, s, y, mu) = (self.multipliers[i], self.s[i], self.y[i], self.mu[i]);
            z_row -= costs.a[i] * lambda;
            residuals.push(costs.c[i] + costs.d[i] * y - mu - lambda);
            residuals.push(g[i] - costs.a[i] * self.z - y + s - b[i]);
            residuals.push(mu * y - epsilon);
            residuals.push(lambda * s - epsilon);
        }
        residuals.extend([z_row, self.zeta * self.z - epsilon]);
        residuals
    }
}
