//! The curvature energy and its gradients against arrays of the published program
//! (`tests/data/curvature/README.md`).

use lab::output::npy;
use patterns::curvature::energy::{Edges, Energy, EnergyConfig, Orientation, Scalar, Spatial};
use patterns::curvature::{Coefficients, Potential};
use solvers::Float;
use solvers::blur::{Blur, BlurEdges};
use solvers::random::{stream, uniform};
use std::f64::consts::PI;

pub(crate) const SHAPE: [usize; 3] = [24, 20, 28];

pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) coefficients: [f64; 6],
    pub(crate) m0: f64,
    /// F at A0 and A300.
    pub(crate) energies: [f64; 2],
    /// Largest error of the single-precision gradient, of its largest entry: the published
    /// program's own in single precision.
    single: f64,
}

pub(crate) const CASES: [Case; 3] = [
    Case {
        name: "willmore",
        coefficients: [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
        m0: -0.5,
        energies: [1549.1889517286838, 43.32928980787305],
        single: 3e-4,
    },
    Case {
        name: "tubes",
        coefficients: [1.0, 2.0, 6.0, -40.0, -40.0, 400.0],
        m0: -0.6,
        energies: [5052.637232759248, 36.09687473233632],
        single: 5e-3,
    },
    Case {
        name: "asym",
        coefficients: [1.0, 2.4, 9.0, 30.0, 170.0, -195.0],
        m0: -0.66,
        energies: [7528.246137333733, 120.25489794679306],
        single: 5e-2,
    },
];

pub(crate) fn load(name: &str) -> Vec<f64> {
    let path = format!("{}/tests/data/curvature/{name}.npy", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
    npy::read(&bytes, 1 << 24).unwrap().iter().copied().collect()
}

fn convert<T: Float>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&v| T::from_f64(v)).collect()
}

/// Largest difference, over the largest entry of `expected`.
fn error<T: Float>(actual: &[T], expected: &[f64]) -> f64 {
    assert_eq!(actual.len(), expected.len());
    let largest = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let pairs = actual.iter().zip(expected);
    pairs.fold(0.0_f64, |most, (a, e)| most.max((a.to_f64() - e).abs())) / largest
}

pub(crate) fn energy<T: Scalar>(case: &Case) -> Energy<T> {
    let coefficients = Coefficients::from(case.coefficients);
    Energy::new(EnergyConfig::new(SHAPE, 0.01, 0.02, coefficients)).unwrap()
}

#[test]
fn energy_and_gradient_at_the_start() {
    // The start differs between the cases by the mass only.
    let start = load("willmore_A0_u_f64");
    for case in &CASES {
        let u: Vec<f64> = start.iter().map(|u| u + (case.m0 + 0.5)).collect();
        let expected = load(&format!("{}_A0_dF_du_f64", case.name));
        let mut gradient = vec![0.0; u.len()];
        let f = energy::<f64>(case).value_and_gradient(&u, &mut gradient);
        let relative = (f / case.energies[0] - 1.0).abs();
        let worst = error(&gradient, &expected);
        let mut single = vec![0.0_f32; u.len()];
        let f32 = energy::<f32>(case).value_and_gradient(&convert(&u), &mut single);
        let relative32 = (f32 / case.energies[0] - 1.0).abs();
        let worst32 = error(&single, &expected);
        println!(
            "{}: F {relative:.1e}, dF/du {worst:.1e}; single F {relative32:.1e}, dF/du {worst32:.1e}",
            case.name
        );
        assert!(relative < 1e-12 && worst < 1e-8);
        assert!(relative32 < 2e-6 && worst32 < case.single);
    }
}

#[test]
fn curvatures_and_discrepancy() {
    let u = load("tubes_A300_u_f64");
    let energy = energy::<f64>(&CASES[1]);
    let (mut kappa1, mut kappa2) = (u.clone(), u.clone());
    energy.curvatures(&u, &mut kappa1, &mut kappa2);
    let worst = [(kappa1, "kap1"), (kappa2, "kap2")]
        .map(|(kappa, name)| error(&kappa, &load(&format!("tubes_A300_{name}_f64"))));
    let discrepancy = energy.discrepancy(&u);
    println!("kappa {:.1e} {:.1e}, discrepancy {discrepancy}", worst[0], worst[1]);
    assert!(worst[0] < 1e-10 && worst[1] < 1e-10);
    assert!((discrepancy / 0.09741092148535814 - 1.0).abs() < 1e-12);
}

pub(crate) fn potential(shape: [usize; 3], m0: f64) -> Potential<f64> {
    Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(m0)).unwrap()
}

pub(crate) fn components(a: &[f64]) -> [Vec<f64>; 3] {
    let n = a.len() / 3;
    [0, 1, 2].map(|c| a[c * n..(c + 1) * n].to_vec())
}

