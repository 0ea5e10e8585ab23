//! What holds for all data: boxes, symmetry, threads, saved states, refusals.

use super::*;
use proptest::prelude::*;

/// Slopes of both signs and all magnitudes, to feed a method that sees no function behind them.
fn slopes(count: usize) -> impl Strategy<Value = Vec<f64>> {
    let slope =
        (-3.0..3.0_f64, -3.0..3.0_f64).prop_map(|(s, exponent)| s * 10.0_f64.powf(exponent));
    prop::collection::vec(slope, count)
}

/// Positions in the box, f0 and df0, g, dg of one call.
fn call(n: usize, m: usize) -> impl Strategy<Value = (Vec<f64>, Values)> {
    let x = prop::collection::vec(0.0..=1.0_f64, n);
    let g = prop::collection::vec(-5.0..5.0_f64, m);
    (x, slopes(n), g, slopes(n * m)).prop_map(|(x, df0, g, dg)| (x, (1.0, df0, g, dg)))
}

/// A box, and three calls that are unrelated.
fn session() -> impl Strategy<Value = (Bounds, usize, Vec<(Vec<f64>, Values)>)> {
    (1..9_usize, 0..4_usize).prop_flat_map(|(n, m)| {
        let sides = prop::collection::vec((-5.0..5.0_f64, 0.01..10.0_f64), n);
        (sides, prop::collection::vec(call(n, m), 3)).prop_map(move |(sides, mut calls)| {
            let lower: Vec<f64> = sides.iter().map(|side| side.0).collect();
            let upper: Vec<f64> = sides.iter().map(|side| side.0 + side.1).collect();
            for (x, _) in &mut calls {
                for (j, x) in x.iter_mut().enumerate() {
                    *x = (lower[j] + *x * (upper[j] - lower[j])).min(upper[j]);
                }
            }
            (Bounds::new(lower, upper).unwrap(), m, calls)
        })
    })
}

