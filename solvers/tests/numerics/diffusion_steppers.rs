//! Time steppers: observed orders, exact solutions, conservation, fronts.

use solvers::diffusion::{
    Diffusivity, Etdrk4, Etdrk4Config, Euler, FaceMean, ImexScheme, Operator, Reaction,
    SemiImplicit, SemiImplicitConfig, Tensor,
};
use solvers::expression::FormulaReaction;
use solvers::order::observed_order;
use solvers::spectral::{LaplacianSymbol, LinearPart, RadialSpectrum, Window};
use solvers::{Boundary, Field, Grid, random};
use std::f64::consts::{PI, TAU};

/// A reaction of `S` species that is the same everywhere.
struct Rates<const S: usize, F>(F);

impl<const S: usize, F: Fn([f64; S]) -> [f64; S] + Sync> Reaction for Rates<S, F> {
    fn species(&self) -> usize {
        S
    }

    fn rates(&self, _: usize, u: &[&[f64]], rates: &mut [&mut [f64]]) {
        for i in 0..u[0].len() {
            let f = (self.0)(std::array::from_fn(|s| u[s][i]));
            (0..S).for_each(|s| rates[s][i] = f[s]);
        }
    }
}

fn nothing() -> impl Reaction {
    Rates(|_: [f64; 1]| [0.0])
}

/// Brusselator, stable oscillation: nonlinear in both species.
fn brusselator() -> impl Reaction {
    Rates(|[u, v]: [f64; 2]| [1.0 - 4.0 * u + u * u * v, 3.0 * u - u * u * v])
}

fn etd(dt: f64) -> Etdrk4Config {
    Etdrk4Config { dt, laplacian: LaplacianSymbol::Continuous, dealias: false }
}

fn imex(dt: f64, scheme: ImexScheme, laplacian: LaplacianSymbol) -> SemiImplicitConfig {
    SemiImplicitConfig { dt, scheme, laplacian }
}

fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn noise(grid: Grid, mean: f64, size: f64) -> Vec<f64> {
    let mut stream = random::stream(6, "start", 0);
    (0..grid.len()).map(|_| mean + size * random::normal(&mut stream)).collect()
}

/// A smooth start of both species, periodic and even about the borders' faces.
fn smooth(grid: Grid) -> Vec<Vec<f64>> {
    let h = grid.spacing();
    let wave = |[x, y, _]: [f64; 3]| (x + 0.5 * h).cos() * (y + 0.5 * h).cos();
    let u = Field::from_fn(grid, |p| 1.0 + 0.3 * wave(p));
    let v = Field::from_fn(grid, |p| 3.0 - 0.4 * wave(p).powi(2));
    vec![u.as_slice().to_vec(), v.as_slice().to_vec()]
}

fn brusselator_etd(steps: usize, boundary: Boundary) -> Vec<f64> {
    let grid = Grid::new(&[16, 16], TAU / 16.0).unwrap();
    let parts = [LinearPart::diffusion(0.3), LinearPart::diffusion(0.1)];
    let mut stepper = Etdrk4::new(grid, boundary, &parts, etd(1.0 / steps as f64)).unwrap();
    let mut u = smooth(grid);
    (0..steps).for_each(|_| stepper.step(&brusselator(), &mut u).unwrap());
    u.concat()
}

#[test]
fn etdrk4_is_of_fourth_order() {
    for boundary in [Boundary::Periodic, Boundary::Neumann] {
        let reference = brusselator_etd(2048, boundary);
        let error = |n| largest(&brusselator_etd(n, boundary), &reference);
        let order = observed_order(&[16, 32, 64, 128], error);
        println!("ETDRK4, {boundary:?}: order {order:.3}, error {:.1e} at dt = 1/128", error(128));
        assert!((order - 4.0).abs() < 0.2, "{order}");
    }
}