#[test]
fn phase_and_gradient_of_the_potential() {
    let states = [("A0", "A0", &CASES[0]), ("A300_f64", "A300", &CASES[1])];
    for (file, state, case) in states {
        let a = if state == "A0" { load("A0") } else { load(&format!("{}_{file}", case.name)) };
        let a = components(&a);
        let mut map = potential(SHAPE, case.m0);
        let (mut u, mut between) = (a[0].clone(), a[0].clone());
        map.phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
        let phase = error(&u, &load(&format!("{}_{state}_u_f64", case.name)));
        let mut gradient = u.clone();
        let mut energy = energy::<f64>(case);
        let f = energy.value_and_gradient(&u, &mut gradient)
            / case.energies[usize::from(state != "A0")];
        map.blur_in_place(&mut gradient, &mut between);
        let mut all = [u.clone(), u.clone(), u.clone()];
        let [z, y, x] = &mut all;
        map.gradient(&gradient, [z, y, x]);
        let worst = error(&all.concat(), &load(&format!("{}_{state}_dG_dA_f64", case.name)));
        println!("{} {state}: u {phase:.1e}, F {:.1e}, dG/dA {worst:.1e}", case.name, f - 1.0);
        assert!(phase < 1e-12 && (f - 1.0).abs() < 1e-12 && worst < 1e-8);
    }
    for case in &CASES {
        let a = components(&load(&format!("{}_A300_f64", case.name)));
        let (mut u, mut between) = (a[0].clone(), a[0].clone());
        potential(SHAPE, case.m0).phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
        let f = energy::<f64>(case).value(&u) / case.energies[1];
        assert!((f - 1.0).abs() < 1e-12, "{}: {f}", case.name);
    }
}

#[test]
fn orientation() {
    let u = load("tubes_A300_u_f64");
    let mut config = EnergyConfig::new(SHAPE, 0.01, 0.02, CASES[1].coefficients.into());
    let theta = [1.0, 0.0, 0.0].map(Spatial::Uniform);
    config.orientation = Some(Orientation { mu: Spatial::Uniform(1000.0), theta });
    let mut energy = Energy::<f64>::new(config).unwrap();
    let (mut gradient, mut between) = (u.clone(), u.clone());
    let f = energy.value_and_gradient(&u, &mut gradient);
    let mut map = potential(SHAPE, -0.6);
    map.blur_in_place(&mut gradient, &mut between);
    let mut all = [u.clone(), u.clone(), u.clone()];
    let [z, y, x] = &mut all;
    map.gradient(&gradient, [z, y, x]);
    let norm = all.iter().flatten().map(|g| g * g).sum::<f64>().sqrt();
    println!("orientation: F {f}, |dG/dA| {norm}");
    // The published program's values at u of the A of which this u is, both in f64.
    assert!((f / 63.230065338733766 - 1.0).abs() < 1e-12);
    assert!((norm / 67.73110443293618 - 1.0).abs() < 1e-9);
}

#[test]
fn replicated_edges() {
    let v = load("tubes_A300_u_f64");
    let mut config = EnergyConfig::new(SHAPE, 0.01, 0.02, CASES[0].coefficients.into());
    config.edges = Edges::Replicate;
    let mut energy = Energy::<f64>::new(config).unwrap();
    let mut blur = Blur::<f64>::new(SHAPE, 1.0, BlurEdges::Replicate).unwrap();
    let (mut between, mut u, mut gradient) = (v.clone(), v.clone(), v.clone());
    blur.apply(&v, &mut between, &mut u);
    let f = energy.value_and_gradient(&u, &mut gradient) / 110.95036779381027;
    blur.transpose(&mut gradient, &mut between);
    let worst = error(&gradient, &load("replicate_willmore_dF_dv_true_f64"));
    println!("replicated edges: F {:.1e}, dF/dv {worst:.1e}", f - 1.0);
    assert!((f - 1.0).abs() < 1e-12 && worst < 1e-8);
}

fn noise(n: usize, name: &str) -> Vec<f64> {
    let mut stream = stream(5, name, 0);
    (0..n).map(|_| uniform(&mut stream) - 0.5).collect()
}

