//! The curvature energy and its flows against arrays of the published program
//! (`tests/data/curvature/README.md`).
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use lab::output::npy;
use patterns::curvature::Coefficients;
use patterns::curvature::energy::{Energy, EnergyConfig};
use solvers::Float;

const SHAPE: [usize; 3] = [24, 20, 28];

struct Case {
    name: &'static str,
    coefficients: [f64; 6],
    m0: f64,
    /// F at A0 and A300.
    energies: [f64; 2],
    /// Largest error of the single-precision gradient, of its largest entry: the published
    /// program's own in single precision.
    single: f64,
}

const CASES: [Case; 3] = [
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

fn load(name: &str) -> Vec<f64> {
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

fn energy<T: Float>(case: &Case) -> Energy<T> {
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