fn standard(bounds: &Bounds, m: usize) -> Mma {
    Mma::new(bounds.clone(), Artificial::standard(m), MmaConfig::default()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn steps_stay_in_the_box_and_within_the_move_limit((bounds, m, calls) in session()) {
        let mut mma = standard(&bounds, m);
        for (x, (f0, df0, g, dg)) in &calls {
            let next = mma.step(x, *f0, df0, g, dg).unwrap();
            for j in 0..x.len() {
                let (lower, upper) = (bounds.lower()[j], bounds.upper()[j]);
                prop_assert!(next[j] >= lower && next[j] <= upper);
                prop_assert!((next[j] - x[j]).abs() <= 0.5 * (upper - lower) * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn variables_in_another_order_go_the_same_way((bounds, m, calls) in session()) {
        let n = bounds.len();
        let turned = |v: &[f64]| -> Vec<f64> { (0..n).map(|j| v[(j + n / 2) % n]).collect() };
        let rows = |v: &[f64]| -> Vec<f64> { v.chunks_exact(n).flat_map(turned).collect() };
        let (mut one, mut other) = (
            standard(&bounds, m),
            standard(&Bounds::new(turned(bounds.lower()), turned(bounds.upper())).unwrap(), m),
        );
        for (x, (f0, df0, g, dg)) in &calls {
            let a = turned(one.step(x, *f0, df0, g, dg).unwrap());
            let b = other.step(&turned(x), *f0, &turned(df0), g, &rows(dg)).unwrap();
            // Both are solutions to a tolerance that flat functions magnify.
            prop_assert!(distance(&a, b) < 1e-3, "{a:?} {b:?}");
        }
    }

    #[test]
    fn densities_stay_in_the_box(
        data in prop::collection::vec((0.0..=1.0_f64, -100.0..0.0_f64, 0.1..3.0_f64), 1..60),
        fraction in 0.01..0.99_f64,
        rules in 0..3_usize,
    ) {
        let config = [OcConfig::top99(), OcConfig::top88(), OcConfig::mechanism()][rules].clone();
        let column = |f: fn(&(f64, f64, f64)) -> f64| data.iter().map(f).collect::<Vec<_>>();
        let (x, dc, dv) = (column(|d| d.0), column(|d| d.1), column(|d| d.2));
        let target = fraction * x.len() as f64;
        let limit = config.move_limit;
        let bounds = Bounds::uniform(x.len(), 0.0, 1.0).unwrap();
        let mut oc = OptimalityCriteria::new(bounds, config).unwrap();
        let volume = |x: &[f64]| x.iter().sum::<f64>() - target;
        let next = oc.update(&x, &dc, Some(&dv), volume).unwrap().to_vec();
        for (next, x) in next.iter().zip(&x) {
            prop_assert!((0.0..=1.0).contains(next) && (next - x).abs() <= limit + 1e-15);
        }
        prop_assert_eq!(bits(oc.update_sum(&x, &dc, Some(&dv), target, volume).unwrap()), bits(&next));
    }
}

/// A smooth problem of many variables and two constraints.
fn wide(x: &[f64]) -> Values {
    let n = x.len() as f64;
    let weight = |j: usize| 1.0 + (j % 7) as f64;
    let all = || x.iter().enumerate();
    let f0 = all().map(|(j, x)| weight(j) / (0.1 + x)).sum::<f64>() / n;
    let df0 = all().map(|(j, x)| -weight(j) / (0.1 + x).powi(2) / n).collect();
    let mean = x.iter().sum::<f64>() / n - 0.4;
    let square = x.iter().map(|x| x * x).sum::<f64>() / n - 0.17;
    let dg = std::iter::repeat_n(1.0 / n, x.len()).chain(x.iter().map(|x| 2.0 * x / n)).collect();
    (f0, df0, vec![mean, square], dg)
}

fn wide_run(steps: usize) -> (Mma, Vec<f64>) {
    const N: usize = 9000;
    let (mut mma, mut x) = (standard(&Bounds::uniform(N, 0.0, 1.0).unwrap(), 2), vec![0.4; N]);
    for _ in 0..steps {
        let (f0, df0, g, dg) = wide(&x);
        x = mma.step(&x, f0, &df0, &g, &dg).unwrap().to_vec();
    }
    (mma, x)
}

#[test]
fn one_thread_and_three_give_the_same_bytes() {
    let [one, three] = [1, 3].map(|threads| with_threads(threads, || bits(&wide_run(6).1)));
    assert!(one == three);
}

#[test]
fn a_saved_state_goes_on_to_the_same_bytes() {
    let (mut mma, x) = wide_run(3);
    let text = toml::to_string(&mma).unwrap();
    let mut read: Mma = toml::from_str(&text).unwrap();
    let (f0, df0, g, dg) = wide(&x);
    let next = bits(mma.step(&x, f0, &df0, &g, &dg).unwrap());
    assert!(next == bits(read.step(&x, f0, &df0, &g, &dg).unwrap()));
    assert!(toml::to_string(&mma).unwrap() == toml::to_string(&read).unwrap());
    let error = toml::from_str::<Mma>(&text.replacen("steps", "stops", 1)).unwrap_err();
    assert!(error.to_string().contains("stops"), "{error}");
}

#[test]
fn a_state_saved_between_trials_goes_on_to_the_same_bytes() {
    let bounds = Bounds::uniform(5, 1.0, 10.0).unwrap();
    let mut gcmma = Gcmma::new(bounds, Artificial::standard(1), GcmmaConfig::default()).unwrap();
    let (f0, df0, g, dg) = beam(&[5.0; 5]);
    gcmma.propose(&[5.0; 5], f0, &df0, &g, &dg).unwrap();
    let mut read: Gcmma = toml::from_str(&toml::to_string(&gcmma).unwrap()).unwrap();
    let (f0, _, g, _) = beam(gcmma.trial().unwrap());
    assert_eq!(gcmma.accept(f0, &g).unwrap(), Verdict::Tighten);
    assert_eq!(read.accept(f0, &g).unwrap(), Verdict::Tighten);
    assert_eq!(bits(gcmma.trial().unwrap()), bits(read.trial().unwrap()));
    assert_eq!(toml::to_string(&gcmma).unwrap(), toml::to_string(&read).unwrap());
    let oc = OptimalityCriteria::new(Bounds::uniform(2, 0.0, 1.0).unwrap(), OcConfig::top99());
    let text = toml::to_string(&oc.unwrap()).unwrap();
    let read: OptimalityCriteria = toml::from_str(&text).unwrap();
    assert_eq!(toml::to_string(&read).unwrap(), text);
    let crossed = text.replacen("lower = [0.0, 0.0]", "lower = [0.0, 2.0]", 1);
    let error = toml::from_str::<OptimalityCriteria>(&crossed).unwrap_err().to_string();
    assert!(error.contains("bounds of variable 1 are crossed"), "{error}");
}

#[test]
fn bad_input_is_named_and_leaves_the_state() {
    let mut mma = standard(&Bounds::uniform(3, 0.0, 1.0).unwrap(), 2);
    let x = [0.5; 3];
    let mut refused = |x: &[f64], f0: f64, df0: &[f64], g: &[f64], dg: &[f64]| {
        let message = mma.step(x, f0, df0, g, dg).unwrap_err().to_string();
        assert_eq!(mma.steps(), 0);
        message
    };
    let (g, dg) = ([0.0; 2], [1.0; 6]);
    let found = refused(&x, 0.0, &[0.0, f64::NAN, 0.0], &g, &dg);
    assert_eq!(found, "df0[1] is NaN, which is not finite");
    let mut bad = dg;
    bad[4] = f64::NEG_INFINITY;
    assert_eq!(refused(&x, 0.0, &x, &g, &bad), "dg[1, 1] is -inf, which is not finite");
    assert_eq!(refused(&x, f64::NAN, &x, &g, &dg), "f0 is NaN, which is not finite");
    assert_eq!(refused(&x, 0.0, &x, &[0.0], &dg), "g has shape [1], expected [2]");
    assert_eq!(refused(&x, 0.0, &[0.0; 4], &g, &dg), "df0 has shape [4], expected [3]");
    let found = refused(&x, 0.0, &x, &g, &[1.0; 5]);
    assert_eq!(found, "dg (constraints times variables) has shape [5], expected [6]");
    let found = refused(&[0.5, 0.5, -0.1], 0.0, &x, &g, &dg);
    assert_eq!(found, "x[2] = -0.1 is outside its range [0, 1]");
    let bounds = Bounds::uniform(1, 0.0, 1.0).unwrap();
    let costs = Artificial { c: vec![0.0], d: vec![0.0], ..Artificial::standard(1) };
    assert!(Mma::new(bounds.clone(), costs, MmaConfig::default()).is_err());
    let config = MmaConfig { tolerance: 0.0, ..MmaConfig::default() };
    assert!(Mma::new(bounds, Artificial::standard(1), config).is_err());
}