/// On even data the two series solve the same problem.
#[test]
fn fourier_and_cosine_series_agree_on_even_data() {
    let difference =
        largest(&brusselator_etd(64, Boundary::Periodic), &brusselator_etd(64, Boundary::Neumann));
    // The data are even and periodic at once. Round-off of 64 steps.
    assert!(difference < 1e-13, "{difference:e}");
}

/// `exp(L t)` in one step of any length, in 1D, 2D and 3D.
#[test]
fn etdrk4_is_exact_without_a_reaction() {
    for shape in [&[32][..], &[16, 32], &[8, 16, 32]] {
        let grid = Grid::new(shape, TAU / 32.0).unwrap();
        let wave = |[x, y, _]: [f64; 3]| (3.0 * x + 0.2).sin() * (2.0 * y).cos();
        let mut u = vec![Field::from_fn(grid, wave).as_slice().to_vec()];
        let start = u[0].clone();
        let symbol = if shape.len() == 1 { 9.0 } else { 13.0 };
        let part = [LinearPart::diffusion(0.1)];
        let mut stepper = Etdrk4::new(grid, Boundary::Periodic, &part, etd(2.0)).unwrap();
        stepper.step(&nothing(), &mut u).unwrap();
        let factor = (-0.1_f64 * symbol * 2.0).exp();
        let exact: Vec<f64> = start.iter().map(|u| u * factor).collect();
        assert!(largest(&u[0], &exact) < 1e-15, "{shape:?}");
    }
}

/// Swift-Hohenberg's energy `mean(-r u^2/2 + u^4/4 + ((1 + lap) u)^2/2)` never rises, and
/// the roll's amplitude is `2 sqrt(r/3)` to first order in r.
#[test]
fn swift_hohenberg_lowers_its_energy() {
    let r = 0.1;
    let n = 64;
    let grid = Grid::new(&[n, n], 8.0 * TAU / n as f64).unwrap();
    let cubic = Rates(|[u]: [f64; 1]| [-u * u * u]);
    let part = [LinearPart::new(move |s| r - (1.0 - s) * (1.0 - s))];
    let mut stepper = Etdrk4::new(grid, Boundary::Periodic, &part, etd(0.5)).unwrap();
    let mut transform = solvers::spectral::Transform::new(grid, Boundary::Periodic).unwrap();
    let gap = transform.map_modes(|k| 1.0 - LaplacianSymbol::Continuous.at(k, 1.0));
    let (mut modes, mut curved) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
    let mut energy = |u: &[f64]| {
        transform.forward(u, &mut modes);
        modes.iter_mut().zip(&gap).for_each(|(m, g)| *m *= g);
        transform.inverse(&mut modes, &mut curved);
        let density = |(u, c): (&f64, &f64)| 0.25 * u.powi(4) + 0.5 * (c * c - r * u * u);
        u.iter().zip(&curved).map(density).sum::<f64>() / u.len() as f64
    };
    let mut u = vec![noise(grid, 0.0, 0.1)];
    let mut last = energy(&u[0]);
    for _ in 0..400 {
        stepper.step(&cubic, &mut u).unwrap();
        let next = energy(&u[0]);
        // Once at rest, only round-off is left.
        assert!(next <= last + 1e-15, "{next} after {last}");
        last = next;
    }
    let mut u = vec![Field::from_fn(grid, |[x, ..]| 0.3 * x.cos()).as_slice().to_vec()];
    (0..200).for_each(|_| stepper.step(&cubic, &mut u).unwrap());
    let amplitude = u[0].iter().fold(0.0, |m: f64, u| m.max(u.abs()));
    println!("Swift-Hohenberg: energy {last:.6}, amplitude {amplitude:.5}");
    // The third harmonic is A^3/4/64, 1 % of A^3/4 = 0.012: 2e-4.
    assert!((amplitude - 2.0 * (r / 3.0_f64).sqrt()).abs() < 2e-3, "{amplitude}");
}

