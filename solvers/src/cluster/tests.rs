use super::*;
use crate::distances::examples::{distances, spirals};
use crate::random::{normal, stream, uniform};
use ndarray::Array2;

fn written(clusters: &Clusters) -> String {
    clusters.labels.iter().map(|l| l.map_or('.', |l| (b'a' + l as u8) as char)).collect()
}

/// Labels and summed strengths as the Python package hdbscan 0.8.44 gives them (metric
/// "precomputed", clusters renumbered by their first points). Settings at which a scattered
/// point is equally near to two clusters in mutual reachability, such as 5 and 3, are left
/// out: there the package decides by the order of the points.
#[test]
fn hdbscan_itself() {
    let core = format!("{}{}{}", "a".repeat(40), "b".repeat(25), "c".repeat(50));
    let cases = [
        (10, 10, ".c.....a.c....ca.c.b", 103.899930209318),
        (8, 7, ".c....ca.c....ca.c.b", 102.591347138890),
        (20, 10, ".c.....a.c....ca.c.b", 110.539256401965),
        (15, 5, ".c....ca.c....ca.c.b", 105.195751885483),
        (5, 1, ".cab..ca.cab..ca.cab", 118.148808939511),
    ];
    let matrix = distances(&spirals());
    for (min_cluster_size, min_samples, scattered, strength) in cases {
        let found = Hdbscan { min_cluster_size, min_samples }.labels(matrix.view()).unwrap();
        assert_eq!(written(&found), format!("{core}{scattered}"), "{min_samples}");
        assert_eq!(found.count, 3);
        let sum: f64 = found.strengths.iter().sum();
        assert!((sum - strength).abs() < 1e-9, "{min_samples}: {sum} {strength}");
    }
}

#[test]
fn blind_to_the_order_of_points() {
    let points = spirals();
    let order: Vec<usize> = (0..points.len()).map(|k| k * 61 % points.len()).collect();
    let mixed: Vec<_> = order.iter().map(|&k| points[k]).collect();
    let (a, b) = (distances(&points), distances(&mixed));
    let [a, b] = [a, b].map(|d| Hdbscan::default().labels(d.view()).unwrap());
    for (x, &i) in order.iter().enumerate() {
        assert_eq!(a.strengths[i], b.strengths[x]);
        for (y, &j) in order.iter().enumerate() {
            assert_eq!(a.labels[i] == a.labels[j], b.labels[x] == b.labels[y]);
        }
    }
}

#[test]
fn blobs_in_noise() {
    let mut s = stream(4, "blobs", 0);
    let centers = [[0.0, 0.0], [40.0, 0.0], [0.0, 40.0], [40.0, 40.0]];
    let mut points = Vec::new();
    for center in centers {
        points.extend((0..60).map(|_| center.map(|c| c + normal(&mut s))));
    }
    points.extend((0..20).map(|_| [0, 1].map(|_| 300.0 + 2000.0 * uniform(&mut s))));
    let found = Hdbscan::default().labels(distances(&points).view()).unwrap();
    assert_eq!(found.count, 4);
    let right = (0..240).filter(|&k| found.labels[k] == Some(k / 60)).count();
    // A normal blob has a few far points.
    assert!(right >= 228, "{right}");
    assert!(found.labels[240..].iter().all(Option::is_none));
}

#[test]
fn few_or_equal_points() {
    let one = Hdbscan::default().labels(distances(&[[1.0, 2.0]]).view()).unwrap();
    assert_eq!((one.count, one.labels), (0, vec![None]));
    let two_places: Vec<_> = (0..40).map(|k| [f64::from(k % 2), 0.0]).collect();
    let found = Hdbscan::default().labels(distances(&two_places).view()).unwrap();
    assert_eq!(found.count, 2);
    assert!(found.labels.iter().enumerate().all(|(k, l)| *l == Some(k % 2)));
}

#[test]
fn refuses_what_is_no_distance() {
    let run = |d: Array2<f64>| Hdbscan::default().labels(d.view());
    assert!(run(Array2::zeros((0, 0))).is_err());
    assert!(run(Array2::zeros((2, 3))).is_err());
    assert!(run(ndarray::array![[0.0, 1.0], [2.0, 0.0]]).is_err());
    assert!(run(ndarray::array![[0.0, f64::NAN], [f64::NAN, 0.0]]).is_err());
    assert!(run(ndarray::array![[0.0, -1.0], [-1.0, 0.0]]).is_err());
    let d = distances(&spirals());
    assert!(Hdbscan { min_cluster_size: 1, min_samples: 1 }.labels(d.view()).is_err());
    assert!(Hdbscan { min_cluster_size: 5, min_samples: 0 }.labels(d.view()).is_err());
}
