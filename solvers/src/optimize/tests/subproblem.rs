//! First steps, against the subproblem as the paper writes it and its dual by search.
#![expect(clippy::print_stdout, reason = "measured figures are for the reader of a test run")]

use super::*;

/// The subproblem of a first step with the default constants, written down again.
struct Paper {
    low: Vec<f64>,
    upp: Vec<f64>,
    alpha: Vec<f64>,
    beta: Vec<f64>,
    /// Objective first.
    p: Vec<Vec<f64>>,
    q: Vec<Vec<f64>>,
    b: Vec<f64>,
}

impl Paper {
    fn new(bounds: &Bounds, x: &[f64], (_, df0, g, dg): &Values) -> Self {
        let n = x.len();
        let width: Vec<f64> = (0..n).map(|j| bounds.upper()[j] - bounds.lower()[j]).collect();
        let at = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<_>>();
        let low = at(&|j| x[j] - 0.5 * width[j]);
        let upp = at(&|j| x[j] + 0.5 * width[j]);
        let alpha = at(&|j| bounds.lower()[j].max(low[j] + 0.1 * (x[j] - low[j])));
        let beta = at(&|j| bounds.upper()[j].min(upp[j] - 0.1 * (upp[j] - x[j])));
        let rows = || std::iter::once(df0.as_slice()).chain(dg.chunks_exact(n));
        let pole = |slope: f64, width: f64| {
            1.001 * slope.max(0.0) + 0.001 * (-slope).max(0.0) + 1e-5 / width
        };
        let p = |row: &[f64]| at(&|j| (upp[j] - x[j]).powi(2) * pole(row[j], width[j]));
        let q = |row: &[f64]| at(&|j| (x[j] - low[j]).powi(2) * pole(-row[j], width[j]));
        let (p, q): (Vec<_>, Vec<_>) = rows().map(|row| (p(row), q(row))).unzip();
        let mut paper = Self { low, upp, alpha, beta, p, q, b: vec![] };
        paper.b = (0..g.len()).map(|i| paper.value(i + 1, x) - g[i]).collect();
        paper
    }

    /// Function i, 0 for the objective, less its constant.
    fn value(&self, i: usize, x: &[f64]) -> f64 {
        let term =
            |j: usize| self.p[i][j] / (self.upp[j] - x[j]) + self.q[i][j] / (x[j] - self.low[j]);
        (0..x.len()).map(term).sum()
    }

    /// Coefficients of the Lagrangian in variable j.
    fn lagrangian(&self, j: usize, multipliers: &[f64]) -> [f64; 2] {
        let with = |rows: &[Vec<f64>]| {
            rows[0][j] + multipliers.iter().zip(&rows[1..]).map(|(l, row)| l * row[j]).sum::<f64>()
        };
        [with(&self.p), with(&self.q)]
    }

    /// Largest violation of the first-order conditions (Svanberg 2007, section 5).
    fn kkt(&self, costs: &Artificial, x: &[f64], solve: &Solve) -> f64 {
        let Solve { multipliers, y, z, .. } = solve;
        let mut worst = 0.0_f64;
        // A slope that is not 0 must be held by the bound on its side; a value that is not
        // 0 makes its multiplier vanish.
        let mut see = |violation: f64| worst = worst.max(violation);
        for (j, &x) in x.iter().enumerate() {
            let [p, q] = self.lagrangian(j, multipliers);
            let slope = p / (self.upp[j] - x).powi(2) - q / (x - self.low[j]).powi(2);
            see(slope.max(0.0) * (x - self.alpha[j]));
            see((-slope).max(0.0) * (self.beta[j] - x));
            assert!(x >= self.alpha[j] && x <= self.beta[j]);
        }
        let mut z_slope = costs.a0;
        for (i, &lambda) in multipliers.iter().enumerate() {
            let excess = self.value(i + 1, x) - costs.a[i] * z - y[i] - self.b[i];
            let y_slope = costs.c[i] + costs.d[i] * y[i] - lambda;
            z_slope -= costs.a[i] * lambda;
            [excess, -lambda, (lambda * excess).abs()].into_iter().for_each(&mut see);
            [-y[i], -y_slope, (y[i] * y_slope).abs()].into_iter().for_each(&mut see);
        }
        [-z, -z_slope, (z * z_slope).abs()].into_iter().for_each(see);
        worst
    }

    /// Dual function for a = 0, with the x at which its minimum is.
    fn dual(&self, costs: &Artificial, multipliers: &[f64]) -> (f64, Vec<f64>) {
        let x: Vec<f64> = (0..self.low.len())
            .map(|j| {
                let [p, q] = self.lagrangian(j, multipliers).map(f64::sqrt);
                let free = (p * self.low[j] + q * self.upp[j]) / (p + q);
                free.clamp(self.alpha[j], self.beta[j])
            })
            .collect();
        let mut value = self.value(0, &x);
        for (i, &lambda) in multipliers.iter().enumerate() {
            let y = ((lambda - costs.c[i]) / costs.d[i]).max(0.0);
            value += lambda * (self.value(i + 1, &x) - self.b[i]);
            value += (costs.c[i] + 0.5 * costs.d[i] * y - lambda) * y;
        }
        (value, x)
    }