/// Allen-Cahn `u_t = u_xx + u (1 - u)(u - a)`: a front moves at `(1 - 2a)/sqrt 2`.
#[test]
fn bistable_front_moves_at_its_exact_speed() {
    let a = 0.2;
    let n = 256;
    let grid = Grid::new(&[n], 0.25).unwrap();
    let cubic = Rates(move |[u]: [f64; 1]| [u * (1.0 - u) * (u - a)]);
    let front = Field::from_fn(grid, |[x, ..]| 1.0 / (1.0 + ((x - 16.0) / 2.0_f64.sqrt()).exp()));
    let place = |u: &[f64]| u.iter().sum::<f64>() * 0.25;
    let exact = (1.0 - 2.0 * a) / 2.0_f64.sqrt();
    let mut u = vec![front.as_slice().to_vec()];
    let part = [LinearPart::diffusion(1.0)];
    let mut stepper = Etdrk4::new(grid, Boundary::Neumann, &part, etd(0.1)).unwrap();
    let start = place(&u[0]);
    (0..200).for_each(|_| stepper.step(&cubic, &mut u).unwrap());
    let speed = (place(&u[0]) - start) / 20.0;
    println!("bistable front: speed {speed:.9}, exact {exact:.9}");
    // The tails at the borders, exp(-16/sqrt 2) = 1e-5, move the mass by 1e-5 x 0.25/20.
    assert!((speed - exact).abs() < 3e-6);
}

/// Truncated to 2/3, a product has no aliases: u^2 of the highest kept wave adds nothing to low ones.
#[test]
fn dealiasing_removes_aliases() {
    let n = 48;
    let grid = Grid::new(&[n], TAU / n as f64).unwrap();
    let square = Rates(|[u]: [f64; 1]| [u * u]);
    let part = [LinearPart::diffusion(0.0)];
    let alias = |dealias| {
        let config = Etdrk4Config { dealias, ..etd(0.01) };
        let mut stepper = Etdrk4::new(grid, Boundary::Periodic, &part, config).unwrap();
        let start = Field::from_fn(grid, |[x, ..]| (15.0 * x).cos());
        let mut u = vec![start.as_slice().to_vec()];
        stepper.step(&square, &mut u).unwrap();
        // Twice 15 waves look like 18.
        let wave = |i: usize| (18.0 * grid.position(i)[0]).cos();
        (0..n).map(|i| u[0][i] * wave(i)).sum::<f64>().abs()
    };
    assert!(alias(false) > 0.05 && alias(true) < 1e-13, "{} {}", alias(false), alias(true));
}

/// Turing's system at its published parameters, growing from the noise of xi: the
/// measured wave is linear theory's on this grid, s(k) = 1/2 at k = 2 asin(sqrt(1/8)), while
/// growth is linear. (Once saturated, spots pack closer: 8.4.)
#[test]
fn turing_pattern_grows_with_the_predicted_wavelength() {
    const S: f64 = 0.03125;
    struct Turing(Vec<f64>);
    impl Reaction for Turing {
        fn species(&self) -> usize {
            2
        }

        fn rates(&self, first: usize, u: &[&[f64]], rates: &mut [&mut [f64]]) {
            for i in 0..u[0].len() {
                let (a, b) = (u[0][i], u[1][i]);
                rates[0][i] = S * (16.0 - a * b);
                rates[1][i] = S * (a * b - b - self.0[first + i]);
            }
        }
    }
    let grid = Grid::new(&[256, 256], 1.0).unwrap();
    let mut stream = random::stream(0, "xi", 0);
    let xi = (0..grid.len()).map(|n| {
        let [_, j, i] = grid.node(n);
        let moved = j.is_multiple_of(2) && i.is_multiple_of(2);
        if moved { 11.5 + random::uniform(&mut stream) } else { 12.0 }
    });
    let turing = Turing(xi.collect());
    let mut u = vec![vec![4.0; grid.len()], vec![4.0; grid.len()]];
    let parts = [LinearPart::diffusion(0.25), LinearPart::diffusion(0.0625)];
    let config = Etdrk4Config { laplacian: LaplacianSymbol::Isotropic, ..etd(4.0) };
    let mut stepper = Etdrk4::new(grid, Boundary::Neumann, &parts, config).unwrap();
    for _ in 0..100 {
        stepper.step(&turing, &mut u).unwrap();
        u.iter_mut().flatten().for_each(|u| *u = u.max(0.0));
    }
    let field = Field::from_vec(grid, u[1].clone()).unwrap();
    for (boundary, window) in
        [(Boundary::Neumann, Window::None), (Boundary::Periodic, Window::Hann)]
    {
        let spectrum = RadialSpectrum::new(&field, boundary, window).unwrap();
        let wavelength = spectrum.peak_wavelength().unwrap();
        println!(
            "Turing at t = 400, {boundary:?} series: wavelength {wavelength:.3}, theory 8.694"
        );
        assert!((wavelength / 8.694 - 1.0).abs() < 0.02, "{wavelength}");
    }
}

