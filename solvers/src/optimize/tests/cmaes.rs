use crate::optimize::Cmaes;

/// Evaluations until `f` is below `target` from (0.5, ..), sigma 0.3; the median of 11 seeds.
fn evaluations(n: usize, target: f64, f: impl Fn(&[f64]) -> f64) -> usize {
    let mut counts: Vec<usize> = (0..11)
        .map(|seed| {
            let mut search = Cmaes::new(&vec![0.5; n], 0.3, seed).unwrap();
            let mut count = 0;
            while search.best().is_none_or(|(_, value)| value > target) {
                let points = search.ask();
                count += points.len();
                let values: Vec<f64> = points.iter().map(|x| f(x)).collect();
                search.tell(&values).unwrap();
                assert!(count < 100_000, "no end");
            }
            count
        })
        .collect();
    counts.sort_unstable();
    counts[5]
}

fn ellipsoid(x: &[f64]) -> f64 {
    let n = x.len() as f64 - 1.0;
    x.iter().enumerate().map(|(i, x)| 10.0_f64.powf(6.0 * i as f64 / n) * x * x).sum()
}

fn rosenbrock(x: &[f64]) -> f64 {
    x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
}

#[test]
fn the_sphere_falls_at_a_constant_rate() {
    // Linear convergence: every ten decades of f cost the same number of evaluations.
    let sphere = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
    let [a, b, c] = [1e-5, 1e-15, 1e-25].map(|target| evaluations(8, target, sphere) as f64);
    let ratio = (c - b) / (b - a);
    assert!((ratio - 1.0).abs() < 0.1, "{a} {b} {c}");
}

#[test]
fn the_shape_is_learnt() {
    // Without C, evaluations grow with the condition number, here 1e6 (more than 1e5).
    let stretched = evaluations(8, 1e-10, ellipsoid);
    assert!(stretched < 8000, "{stretched}");
    let valley = evaluations(8, 1e-10, rosenbrock);
    assert!(valley < 12_000, "{valley}");
}

#[test]
fn a_rotation_changes_little() {
    // Invariance: the ellipsoid along the diagonals costs what it costs along the axes.
    let straight = evaluations(2, 1e-10, ellipsoid) as f64;
    let turned = evaluations(2, 1e-10, |x| {
        let s = 0.5_f64.sqrt();
        ellipsoid(&[s * (x[0] + x[1]), s * (x[0] - x[1])])
    }) as f64;
    assert!((turned / straight).ln().abs() < 0.4, "{straight} {turned}");
}

/// A coordinate that is rounded to whole numbers, coupled to one that is not: a search that has
/// become narrow rests at a wrong number.
#[test]
fn a_rounded_coordinate_keeps_moving() {
    let f = |x: &[f64]| {
        let whole = (10.0 * x[0]).round();
        (x[1] - 0.1 * whole).powi(2) * 25.0 + (whole - 7.0).abs()
    };
    let found = |least: f64, seed: u64| {
        let search = Cmaes::new(&[0.1, 0.1], 0.02, seed).unwrap().with_points(10);
        let mut search = search.with_least_deviations(&[least, 0.0]).unwrap();
        for _ in 0..60 {
            let points = search.ask();
            assert_eq!(points.len(), 10);
            search.tell(&points.iter().map(|x| f(x)).collect::<Vec<_>>()).unwrap();
        }
        search.best().unwrap().1 < 0.01
    };
    let hits = |least| (0..20).filter(|&seed| found(least, seed)).count();
    let (without, with) = (hits(0.0), hits(0.04));
    assert!(with == 20 && without < 20, "{with} {without}");
    let search = Cmaes::new(&[0.1, 0.1], 0.02, 1).unwrap();
    assert!(search.with_least_deviations(&[0.1]).is_err());
}

#[test]
fn the_same_seed_gives_the_same_bits_and_faults_are_named() {
    let run = |seed| {
        let mut search = Cmaes::new(&[0.2, 0.7], 0.3, seed).unwrap();
        for _ in 0..20 {
            let values: Vec<f64> = search.ask().iter().map(|x| rosenbrock(x)).collect();
            search.tell(&values).unwrap();
        }
        let (point, value) = search.best().unwrap();
        (point.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), value.to_bits())
    };
    assert_eq!(run(4), run(4));
    assert_ne!(run(4), run(5));
    assert!(Cmaes::new(&[], 1.0, 0).is_err());
    assert!(Cmaes::new(&[0.0], 0.0, 0).is_err());
    let mut search = Cmaes::new(&[0.0], 1.0, 0).unwrap();
    search.ask();
    assert!(search.tell(&[1.0]).is_err());
}
