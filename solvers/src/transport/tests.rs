use super::*;
use crate::random::{normal, stream, uniform};

/// The curves that the numbers of `geomloss_itself` were computed for.
fn curve(n: usize, scale: f64, shift: f64) -> PointCloud<2> {
    let at = |k: usize| {
        let k = k as f64;
        [scale * libm::cos(1.7 * k) + shift, 0.6 * scale * libm::sin(2.3 * k + 0.4)]
    };
    let weights: Vec<f64> = (0..n).map(|k| (1 + k * 7 % 11) as f64).collect();
    let mass: f64 = weights.iter().sum();
    let points: Vec<_> = (0..n).map(at).collect();
    PointCloud::new(&points, &weights.iter().map(|w| w / mass).collect::<Vec<_>>()).unwrap()
}

fn gaussian(n: usize, mean: [f64; 2], sd: [f64; 2], seed: u64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut s = stream(seed, "gaussian", 0);
    let points = (0..n).map(|_| [0, 1].map(|d| mean[d] + sd[d] * normal(&mut s))).collect();
    (points, vec![1.0 / n as f64; n])
}

fn cloud((points, weights): &(Vec<[f64; 2]>, Vec<f64>)) -> PointCloud<2> {
    PointCloud::new(points, weights).unwrap()
}

/// Numbers printed by geomloss 0.3.1 (torch, f64, backend "tensorized", p = 2).
#[test]
fn geomloss_itself() {
    let (a, b) = (curve(40, 9.0, 0.0), curve(55, 13.0, 17.0));
    let base = Sinkhorn::default();
    let cases = [
        (base, 97.290063620946),
        (Sinkhorn { reach: Some(5.0), ..base }, 25.853195837058),
        (Sinkhorn { reach: None, ..base }, 139.316919217025),
        (Sinkhorn { blur: 0.5, scaling: 0.8, ..base }, 105.034850574116),
        (Sinkhorn { blur: 2.0, diameter: Some(100.0), ..base }, 96.212930740438),
    ];
    for (sinkhorn, expected) in cases {
        let found = sinkhorn.divergence(&a, &b).unwrap();
        // The exponentials are right to 1e-7.
        assert!((found / expected - 1.0).abs() < 1e-7, "{sinkhorn:?}: {found} {expected}");
    }
    let points: Vec<_> = (0..a.len()).map(|n| a.point(n)).collect();
    let twice: Vec<f64> = a.weights().iter().map(|w| 2.0 * w).collect();
    let found = base.divergence(&PointCloud::new(&points, &twice).unwrap(), &b).unwrap();
    assert!((found / 206.242976788373 - 1.0).abs() < 1e-7, "{found}");
}

/// Potentials of two unit Diracs at cost c solve f = c/(2 + eps/rho), in OT(a, a) f = 0, so
/// S = (rho + eps/2) * 2 (1 - exp(-c / (2 rho + eps))) once the iteration has settled; a
/// pair of Diracs settles as 2^-steps.
#[test]
fn two_diracs_unbalanced() {
    let at = |x: [f64; 2]| PointCloud::new(&[x], &[1.0]).unwrap();
    let sinkhorn = Sinkhorn { scaling: 0.97, ..Sinkhorn::default() };
    for end in [[3.0, 0.0], [6.0, 8.0], [40.0, -30.0]] {
        let cost = 0.5 * (end[0] * end[0] + end[1] * end[1]);
        let exact = 2.0 * 400.5 * (1.0 - libm::exp(-cost / 801.0));
        let found = sinkhorn.divergence(&at([0.0, 0.0]), &at(end)).unwrap();
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    }
}

/// Without a reach a shifted copy costs |shift|^2 / 2, whatever the blur.
#[test]
fn balanced_translation() {
    let points = gaussian(700, [0.0; 2], [4.0, 7.0], 3);
    let moved: Vec<_> = points.0.iter().map(|x| [x[0] + 12.0, x[1] - 5.0]).collect();
    let sinkhorn = Sinkhorn { reach: None, scaling: 0.9, ..Sinkhorn::default() };
    let found = sinkhorn.divergence(&cloud(&points), &cloud(&(moved, points.1))).unwrap();
    assert!((found / 84.5 - 1.0).abs() < 1e-4, "{found}");
}