fn brusselator_imex(steps: usize, scheme: ImexScheme, map: bool) -> Vec<f64> {
    let grid = Grid::new(&[12, 16], TAU / 16.0).unwrap();
    let values = Field::from_fn(grid, |[x, ..]| 0.3 + 0.2 * x.sin());
    let first = match map {
        true => Diffusivity::Map { values, mean: FaceMean::Harmonic },
        false => Diffusivity::Constant(0.3),
    };
    let config = imex(1.0 / steps as f64, scheme, LaplacianSymbol::Isotropic);
    let diffusion = [first, Diffusivity::Constant(0.1)];
    let mut stepper = SemiImplicit::new(grid, Boundary::Neumann, &diffusion, config).unwrap();
    let mut u = smooth(grid);
    (0..steps).for_each(|_| stepper.step(&brusselator(), &mut u).unwrap());
    u.concat()
}

#[test]
fn imex_schemes_have_their_orders() {
    for (scheme, wanted) in [(ImexScheme::Euler, 1.0), (ImexScheme::Ars222, 2.0)] {
        for map in [false, true] {
            let reference = brusselator_imex(4096, ImexScheme::Ars222, map);
            let error = |n| largest(&brusselator_imex(n, scheme, map), &reference);
            let order = observed_order(&[32, 64, 128], error);
            println!("{scheme:?}, map {map}: order {order:.3}, error {:.1e} at 1/128", error(128));
            assert!((order - wanted).abs() < 0.1, "{order}");
        }
    }
}

/// Cosine modes decay by the scheme's own stability function of the stencil's symbol,
/// and by exp(-D s t) as dt goes to 0.
#[test]
fn cosine_modes_decay_at_the_exact_rate() {
    let grid = Grid::new(&[10, 14], 0.5).unwrap();
    let k = [3.0 * PI / 7.0, 2.0 * PI / 5.0, 0.0];
    let mode =
        Field::from_fn(grid, |[x, y, _]| (k[0] * (x + 0.25)).cos() * (k[1] * (y + 0.25)).cos());
    for laplacian in
        [LaplacianSymbol::Axes, LaplacianSymbol::Isotropic, LaplacianSymbol::Continuous]
    {
        let s = laplacian.at(k, 0.5);
        let decay = |steps: usize, scheme| {
            let config = imex(1.0 / steps as f64, scheme, laplacian);
            let d = [Diffusivity::Constant(0.2)];
            let mut stepper = SemiImplicit::new(grid, Boundary::Neumann, &d, config).unwrap();
            let mut u = vec![mode.as_slice().to_vec()];
            (0..steps).for_each(|_| stepper.step(&nothing(), &mut u).unwrap());
            u[0][0] / mode.as_slice()[0]
        };
        let z = -0.2 * s / 4.0;
        assert!((decay(4, ImexScheme::Euler) - (1.0 - z).powi(-4)).abs() < 1e-14);
        let gamma = 1.0 - 0.5_f64.sqrt();
        let stability = (1.0 + (1.0 - 2.0 * gamma) * z) / (1.0 - gamma * z).powi(2);
        assert!((decay(4, ImexScheme::Ars222) - stability.powi(4)).abs() < 1e-14);
        let exact = (-0.2 * s).exp();
        let order =
            observed_order(&[64, 128, 256], |n| (decay(n, ImexScheme::Ars222) - exact).abs());
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }
}

