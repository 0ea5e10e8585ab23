//! Vectors of three numbers.

pub(super) type V = [f32; 3];

pub(super) fn add(a: V, b: V) -> V {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn scale(a: V, s: f32) -> V {
    a.map(|c| c * s)
}

/// `a + s b`.
pub(super) fn along(a: V, s: f32, b: V) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

pub(super) fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Of length 1; zero stays zero.
pub(super) fn unit(a: V) -> V {
    let length = dot(a, a).sqrt();
    if length > 0.0 { scale(a, 1.0 / length) } else { a }
}

/// Weighted sum of three.
pub(super) fn blend(weights: V, [a, b, c]: [V; 3]) -> V {
    let w = weights;
    [0, 1, 2].map(|m| w[0] * a[m] + w[1] * b[m] + w[2] * c[m])
}

/// Two unit vectors across the unit vector `n`, right-handed with it (Duff et al. 2017,
/// "Building an orthonormal basis, revisited").
pub(super) fn frame(n: V) -> [V; 2] {
    let sign = if n[2] < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}
