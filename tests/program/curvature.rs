//! The curvature energy and its flows against arrays of the published program
//! (`tests/data/curvature/README.md`).

use lab::output::npy;
use patterns::curvature::energy::{Edges, Energy, EnergyConfig, Orientation, Scalar, Spatial};
use patterns::curvature::flow::{
    Descent, DescentConfig, Fast, FastConfig, Opened, OpenedConfig, Paper, PaperConfig, StepInfo,
};
use patterns::curvature::{Coefficients, Mask, Potential};
use solvers::Float;
use solvers::blur::{Blur, BlurEdges, Stored};
use solvers::random::{stream, uniform};
use std::f64::consts::PI;

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

fn energy<T: Scalar>(case: &Case) -> Energy<T> {
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

fn potential(shape: [usize; 3], m0: f64) -> Potential<f64> {
    Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(m0)).unwrap()
}

fn components(a: &[f64]) -> [Vec<f64>; 3] {
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
        map.blur_gradient(&mut gradient, &mut between);
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

/// Asymmetric energies amplify roundings a thousandfold in a few steps: only the first five
/// are compared.
#[test]
fn published_flow() {
    for (case, steps, tolerance) in
        [(&CASES[0], 300, 1e-10), (&CASES[1], 5, 1e-10), (&CASES[2], 5, 1e-9)]
    {
        let a = components(&load("A0"));
        let map = potential(SHAPE, case.m0);
        let mut flow =
            Paper::from_potential(energy::<f64>(case), map, PaperConfig::default(), a).unwrap();
        let expected = load(&format!("{}_adam_E_0_300_f64", case.name));
        let mut worst = 0.0_f64;
        for &expected in &expected[..=steps] {
            let info = flow.step().unwrap();
            worst = worst.max((info.energy / expected - 1.0).abs());
        }
        println!("{}: {steps} steps within {worst:.1e}", case.name);
        assert!(worst < tolerance);
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
    map.blur_gradient(&mut gradient, &mut between);
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
    blur.apply(&Stored(&v), &mut between, &mut u);
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

#[test]
fn mass_is_kept() {
    let case = &CASES[1];
    let a = components(&load("A0"));
    let (mut u, mut between) = (a[0].clone(), a[0].clone());
    potential(SHAPE, case.m0).phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
    let mean = |u: &[f64]| u.iter().sum::<f64>() / u.len() as f64;
    let before = mean(&u);
    let mut fast = Fast::new(energy::<f64>(case), FastConfig::default(), u.clone()).unwrap();
    let first = fast.step().unwrap().energy;
    for _ in 0..60 {
        fast.step().unwrap();
    }
    let last = fast.step().unwrap().energy;
    println!("fast: F {first:.1} to {last:.1}, mean moved by {:.1e}", mean(fast.phase()) - before);
    assert!((mean(fast.phase()) - before).abs() < 1e-14 && last < 0.1 * first);
    let free = DescentConfig { sigma: None, keep_mass: true, ..DescentConfig::default() };
    let spectral = DescentConfig { beta: Some(1.0), sigma: None, ..DescentConfig::default() };
    let blurred = DescentConfig { keep_mass: true, ..DescentConfig::default() };
    for (name, config) in [("plain", free), ("blurred", blurred), ("spectral", spectral)] {
        let mut flow = Descent::new(energy::<f64>(&CASES[0]), config, None, u.clone()).unwrap();
        let before = mean(flow.phase());
        let mut energies = Vec::new();
        for _ in 0..40 {
            energies.push(flow.step().unwrap().0.energy);
        }
        println!(
            "{name}: F {:.2} to {:.3}, {} evaluations, mean moved by {:.1e}",
            energies[0],
            energies[39],
            flow.counts()[1],
            mean(flow.phase()) - before
        );
        assert!((mean(flow.phase()) - before).abs() < 1e-13, "{name}");
        assert!(energies.windows(2).all(|pair| pair[1] <= pair[0]), "{name}");
        // Forty steps without a preconditioner are early days.
        assert!(energies[39] < 0.2 * energies[0], "{name}");
    }
}

/// Its opening is the published flow and its rest the fast one from there, to the bit; given
/// voxels stay in both.
#[test]
fn an_opened_flow_is_the_published_one_and_then_the_fast_one() {
    let case = &CASES[1];
    let inside: Vec<bool> = (0..SHAPE.iter().product()).map(|i| i % SHAPE[2] >= 6).collect();
    let mask = || Mask::outside(&inside);
    let map = || potential(SHAPE, case.m0);
    let energy = energy::<f64>(case);
    for opening in [0, 5] {
        let config = OpenedConfig::new(50, Some(opening));
        let opened = Opened::new(energy.clone(), map(), config, 3).unwrap();
        let mut opened = opened.with_mask(mask());
        let paper = Paper::new(energy.clone(), map(), config.paper, 3).unwrap();
        let mut paper = paper.with_mask(mask());
        for _ in 0..opening {
            assert_eq!(opened.step().unwrap(), paper.step().unwrap());
        }
        let fast = Fast::new(energy.clone(), config.fast, paper.phase().to_vec()).unwrap();
        let mut fast = fast.with_mask(mask());
        for n in 0..7 {
            let step = fast.step().unwrap();
            let StepInfo { iteration, energy, .. } = opened.step().unwrap();
            assert_eq!(step.energy.to_bits(), energy.to_bits());
            assert_eq!([iteration, opened.steps()], [opening + n, opening + n + 1]);
        }
        assert_eq!(opened.phase(), fast.phase());
        assert!(opened.phase().iter().zip(&inside).all(|(&u, &inside)| inside || u == -1.0));
    }
}

#[test]
fn given_voxels_stay() {
    let case = &CASES[1];
    let [nz, ny, nx] = SHAPE;
    let inside: Vec<bool> = (0..nz * ny * nx).map(|i| i % nx >= 6).collect();
    let map = potential(SHAPE, case.m0);
    let flow = Paper::new(energy::<f64>(case), map, PaperConfig::default(), 3).unwrap();
    let mut flow = flow.with_mask(Mask::outside(&inside));
    let first = flow.step().unwrap().energy;
    for _ in 0..50 {
        flow.step().unwrap();
    }
    assert!(flow.step().unwrap().energy < 0.5 * first);
    assert!(flow.phase().iter().zip(&inside).all(|(&u, &inside)| inside || u == -1.0));
}

#[test]
fn threads_do_not_change_a_bit() {
    let shape = [33, 30, 37];
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let config = EnergyConfig::new(shape, 0.01, 0.02, CASES[1].coefficients.into());
            let energy = Energy::<f32>::new(config).unwrap();
            let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).unwrap();
            let mut paper = Paper::new(energy.clone(), map, PaperConfig::default(), 3).unwrap();
            let start = paper.phase().to_vec();
            let mut fast = Fast::new(energy.clone(), FastConfig::default(), start.clone()).unwrap();
            let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).unwrap();
            let config = OpenedConfig::new(50, Some(2));
            let mut opened = Opened::new(energy.clone(), map, config, 3).unwrap();
            let config = DescentConfig { beta: Some(1.0), ..DescentConfig::default() };
            let mut descent = Descent::new(energy, config, None, start).unwrap();
            let mut energies = Vec::new();
            for _ in 0..4 {
                energies.push(paper.step().unwrap().energy.to_bits());
                energies.push(fast.step().unwrap().energy.to_bits());
                energies.push(opened.step().unwrap().energy.to_bits());
                energies.push(descent.step().unwrap().0.energy.to_bits());
            }
            let all = [paper.phase(), fast.phase(), opened.phase(), descent.phase()].concat();
            (energies, all.iter().map(|u| u.to_bits()).collect::<Vec<_>>())
        })
    };
    assert_eq!(run(1), run(2));
}

