#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::*;
use LaplacianSymbol::{Axes, Continuous, Isotropic};

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

fn diffusion<const S: usize>(d: [f64; S]) -> Vec<LinearPart> {
    d.map(LinearPart::diffusion).to_vec()
}

fn turing(xi: f64) -> impl Reaction {
    const S: f64 = 0.03125;
    Rates(move |[a, b]: [f64; 2]| [S * (16.0 - a * b), S * (a * b - b - xi)])
}

/// Turing's system with the published parameters stands exactly on its threshold.
#[test]
fn turings_parameters_are_marginal() {
    let state = steady_state(&turing(12.0), 0, &[3.0, 5.0]).unwrap();
    assert!(state.converged && (state.u[0] - 4.0).abs() < 1e-12, "{state:?}");
    let linear =
        Linearization::new(&turing(12.0), 0, &[4.0, 4.0], &diffusion([0.25, 0.0625])).unwrap();
    // All numbers are short binary fractions and the rates are bilinear: only the eigenvalues round.
    assert_eq!(linear.jacobian().as_slice(), [-0.125, 0.125, -0.125, 0.09375]);
    assert!(linear.growth(0.5).growth.abs() < 1e-16, "{:e}", linear.growth(0.5).growth);
    let most = linear.most_unstable(8.0);
    println!("Turing: {most:?}");
    assert_eq!(most.kind, Instability::Turing);
    // The maximum is flat: its place is known to the square root of round-off, 1e-8.
    assert!((most.symbol - 0.5).abs() < 1e-6);
    let k = most.symbol.sqrt();
    assert!((k - 0.5_f64.sqrt()).abs() < 1e-6);
    let continuum = most.axis_wavelength(Continuous, 1.0).unwrap();
    assert!((continuum - 8.885_765_876).abs() < 1e-5, "{continuum}");
    // 2 sin(k/2) = sqrt(1/2).
    let along = most.axis_wavelength(Axes, 1.0).unwrap();
    assert!((along - PI / (0.125_f64.sqrt()).asin()).abs() < 1e-5 && (along - 8.694).abs() < 1e-3);
    assert!((most.axis_wavelength(Isotropic, 1.0).unwrap() - along).abs() < 1e-12);
    let mean = [Axes, Isotropic].map(|l| most.mean_wavelength(l, 1.0, 2).unwrap());
    println!("wavelength: continuum {continuum:.4}, axis {along:.4}, mean {mean:.4?}");
    // To order h^2 k^4 the isotropic stencil is the same in all directions, k^4/12;
    // the other's symbol is higher along the diagonal, so its mean wave is longer.
    assert!((mean[1] - along).abs() < 0.01 && mean[0] > along + 0.03, "{mean:?}");
}

/// The state is b = 16 - xi, a = 16/b, with trace `s (a - b - 1)`: at xi = 13 that is above
/// 0, so the homogeneous state oscillates besides.
#[test]
fn xi_decides_between_rest_pattern_and_oscillation() {
    use Instability::{Hopf, Stable, Turing};
    for (xi, kind) in [(11.9, Stable), (12.2, Turing), (13.0, Hopf)] {
        let u = steady_state(&turing(xi), 0, &[4.0, 4.0]).unwrap().u;
        let linear = Linearization::new(&turing(xi), 0, &u, &diffusion([0.25, 0.0625])).unwrap();
        assert_eq!(linear.most_unstable(8.0).kind, kind, "xi = {xi}");
    }
}