/// The sparse factor and the series solve the same equation.
#[test]
fn cholesky_and_series_agree() {
    for shape in [&[40][..], &[20, 24], &[6, 8, 7]] {
        for boundary in [Boundary::Periodic, Boundary::Neumann] {
            for scheme in [ImexScheme::Euler, ImexScheme::Ars222] {
                let grid = Grid::new(shape, 0.5).unwrap();
                let constant = Diffusivity::Constant(0.7);
                let values = Field::constant(grid, 0.7);
                let tensor = Tensor { xx: 0.7, yy: 0.7, zz: 0.7, ..Tensor::default() };
                let others = [
                    Diffusivity::Map { values, mean: FaceMean::Harmonic },
                    Diffusivity::Tensor(vec![tensor]),
                ];
                let run = |d: &Diffusivity| {
                    let config = imex(3.0, scheme, LaplacianSymbol::Axes);
                    let d = [d.clone()];
                    let mut stepper = SemiImplicit::new(grid, boundary, &d, config).unwrap();
                    let mut u = vec![noise(grid, 0.0, 1.0)];
                    let growth = Rates(|[u]: [f64; 1]| [0.1 * (u - u * u * u)]);
                    (0..3).for_each(|_| stepper.step(&growth, &mut u).unwrap());
                    (u.concat(), stepper.describe())
                };
                let (series, name) = run(&constant);
                assert_eq!(name, "species 0: linear part by series");
                for other in &others {
                    let (factor, name) = run(other);
                    assert!(name.starts_with("species 0: sparse Cholesky, "), "{name}");
                    let difference = largest(&series, &factor);
                    assert!(difference < 1e-12, "{shape:?} {boundary:?} {difference:e}");
                }
            }
        }
    }
}

/// Any dt: no growth, no loss of mass, and in the end a constant.
#[test]
fn large_steps_are_stable_and_conservative() {
    let grid = Grid::new(&[24, 20], 1.0).unwrap();
    let values = Field::from_fn(grid, |[x, y, _]| 1.5 + (0.5 * x).sin() * (0.4 * y).cos());
    let map = Diffusivity::Map { values, mean: FaceMean::Harmonic };
    let tensor = Diffusivity::Tensor(vec![Tensor::rotated(4.0, 0.1, 0.6)]);
    for boundary in [Boundary::Periodic, Boundary::Neumann] {
        for diffusivity in [Diffusivity::Constant(2.0), map.clone(), tensor.clone()] {
            for scheme in [ImexScheme::Euler, ImexScheme::Ars222] {
                let config = imex(1e5, scheme, LaplacianSymbol::Isotropic);
                let d = [diffusivity.clone()];
                let mut stepper = SemiImplicit::new(grid, boundary, &d, config).unwrap();
                let mut u = vec![noise(grid, 1.0, 0.5)];
                let start = u[0].clone();
                let mass: f64 = start.iter().sum();
                let mut norm = f64::INFINITY;
                for _ in 0..10 {
                    stepper.step(&nothing(), &mut u).unwrap();
                    let next = u[0].iter().map(|u| u * u).sum::<f64>();
                    assert!(next <= norm * (1.0 + 1e-13), "{next} after {norm}");
                    norm = next;
                }
                let mean = mass / grid.len() as f64;
                let spread = u[0].iter().map(|u| (u - mean).abs()).fold(0.0, f64::max);
                // Ten steps; all nodes of a constant field round alike, by a few last places.
                let change: f64 = u[0].iter().zip(&start).map(|(u, start)| u - start).sum();
                assert!(change.abs() < 1e-14 * mass, "{scheme:?} {boundary:?} {change:e}");
                assert!(spread < 1e-9, "{scheme:?} {boundary:?} {spread:e}");
            }
        }
    }
}

