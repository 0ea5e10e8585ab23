use super::*;
use crate::distances::examples::{distances, spirals};
use crate::random::{normal, stream, uniform};
use ndarray::Array2;
use std::f64::consts::TAU;

/// Of each point its others, near ones first.
fn ranks(distances: &Array2<f64>) -> Vec<Vec<usize>> {
    let n = distances.nrows();
    (0..n)
        .map(|i| {
            let mut others: Vec<usize> = (0..n).filter(|&j| j != i).collect();
            others.sort_by(|&a, &b| distances[[i, a]].total_cmp(&distances[[i, b]]));
            others
        })
        .collect()
}

/// Venna and Kaski 2001: 1 if the k neighbours in the map are neighbours in truth, 1/2 at random.
fn trustworthiness(truth: &Array2<f64>, map: &[[f64; 2]], k: usize) -> f64 {
    let (near, mapped) = (ranks(truth), ranks(&distances(map)));
    let n = near.len();
    let mut penalty = 0;
    for i in 0..n {
        for j in &mapped[i][..k] {
            let rank = near[i].iter().position(|other| other == j).unwrap() + 1;
            penalty += rank.saturating_sub(k);
        }
    }
    1.0 - 2.0 * penalty as f64 / ((n * k) as f64 * (2.0 * n as f64 - 3.0 * k as f64 - 1.0))
}

/// `find_ab_params` of umap-learn, printed to 12 digits; its fit stops at 1.5e-8.
#[test]
fn curve_of_umap_learn() {
    for (min_dist, expected) in [
        (0.05, [1.750224963275, 0.842055392511]),
        (0.1, [1.576943460270, 0.895060877852]),
        (0.5, [0.583030020341, 1.334166992431]),
    ] {
        let found = curve::fit(1.0, min_dist);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{min_dist}: {found} {expected}");
        }
    }
}

/// The same points as in `cluster::tests`; sums and entries of umap-learn's
/// `fuzzy_simplicial_set` with 15 neighbours, whose memberships are single precision.
#[test]
fn fuzzy_graph_of_umap_learn() {
    let edges = fuzzy::fuzzy_graph(distances(&spirals()).view(), 15);
    assert_eq!(edges.len(), 2386);
    let (sum, squares) = edges.iter().fold((0.0, 0.0), |(s, q), e| (s + e.2, q + e.2 * e.2));
    // The search for sigma stops at 1e-5 of the sum of 14 memberships.
    assert!((sum - 739.413574219_f64).abs() < 1e-2, "{sum}");
    assert!((squares - 493.460510254_f64).abs() < 1e-2, "{squares}");
    let first = [0.892639875, 0.986311138, 1.0, 0.174535483, 0.916446209, 0.172898009, 0.111679785];
    for (edge, (j, expected)) in edges.iter().zip((1..).zip(first)) {
        assert_eq!((edge.0, edge.1), (0, j));
        assert!((edge.2 - expected).abs() < 1e-5, "{edge:?} {expected}");
    }
}

#[test]
fn scaling_recovers_a_plane() {
    let mut s = stream(2, "plane", 0);
    let points: Vec<_> = (0..120).map(|_| [7.0 * normal(&mut s), normal(&mut s)]).collect();
    let truth = distances(&points);
    let found = distances(&classical_scaling(truth.view()).unwrap());
    let worst = (&found - &truth).iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    // sqrt of rounding, where points are close.
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn clusters_stay_apart_and_neighbours_stay_near() {
    let mut s = stream(6, "clusters", 0);
    let points: Vec<[f64; 10]> = (0..240)
        .map(|k| std::array::from_fn(|d| normal(&mut s) + if d == k % 4 { 25.0 } else { 0.0 }))
        .collect();
    let truth = distances(&points);
    let map = Umap::default().embed(truth.view()).unwrap();
    let mapped = ranks(&distances(&map));
    for (i, near) in mapped.iter().enumerate() {
        assert!(near[..40].iter().all(|j| j % 4 == i % 4), "{i}");
    }
    let found = trustworthiness(&truth, &map, 15);
    assert!(found > 0.95, "{found}");
}

/// A noisy ring in ten dimensions becomes a ring: the order around it is kept, and nothing
/// is in its middle.
#[test]
fn a_ring_stays_a_ring() {
    let mut s = stream(8, "ring", 0);
    let n = 300;
    let points: Vec<[f64; 10]> = (0..n)
        .map(|k| {
            let t = TAU * f64::from(k) / f64::from(n);
            let ring = [libm::cos(t), libm::sin(t), 0.5 * libm::cos(2.0 * t)];
            std::array::from_fn(|d| ring.get(d).map_or(0.0, |v| 10.0 * v) + 0.1 * uniform(&mut s))
        })
        .collect();
    let map = Umap::default().embed(distances(&points).view()).unwrap();
    let center = [0, 1].map(|d| map.iter().map(|p| p[d]).sum::<f64>() / f64::from(n));
    let polar: Vec<[f64; 2]> = map
        .iter()
        .map(|p| [p[0] - center[0], p[1] - center[1]])
        .map(|[x, y]| [(x * x + y * y).sqrt(), libm::atan2(y, x)])
        .collect();
    let far = polar.iter().fold(0.0, |m: f64, p| m.max(p[0]));
    assert!(polar.iter().all(|p| p[0] > 0.25 * far));
    // Once around, in steps that are small against the whole.
    let step = |k: usize| {
        let turn = polar[(k + 1) % polar.len()][1] - polar[k][1];
        turn - TAU * (turn / TAU).round()
    };
    let turns: f64 = (0..polar.len()).map(step).sum();
    assert!((turns.abs() - TAU).abs() < 1e-9, "{turns}");
    assert!((0..polar.len()).all(|k| step(k).abs() < 0.5));
}

#[test]
fn repeats_for_any_number_of_threads() {
    let mut s = stream(3, "repeat", 0);
    let points: Vec<[f64; 3]> =
        (0..100).map(|_| std::array::from_fn(|_| uniform(&mut s))).collect();
    let truth = distances(&points);
    let umap = Umap { epochs: 50, ..Umap::default() };
    let run = |umap: Umap, threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| umap.embed(truth.view()).unwrap())
    };
    assert_eq!(run(umap, 1), run(umap, 3));
    assert_ne!(run(umap, 1), run(Umap { seed: 1, ..umap }, 1));
}

#[test]
fn few_or_equal_points_and_bad_settings() {
    for n in 1..4 {
        let map = Umap::default().embed(Array2::zeros((n, n)).view()).unwrap();
        assert!(map.len() == n && map.iter().flatten().all(|v| v.is_finite()), "{map:?}");
    }
    let d = distances(&[[0.0], [1.0]]);
    let umap = Umap::default();
    for bad in [
        Umap { neighbors: 1, ..umap },
        Umap { spread: 0.0, ..umap },
        Umap { min_dist: 1.5, ..umap },
        Umap { min_dist: f64::NAN, ..umap },
    ] {
        assert!(bad.embed(d.view()).is_err(), "{bad:?}");
    }
}