/// Schnakenberg `a - u + u^2 v, b - u^2 v`: u* = a + b, v* = b/u*^2, and at threshold
/// `s_c = (D_v f_u + D_u g_v) / (2 D_u D_v) = sqrt(det J / (D_u D_v))`.
#[test]
fn schnakenberg_in_closed_form() {
    let (a, b, du) = (0.1, 0.9, 1.0);
    let kinetics = Rates(|[u, v]: [f64; 2]| [a - u + u * u * v, b - u * u * v]);
    let state = steady_state(&kinetics, 0, &[0.7, 1.2]).unwrap();
    assert!((state.u[0] - 1.0).abs() < 1e-12 && (state.u[1] - 0.9).abs() < 1e-12, "{state:?}");
    let (fu, fv, gu, gv) = (2.0 * 0.9 - 1.0, 1.0, -1.8, -1.0);
    let determinant: f64 = fu * gv - fv * gu;
    // D_v f_u + D_u g_v = 2 sqrt(D_u D_v det J), a quadratic in sqrt(D_v).
    let root = (determinant.sqrt() + (determinant - fu * gv).sqrt()) / fu;
    let dv = du * root * root;
    let linear = Linearization::new(&kinetics, 0, &state.u, &diffusion([du, dv])).unwrap();
    let most = linear.most_unstable(4.0);
    println!("Schnakenberg: D_v = {dv:.6}, {most:?}");
    // Differences of a quartic in u are exact to their round-off, 1e-13.
    assert!(most.growth.abs() < 1e-12, "{:e}", most.growth);
    assert!((most.symbol - (determinant / (du * dv)).sqrt()).abs() < 1e-6);
}

/// Brusselator `A - (B + 1) u + u^2 v, B u - u^2 v`: Turing threshold
/// `B_T = (1 + A sqrt(D_u/D_v))^2` at `s_c = A / sqrt(D_u D_v)`, Hopf at `B = 1 + A^2`
/// with frequency A.
#[test]
fn brusselator_in_closed_form() {
    let (a, du, dv): (f64, f64, f64) = (3.0, 5.0, 12.0);
    let at = |b: f64, d: [f64; 2]| {
        let kinetics =
            Rates(move |[u, v]: [f64; 2]| [a - (b + 1.0) * u + u * u * v, b * u - u * u * v]);
        let state = steady_state(&kinetics, 0, &[2.0, 2.0]).unwrap();
        assert!((state.u[0] - a).abs() < 1e-11 && (state.u[1] - b / a).abs() < 1e-11);
        Linearization::new(&kinetics, 0, &state.u, &diffusion(d)).unwrap()
    };
    let threshold = (1.0 + a * (du / dv).sqrt()).powi(2);
    let most = at(threshold, [du, dv]).most_unstable(4.0);
    println!("Brusselator: B_T = {threshold:.6}, {most:?}");
    assert!(most.growth.abs() < 1e-11, "{:e}", most.growth);
    assert!((most.symbol - a / (du * dv).sqrt()).abs() < 1e-6);
    assert_eq!(at(threshold * 1.01, [du, dv]).most_unstable(4.0).kind, Instability::Turing);
    let hopf = at((1.0 + a * a) * 1.0001, [1.0, 1.0]).most_unstable(4.0);
    assert_eq!((hopf.kind, hopf.symbol), (Instability::Hopf, 0.0));
    assert!((hopf.frequency - a).abs() < 1e-3);
}

/// Swift-Hohenberg about u = 0: sigma(k) = r - (1 - k^2)^2, so k* = 1 and sigma* = r.
#[test]
fn swift_hohenberg_grows_at_its_parameter() {
    let r = 0.2;
    let cubic = Rates(|[u]: [f64; 1]| [-u * u * u]);
    let part = [LinearPart::new(move |s| r - (1.0 - s) * (1.0 - s))];
    let linear = Linearization::new(&cubic, 0, &[0.0], &part).unwrap();
    let most = linear.most_unstable(9.0);
    assert!((most.symbol - 1.0).abs() < 1e-6 && (most.growth - r).abs() < 1e-12, "{most:?}");
    let k = [0.0, 0.5, 1.0, 1.5];
    let curve = linear.dispersion(Continuous, 1.0, &k);
    for (k, growth) in k.into_iter().zip(curve.growth) {
        assert!((growth - (r - (1.0 - k * k).powi(2))).abs() < 1e-12);
    }
}

#[test]
fn no_root_is_a_status() {
    let state = steady_state(&Rates(|[u]: [f64; 1]| [1.0 + u * u]), 0, &[0.3]).unwrap();
    assert!(!state.converged && state.residual >= 1.0, "{state:?}");
    assert!(steady_state(&turing(12.0), 0, &[4.0]).is_err());
}