/// The Brusselator of [`brusselator`] as formulas.
fn formulas() -> FormulaReaction {
    let species = [("u", "1 - 4*u + u^2*v"), ("v", "3*u - u^2*v")];
    FormulaReaction::new(&species, &[]).unwrap()
}

/// Forward Euler of maps, to the bit of the formula it stands for, on several chunks.
#[test]
fn explicit_steps_are_those_of_their_formula() {
    let grid = Grid::new(&[90, 130], 1.0).unwrap();
    let values = Field::from_fn(grid, |[x, y, _]| 1.5 + (0.5 * x).sin() * (0.4 * y).cos());
    let d = [Diffusivity::Map { values, mean: FaceMean::Harmonic }, Diffusivity::Constant(0.2)];
    let mut stepper = Euler::new(grid, Boundary::Neumann, &d, 0.02).unwrap();
    assert!(0.02 * stepper.max_rate() < 2.0);
    let mut u = vec![noise(grid, 1.0, 0.1), noise(grid, 3.0, 0.1)];
    let start = u.clone();
    stepper.scale_laplacian(0.5);
    stepper.step(&brusselator(), &mut u).unwrap();
    let mut spread = vec![0.0; grid.len()];
    for s in 0..2 {
        Operator::new(grid, Boundary::Neumann, &d[s]).unwrap().apply(&start[s], &mut spread);
        for n in 0..grid.len() {
            let (a, b) = (start[0][n], start[1][n]);
            let f = [1.0 - 4.0 * a + a * a * b, 3.0 * a - a * a * b][s];
            assert_eq!(u[s][n], start[s][n] + 0.02 * (f + 0.5 * spread[n]));
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let grid = Grid::new(&[70, 90], 0.5).unwrap();
            let parts = [LinearPart::diffusion(0.3), LinearPart::diffusion(0.1)];
            let mut exponential = Etdrk4::new(grid, Boundary::Neumann, &parts, etd(0.05)).unwrap();
            let d = [
                Diffusivity::Constant(0.3),
                Diffusivity::Tensor(vec![Tensor::rotated(1.0, 0.2, 0.3)]),
            ];
            let config = imex(0.05, ImexScheme::Ars222, LaplacianSymbol::Axes);
            let mut implicit = SemiImplicit::new(grid, Boundary::Periodic, &d, config).unwrap();
            let mut u = vec![noise(grid, 1.0, 0.1), noise(grid, 3.0, 0.1)];
            let mut explicit = Euler::new(grid, Boundary::Periodic, &d, 0.01).unwrap();
            for _ in 0..3 {
                explicit.step(&formulas(), &mut u).unwrap();
                exponential.step(&brusselator(), &mut u).unwrap();
                implicit.step(&brusselator(), &mut u).unwrap();
            }
            u.concat().iter().map(|u| u.to_bits()).collect::<Vec<_>>()
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn misfits_are_refused() {
    let grid = Grid::new(&[8], 1.0).unwrap();
    let part = [LinearPart::diffusion(1.0)];
    let new = |boundary, dt| Etdrk4::new(grid, boundary, &part, etd(dt)).map_err(|e| e.to_string());
    assert!(new(Boundary::Periodic, -1.0).unwrap_err().starts_with("dt = -1 is outside"));
    assert!(new(Boundary::Extrapolate, 1.0).unwrap_err().contains("not extrapolation"));
    let mut stepper = new(Boundary::Periodic, 1.0).unwrap();
    let error = stepper.step(&nothing(), &mut [vec![0.0; 7]]).unwrap_err().to_string();
    assert_eq!(error, "concentration of species 0 has shape [7], expected [8]");
    let error = stepper.step(&brusselator(), &mut [vec![0.0; 8]]).unwrap_err().to_string();
    assert_eq!(error, "species of the reaction has shape [2], expected [1]");
}