    /// Greatest dual value over two multipliers, by grids that close in on it.
    fn search(&self, costs: &Artificial) -> (f64, [f64; 2]) {
        let (mut best, mut at, mut reach) = (f64::NEG_INFINITY, [0.0; 2], 2000.0);
        while reach > 1e-9 {
            let center = at;
            for k in 0..41 * 41 {
                let offset = [k % 41, k / 41].map(|k| reach * (f64::from(k) / 20.0 - 1.0));
                let trial = [0, 1].map(|i| (center[i] + offset[i]).max(0.0));
                let value = self.dual(costs, &trial).0;
                if value > best {
                    (best, at) = (value, trial);
                }
            }
            reach *= 0.6;
        }
        (best, at)
    }
}

/// A point in a box, and functions with slopes of both signs there.
fn random(seed: u64, n: usize, m: usize) -> (Bounds, Vec<f64>, Values) {
    let mut noise = noise(seed);
    let lower: Vec<f64> = (0..n).map(|_| -2.0 * noise()).collect();
    let upper: Vec<f64> = lower.iter().map(|l| l + 0.5 + 3.0 * noise()).collect();
    let x = (0..n).map(|j| lower[j] + noise() * (upper[j] - lower[j])).collect();
    let mut slopes = |count: usize| (0..count).map(|_| 4.0 * noise() - 2.0).collect::<Vec<_>>();
    let values = (1.0, slopes(n), slopes(m), slopes(m * n));
    (Bounds::new(lower, upper).unwrap(), x, values)
}

fn first_step(
    bounds: &Bounds,
    costs: &Artificial,
    x: &[f64],
    values: &Values,
) -> (Vec<f64>, Solve) {
    let mut mma = Mma::new(bounds.clone(), costs.clone(), MmaConfig::default()).unwrap();
    let next = mma.step(x, values.0, &values.1, &values.2, &values.3).unwrap().to_vec();
    (next, mma.last_solve().clone())
}

#[test]
fn solutions_fulfil_the_first_order_conditions() {
    let (mut worst, mut most) = (0.0_f64, 0);
    for (seed, (n, m)) in [(1, 0), (1, 1), (2, 3), (7, 2), (40, 5), (600, 3), (5000, 2), (3, 12)]
        .into_iter()
        .enumerate()
    {
        for min_max in [false, true] {
            let (bounds, x, values) = random(seed as u64, n, m);
            let costs = if min_max { Artificial::min_max(m, 0) } else { Artificial::standard(m) };
            let (next, solve) = first_step(&bounds, &costs, &x, &values);
            let violation = Paper::new(&bounds, &x, &values).kkt(&costs, &next, &solve);
            assert!(solve.converged, "n = {n}, m = {m}: {solve:?}");
            assert!(violation < 1e-7, "n = {n}, m = {m}: violation {violation:e}");
            (worst, most) = (worst.max(violation), most.max(solve.newton_steps));
        }
    }
    println!("violation of the conditions {worst:.1e}, at most {most} Newton steps");
}

#[test]
fn the_dual_has_its_maximum_at_the_multipliers() {
    for seed in 0..12 {
        let (bounds, x, values) = random(100 + seed, 3, 2);
        let costs = Artificial::standard(2);
        let (next, solve) = first_step(&bounds, &costs, &x, &values);
        let paper = Paper::new(&bounds, &x, &values);
        let (best, multipliers) = paper.search(&costs);
        let found = paper.dual(&costs, &solve.multipliers).0;
        let artificial: f64 = solve.y.iter().map(|y| 1000.0 * y + 0.5 * y * y).sum();
        let primal = paper.value(0, &next) + artificial;
        println!("dual {best:.9} at {multipliers:.6?}, found {found:.9}, primal {primal:.9}");
        // Gaps are sums of complementary products of 1e-8; costs of 1000 multiply round-off.
        let scale = best.abs().max(1.0);
        assert!((found - best).abs() < 1e-6 * scale && (primal - best).abs() < 1e-5 * scale);
    }
}

#[test]
fn more_constraints_than_can_hold_leave_a_violation() {
    // x <= -1 and x >= 1 about x = 0: y shares the least total violation.
    let bounds = Bounds::uniform(1, -4.0, 4.0).unwrap();
    let values = (0.0, vec![0.0], vec![1.0, 1.0], vec![1.0, -1.0]);
    let (next, solve) = first_step(&bounds, &Artificial::standard(2), &[0.0], &values);
    assert!(next[0].abs() < 1e-6 && solve.converged, "{next:?} {solve:?}");
    assert!(solve.y.iter().all(|y| *y > 0.9) && solve.multipliers.iter().all(|l| *l > 1000.0));
}
