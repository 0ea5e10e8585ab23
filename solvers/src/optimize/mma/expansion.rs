//! The approximating functions of one block, evaluated in small arrays on the stack.

/// Variables per block: the arrays of an [`Expansion`] stay in the first-level cache, and a
/// block is worth a task of its own. Sums are taken within blocks and then over them in
/// order, so this number is part of the result's last bits.
pub(super) const BLOCK: usize = 512;

/// Independent partial sums, so that the machine's vectors of any width give the same bits.
const LANES: usize = 8;

/// `P = p_0 + sum_i lambda_i p_i`, Q likewise, and the inverse distances to the asymptotes.
pub(super) struct Expansion {
    pub(super) p: [f64; BLOCK],
    pub(super) q: [f64; BLOCK],
    /// `1/(u - x)`.
    pub(super) above: [f64; BLOCK],
    /// `1/(x - l)`.
    pub(super) below: [f64; BLOCK],
}

impl Expansion {
    pub(super) fn new() -> Self {
        let zeros = [0.0; BLOCK];
        Self { p: zeros, q: zeros, above: zeros, below: zeros }
    }
}

/// `y += a x`.
pub(super) fn add_scaled(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// `sum_k a_k b_k` in fixed lanes.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (mut left, mut right) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (a, b) in left.by_ref().zip(right.by_ref()) {
        for lane in 0..LANES {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f64>() + rest
}
