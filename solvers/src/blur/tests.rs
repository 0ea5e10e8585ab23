use super::{Blur, BlurEdges};
use crate::random::{stream, uniform};

fn random(n: usize, name: &str) -> Vec<f64> {
    let mut stream = stream(1, name, 0);
    (0..n).map(|_| uniform(&mut stream) - 0.5).collect()
}

/// The sums as they are defined, on even and odd axes, shorter and longer than the filter, and on
/// axes of fewer voxels than the filter is padded to.
#[test]
fn periodic_blur_is_the_sum_over_the_ring() {
    for shape in [[9, 44, 12], [2, 5, 3], [1, 2, 1]] {
        let u = random(shape.iter().product(), "blur");
        let expected = ring_sums(shape, &u);
        let mut blur = Blur::<f64>::new(shape, 2.0, BlurEdges::Periodic).unwrap();
        let (mut between, mut out) = (u.clone(), u.clone());
        blur.apply(&u, &mut between, &mut out);
        for (a, b) in out.iter().zip(&expected) {
            assert!((a - b).abs() < 1e-15, "{shape:?}: {a} {b}");
        }
    }
}

/// Of a Gaussian of 2 voxels.
fn ring_sums(shape: [usize; 3], u: &[f64]) -> Vec<f64> {
    let mut expected = u.to_vec();
    for (axis, stride) in [(0, shape[1] * shape[2]), (1, shape[2]), (2, 1)] {
        let n = shape[axis] as isize;
        let taps: Vec<(isize, f64)> =
            (-(n / 2)..n - n / 2).map(|j| (j, (-((j * j) as f64) / 8.0).exp())).collect();
        let total: f64 = taps.iter().map(|t| t.1).sum();
        let source = expected.clone();
        for (i, out) in expected.iter_mut().enumerate() {
            let at = (i / stride) as isize % n;
            let first = i as isize - at * stride as isize;
            let term = |(j, w): &(isize, f64)| {
                w * source[(first + (at - j).rem_euclid(n) * stride as isize) as usize]
            };
            *out = taps.iter().map(term).sum::<f64>() / total;
        }
    }
    expected
}

#[test]
fn transpose_is_the_transpose() {
    for (shape, edges) in [
        ([9, 30, 21], BlurEdges::Periodic),
        ([9, 30, 21], BlurEdges::Replicate),
        ([40, 5, 28], BlurEdges::Replicate),
    ] {
        let n = shape.iter().product();
        let (x, y) = (random(n, "x"), random(n, "y"));
        let mut blur = Blur::<f64>::new(shape, 1.3, edges).unwrap();
        let (mut between, mut kx, mut ky) = (x.clone(), x.clone(), y.clone());
        blur.apply(&x, &mut between, &mut kx);
        blur.transpose(&mut ky, &mut between);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&kx, &y) - dot(&x, &ky)).abs() < 1e-13 * n as f64, "{shape:?} {edges:?}");
        // Rows sum to 1: a constant stays.
        blur.apply(&vec![1.0; n], &mut between, &mut kx);
        assert!(kx.iter().all(|v| (v - 1.0).abs() < 1e-14));
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let shape = [33, 40, 35];
    let u = random(shape.iter().product(), "threads");
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut blur = Blur::<f64>::new(shape, 2.0, BlurEdges::Periodic).unwrap();
            let (mut between, mut out) = (u.clone(), u.clone());
            blur.apply(&u, &mut between, &mut out);
            out.iter().map(|v| v.to_bits()).collect::<Vec<_>>()
        })
    };
    assert_eq!(run(1), run(2));
}