/// As the blur vanishes, the cost is that of matching sorted points on a line.
#[test]
fn sorted_points_on_a_line() {
    let mut s = stream(5, "line", 0);
    let mut draw = |scale: f64| {
        let mut x: Vec<f64> = (0..200).map(|_| scale * uniform(&mut s)).collect();
        x.sort_by(f64::total_cmp);
        x
    };
    let (x, y) = (draw(10.0), draw(30.0));
    let exact = x.iter().zip(&y).map(|(a, b)| 0.5 * (a - b) * (a - b)).sum::<f64>() / 200.0;
    let line = |x: &[f64]| {
        let points: Vec<_> = x.iter().map(|&x| [x]).collect();
        PointCloud::new(&points, &[1.0 / 200.0; 200]).unwrap()
    };
    let mut errors = [0.8, 0.2, 0.05].map(|blur| {
        let sinkhorn = Sinkhorn { blur, reach: None, scaling: 0.9, diameter: None };
        (sinkhorn.divergence(&line(&x), &line(&y)).unwrap() / exact - 1.0).abs()
    });
    assert!(errors[2] < 1e-3, "{errors:?}");
    errors.reverse();
    assert!(errors.is_sorted(), "{errors:?}");
}

/// Gaussians: S = |shift|^2/2 + sum over axes (B(s, t) - B(s, s)/2 - B(t, t)/2) with the
/// entropic cost B(s, t) of Janati et al. 2020, theorem 1, one axis at a time.
#[test]
fn gaussians() {
    let entropic = |s: f64, t: f64, eps: f64| {
        let d = (4.0 * s * s * t * t + eps * eps).sqrt();
        0.5 * (s * s + t * t - d + eps * libm::log(d + eps))
    };
    let (sd, te, eps) = ([2.0, 5.0], [4.0, 3.0], 1.0);
    let shape: f64 = (0..2)
        .map(|k| {
            entropic(sd[k], te[k], eps)
                - 0.5 * (entropic(sd[k], sd[k], eps) + entropic(te[k], te[k], eps))
        })
        .sum();
    // Gaussians sampled on a lattice, which integrates them to rounding.
    let lattice = |mean: [f64; 2], sd: [f64; 2]| {
        let steps = |d: usize| (-24..=24).map(move |k| f64::from(k) * 0.25 * sd[d]);
        let points: Vec<_> =
            steps(0).flat_map(|x| steps(1).map(move |y| [mean[0] + x, mean[1] + y])).collect();
        let weight = |x: &[f64; 2]| {
            let square = |d: usize| ((x[d] - mean[d]) / sd[d]) * ((x[d] - mean[d]) / sd[d]);
            libm::exp(-0.5 * (square(0) + square(1)))
        };
        let weights: Vec<f64> = points.iter().map(weight).collect();
        let mass: f64 = weights.iter().sum();
        PointCloud::new(&points, &weights.iter().map(|w| w / mass).collect::<Vec<_>>()).unwrap()
    };
    let exact = 0.5 * (49.0 + 9.0) + shape;
    let sinkhorn = Sinkhorn { reach: None, scaling: 0.9, ..Sinkhorn::default() };
    let found = sinkhorn.divergence(&lattice([0.0; 2], sd), &lattice([7.0, -3.0], te)).unwrap();
    assert!((found / exact - 1.0).abs() < 1e-3, "{found} {exact}");
}

