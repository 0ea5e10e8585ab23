//! Problems with known solutions, shared by the tests.

mod cmaes;
mod gcmma;
mod mma;
mod oc;
mod properties;
mod subproblem;

use super::*;

/// f0, df0, g, dg.
type Values = (f64, Vec<f64>, Vec<f64>, Vec<f64>);

/// Functions of a problem.
type Problem = fn(&[f64]) -> Values;

/// Weight of a cantilever of five segments under its tip deflection (Svanberg 1987).
fn beam(x: &[f64]) -> Values {
    const K: [f64; 5] = [61.0, 37.0, 19.0, 7.0, 1.0];
    let terms = || K.iter().zip(x);
    let g = terms().map(|(k, x)| k / x.powi(3)).sum::<f64>() - 1.0;
    let dg = terms().map(|(k, x)| -3.0 * k / x.powi(4)).collect();
    (0.0624 * x.iter().sum::<f64>(), vec![0.0624; 5], vec![g], dg)
}

/// Weight of two bars under their stresses (Svanberg 1987).
fn truss(x: &[f64]) -> Values {
    let (area, height) = (x[0], x[1]);
    let root = (1.0 + height * height).sqrt();
    let (mut g, mut dg) = (vec![], vec![]);
    for sign in [1.0, -1.0] {
        let stress = 8.0 / area + sign / (area * height);
        let by_height = -sign / (area * height * height);
        g.push(0.124 * root * stress - 1.0);
        dg.push(-0.124 * root * stress / area);
        dg.push(0.124 * (height / root * stress + root * by_height));
    }
    (area * root, vec![root, area * height / root], g, dg)
}

/// The point of two balls next to 0 (Svanberg 2007).
fn balls(x: &[f64]) -> Values {
    const CENTERS: [[f64; 3]; 2] = [[5.0, 2.0, 1.0], [3.0, 4.0, 3.0]];
    let square = |center: [f64; 3]| x.iter().zip(center).map(|(x, c)| (x - c).powi(2)).sum::<f64>();
    let slopes = |center: [f64; 3]| x.iter().zip(center).map(|(x, c)| 2.0 * (x - c));
    let dg = CENTERS.into_iter().flat_map(slopes).collect();
    (square([0.0; 3]), slopes([0.0; 3]).collect(), CENTERS.map(|c| square(c) - 9.0).to_vec(), dg)
}

/// Box, start and solution of a problem.
struct Known {
    name: &'static str,
    problem: Problem,
    bounds: Bounds,
    start: Vec<f64>,
    solution: &'static [f64],
    optimum: f64,
}

/// The three problems. Solutions are those of the literature, to more digits: in closed form
/// for the beam, `x_j = k_j^(1/4) (sum k^(1/4))^(1/3)`, and by Newton's method on the
/// first-order conditions for the others.
fn known() -> [Known; 3] {
    [
        Known {
            name: "beam",
            problem: beam,
            bounds: Bounds::uniform(5, 1.0, 10.0).unwrap(),
            start: vec![5.0; 5],
            solution: &[6.01601589415, 5.30917385741, 4.49432957332, 3.50147497043, 2.15266532967],
            optimum: 1.339956360599,
        },
        Known {
            name: "truss",
            problem: truss,
            bounds: Bounds::new(vec![0.2, 0.1], vec![4.0, 1.6]).unwrap(),
            start: vec![1.5, 0.5],
            solution: &[1.41163113669, 0.37707243372],
            optimum: 1.508652417502,
        },
        Known {
            name: "balls",
            problem: balls,
            bounds: Bounds::uniform(3, 0.0, 5.0).unwrap(),
            start: vec![4.0, 3.0, 2.0],
            solution: &[2.01751858568, 1.78001143734, 1.23750714834],
            optimum: 8.770245902792,
        },
    ]
}

/// Greatest difference of two vectors.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Numbers in `[0, 1)` that are the same everywhere (Knuth's MMIX generator).
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}