/// Central differences along random directions, for every coefficient, edge and field.
#[test]
fn gradients_against_differences() {
    let shape = [6, 5, 19];
    let n = shape.iter().product();
    let (u, direction) = (noise(n, "u"), noise(n, "direction"));
    let mut worst = 0.0_f64;
    for edges in [Edges::Periodic, Edges::Replicate, Edges::Free] {
        for term in 0..8 {
            let mut config = EnergyConfig::new(shape, 0.1, 0.2, CASES[0].coefficients.into());
            config.edges = edges;
            config.coefficients = [0, 1, 2, 3, 4, 5].map(|i| match term {
                6 => Spatial::Map(noise(n, &format!("coefficient {i}"))),
                _ => Spatial::Uniform(f64::from(u8::from(i == term))),
            });
            if term >= 6 {
                let theta = |axis| match term {
                    6 => Spatial::Map(noise(n, &format!("theta {axis}"))),
                    _ => Spatial::Uniform(0.3 + axis as f64),
                };
                let theta = [0, 1, 2].map(theta);
                config.orientation = Some(Orientation { mu: Spatial::Uniform(2.0), theta });
            }
            // A softplus wide enough to be smooth on the scale of the differences.
            config.width = 0.1;
            let mut energy = Energy::<f64>::new(config).unwrap();
            let mut gradient = u.clone();
            let f = energy.value_and_gradient(&u, &mut gradient);
            assert_eq!(f.to_bits(), energy.value(&u).to_bits());
            let mut along = |h: f64| {
                let moved: Vec<f64> = u.iter().zip(&direction).map(|(u, d)| u + h * d).collect();
                energy.value(&moved)
            };
            let h = 1e-5;
            // Fourth order: the error of the differences is below their rounding.
            let difference =
                (8.0 * (along(h) - along(-h)) - (along(2.0 * h) - along(-2.0 * h))) / (12.0 * h);
            let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
            let size = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
            worst = worst.max((slope - difference).abs() / size);
            assert!(
                (slope - difference).abs() < 1e-7 * size,
                "{edges:?} {term}: {slope} {difference}"
            );
        }
    }
    println!("differences: {worst:.1e}");
}

/// The box turned and moved: the energy stays, and its gradient turns and moves along.
#[test]
fn axes_and_origin_do_not_matter() {
    let [nz, ny, nx] = SHAPE;
    let case = &CASES[2];
    let u = noise(nz * ny * nx, "turned");
    let mut gradient = u.clone();
    let f = energy::<f64>(case).value_and_gradient(&u, &mut gradient);
    let turned = |source: &[f64]| {
        let at = |i: usize| {
            let (x, z, y) = (i / (nz * ny), i / ny % nz, i % ny);
            source[((z + 5) % nz * ny + (y + 3) % ny) * nx + (x + 17) % nx]
        };
        (0..source.len()).map(at).collect::<Vec<f64>>()
    };
    let config = EnergyConfig::new([nx, nz, ny], 0.01, 0.02, case.coefficients.into());
    let mut other = u.clone();
    let g = Energy::<f64>::new(config).unwrap().value_and_gradient(&turned(&u), &mut other);
    assert!((f / g - 1.0).abs() < 1e-13 && error(&other, &turned(&gradient)) < 1e-9);
}

/// The Willmore energy (H^2, H = kappa1 + kappa2) over that of the transition, 4 / (3 sqrt 2),
/// of a sphere (16 pi) and a Clifford torus (8 pi^2), at eps = 2 dx on ever finer grids.
#[test]
fn energies_of_surfaces_converge() {
    let line = 2.0_f64.sqrt();
    type Distance = fn([f64; 3]) -> f64;
    let surfaces: [(&str, f64, Distance); 2] = [
        ("sphere", 16.0 * PI, |[x, y, z]| 0.3 - (x * x + y * y + z * z).sqrt()),
        ("torus", 8.0 * PI * PI, |[x, y, z]| {
            0.16 - ((x.hypot(y) - 0.16 * 2.0_f64.sqrt()).powi(2) + z * z).sqrt()
        }),
    ];
    for (name, exact, distance) in surfaces {
        let errors = [40_usize, 80, 160].map(|n| {
            let (dx, eps) = (1.0 / n as f64, 0.8 / (n as f64).sqrt() * 0.25);
            let at = |i: usize| (i as f64 + 0.5) * dx - 0.5;
            let value = |i: usize| {
                let point = [at(i % n), at(i / n % n), at(i / (n * n))];
                (distance(point) / (line * eps)).tanh()
            };
            let u: Vec<f64> = (0..n * n * n).map(value).collect();
            let config = EnergyConfig::new([n; 3], dx, eps, CASES[0].coefficients.into());
            let f = Energy::<f64>::new(config).unwrap().value(&u) * 3.0 * line / 4.0;
            f / exact - 1.0
        });
        let order = |a: f64, b: f64| (a / b).abs().log2();
        println!(
            "{name}: {errors:.4?}, orders {:.2} {:.2}",
            order(errors[0], errors[1]),
            order(errors[1], errors[2])
        );
        assert!(errors[2].abs() < 0.02 && order(errors[1], errors[2]) > 0.8, "{errors:?}");
    }
}