/// Slabs of several planes and of one, each kind of edge, the same coefficients everywhere or not.
#[test]
fn slabs_do_not_change_a_gradient() {
    let shape @ [nz, ny, nx] = [17, 32, 36];
    let mut stream = stream(5, "slabs", 0);
    let u: Vec<f64> = (0..nz * ny * nx).map(|_| uniform(&mut stream) - 0.5).collect();
    for edges in [Edges::Periodic, Edges::Replicate, Edges::Free] {
        for oriented in [false, true] {
            let run = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let coefficients = CASES[2].coefficients.into();
                    let mut config = EnergyConfig::new(shape, 0.01, 0.02, coefficients);
                    config.edges = edges;
                    let [mu, one, none] = [0.5, 1.0, 0.0].map(Spatial::Uniform);
                    let theta = [one, none.clone(), none];
                    config.orientation = oriented.then_some(Orientation { mu, theta });
                    let mut gradient = vec![0.0; u.len()];
                    let energy = Energy::new(config).unwrap().value_and_gradient(&u, &mut gradient);
                    let bits: Vec<u64> = gradient.iter().map(|g| g.to_bits()).collect();
                    (energy.to_bits(), bits)
                })
            };
            let whole = run(1);
            // Two threads make slabs of 5, 5, 5 and 2 planes, three of 4, 4, 4, 4 and 1.
            assert!(whole == run(2), "{edges:?}, oriented {oriented}, 2 threads");
            assert!(whole == run(3), "{edges:?}, oriented {oriented}, 3 threads");
        }
    }
}
