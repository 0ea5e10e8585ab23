//! Segments, polygons and straight-sided stars.

/// Distance from `p` to the segment from `a` to `b`.
pub(super) fn to_segment(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let (ap, ab) = (super::minus(p, a), super::minus(b, a));
    let square = super::dot(ab, ab);
    let s = if square > 0.0 { (super::dot(ap, ab) / square).clamp(0.0, 1.0) } else { 0.0 };
    super::norm(super::minus(ap, ab.map(|c| s * c)))
}

/// Signed distance to the polygon of `count` corners, inside by the even-odd rule.
pub(super) fn distance(p: [f64; 2], count: usize, corner: impl Fn(usize) -> [f64; 2]) -> f64 {
    let (mut nearest, mut inside) = (f64::INFINITY, false);
    let mut a = corner(count - 1);
    for m in 0..count {
        let b = corner(m);
        let flat = |q: [f64; 2]| [q[0], q[1], 0.0];
        nearest = nearest.min(to_segment(flat(p), flat(a), flat(b)));
        if (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        {
            inside = !inside;
        }
        a = b;
    }
    if inside { -nearest } else { nearest }
}

/// A star of `points` points: by symmetry the signed distance to one of its sides.
pub(super) fn star(p: [f64; 3], points: usize, outer: f64, inner: f64) -> f64 {
    let sector = std::f64::consts::TAU / points as f64;
    let theta = p[1].atan2(p[0]);
    let folded = (theta - sector * (theta / sector).round()).abs();
    let r = p[0].hypot(p[1]);
    let q = [r * folded.cos(), r * folded.sin(), 0.0];
    let tip = [outer, 0.0, 0.0];
    let notch = [inner * (0.5 * sector).cos(), inner * (0.5 * sector).sin(), 0.0];
    let side = [notch[0] - tip[0], notch[1] - tip[1]];
    let turn = side[0] * (q[1] - tip[1]) - side[1] * (q[0] - tip[0]);
    let distance = to_segment(q, tip, notch);
    if turn > 0.0 { -distance } else { distance }
}