#[test]
fn zero_symmetric_positive_and_blind_to_order() {
    let sinkhorn = Sinkhorn::default();
    let (p, q) =
        (gaussian(500, [20.0, 1.0], [8.0, 3.0], 1), gaussian(300, [15.0, 14.0], [4.0; 2], 2));
    let (a, b) = (cloud(&p), cloud(&q));
    assert_eq!(sinkhorn.divergence(&a, &a).unwrap(), 0.0);
    let (ab, ba) = (sinkhorn.divergence(&a, &b).unwrap(), sinkhorn.divergence(&b, &a).unwrap());
    assert!((ab / ba - 1.0).abs() < 1e-12, "{ab} {ba}");
    assert!(ab > 1.0);
    let reversed = (p.0.into_iter().rev().collect(), p.1);
    assert_eq!(cloud(&reversed), a);
    // A cloud that hardly differs is hardly away: rounding must not drown it.
    let nudged = (q.0.iter().map(|x| [x[0] + 0.01, x[1]]).collect(), q.1);
    let near = sinkhorn.distance(&b, &cloud(&nudged)).unwrap();
    assert!((0.9..1.1).contains(&(near / libm::sqrt(0.5e-4))), "{near}");
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    let (a, b) = (cloud(&gaussian(900, [20.0, 1.0], [8.0, 3.0], 1)), curve(700, 13.0, 17.0));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Sinkhorn::default().divergence(&a, &b).unwrap().to_bits())
    };
    assert_eq!(run(1), run(3));
}

/// Cells as wide as the blur stay within 1 % of the exact distance, for clouds like the
/// curvature diagrams of spheres, tubes, sponges and of noise.
#[test]
fn coarse_distances_agree_with_exact_ones() {
    let clouds = [
        cloud(&gaussian(3000, [20.0, 19.0], [4.0; 2], 1)),
        cloud(&gaussian(3000, [23.0, 0.2], [8.0, 3.0], 2)),
        cloud(&gaussian(3000, [15.0, -15.0], [7.0; 2], 3)),
        cloud(&gaussian(3000, [10.0, -10.0], [30.0, 25.0], 4)),
    ];
    let sinkhorn = Sinkhorn { diameter: Some(300.0), ..Sinkhorn::default() };
    let matrix = CoarseSinkhorn::new(sinkhorn, 1.0).unwrap().matrix(&clouds).unwrap();
    for i in 0..4 {
        assert_eq!(matrix[[i, i]], 0.0);
        for j in 0..i {
            assert_eq!(matrix[[i, j]], matrix[[j, i]]);
            let exact = Sinkhorn::default().distance(&clouds[i], &clouds[j]).unwrap();
            assert!((matrix[[i, j]] / exact - 1.0).abs() < 0.01, "{i} {j}: {matrix} {exact}");
        }
    }
}

#[test]
fn binning_keeps_mass_and_mean() {
    let cloud = cloud(&gaussian(2000, [3.0, -2.0], [5.0; 2], 9));
    let coarse = cloud.binned(2.0).unwrap();
    assert!(coarse.len() < 500);
    let moments = |c: &PointCloud<2>| {
        let mut sums = [0.0; 3];
        for (n, w) in c.weights().iter().enumerate() {
            let [x, y] = c.point(n);
            [1.0, x, y].iter().zip(&mut sums).for_each(|(v, sum)| *sum += w * v);
        }
        sums
    };
    for (fine, coarse) in moments(&cloud).iter().zip(moments(&coarse)) {
        assert!((fine - coarse).abs() < 1e-12);
    }
}

#[test]
fn refuses_what_it_cannot_compare() {
    let point = [[0.0, 1.0]];
    assert!(PointCloud::new(&point, &[]).is_err());
    assert!(PointCloud::new(&point, &[0.0]).is_err());
    assert!(PointCloud::new(&point, &[-1.0]).is_err());
    assert!(PointCloud::new(&[[f64::NAN, 0.0]], &[1.0]).is_err());
    let cloud = PointCloud::new(&point, &[1.0]).unwrap();
    for bad in [
        Sinkhorn { blur: 0.0, ..Sinkhorn::default() },
        Sinkhorn { reach: Some(-1.0), ..Sinkhorn::default() },
        Sinkhorn { scaling: 1.0, ..Sinkhorn::default() },
        Sinkhorn { diameter: Some(0.5), ..Sinkhorn::default() },
    ] {
        assert!(bad.divergence(&cloud, &cloud).is_err(), "{bad:?}");
    }
    assert!(CoarseSinkhorn::new(Sinkhorn::default(), 1.0).is_err());
}
