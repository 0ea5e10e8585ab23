//! How deep a pixel lies inside a region.

/// Distance (pixels) from the middle of each pixel of `inside` to the middle of the nearest
/// pixel outside, 0 outside; infinite if there is none. The picture's border is no border.
///
/// Exact, O(n): the lower envelope of parabolas, Felzenszwalb & Huttenlocher 2012, "Distance
/// transforms of sampled functions", along columns, then rows.
pub fn depth([ny, nx]: [usize; 2], inside: &[bool]) -> Vec<f64> {
    let mut squares = vec![f64::INFINITY; inside.len()];
    let mut line = vec![0.0; ny.max(nx)];
    for i in 0..nx {
        for j in 0..ny {
            line[j] = if inside[j * nx + i] { f64::INFINITY } else { 0.0 };
        }
        let found = envelope(&line[..ny]);
        found.into_iter().enumerate().for_each(|(j, v)| squares[j * nx + i] = v);
    }
    for row in squares.chunks_exact_mut(nx) {
        row.copy_from_slice(&envelope(row));
    }
    squares.into_iter().map(f64::sqrt).collect()
}

/// Least of `f(q) + (p - q)^2` over q, for every p.
fn envelope(f: &[f64]) -> Vec<f64> {
    // Parabolas of the envelope and where each takes over.
    let mut sites: Vec<(usize, f64)> = Vec::with_capacity(f.len());
    for (q, &height) in f.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        let lifted = height + (q * q) as f64;
        let mut from = f64::NEG_INFINITY;
        while let Some(&(p, start)) = sites.last() {
            from = (lifted - f[p] - (p * p) as f64) / (2 * (q - p)) as f64;
            if from > start {
                break;
            }
            sites.pop();
            from = f64::NEG_INFINITY;
        }
        sites.push((q, from));
    }
    if sites.is_empty() {
        return vec![f64::INFINITY; f.len()];
    }
    let mut at = 0;
    let value = |p: usize| {
        while at + 1 < sites.len() && sites[at + 1].1 < p as f64 {
            at += 1;
        }
        let q = sites[at].0;
        f[q] + (p as f64 - q as f64).powi(2)
    };
    (0..f.len()).map(value).collect()
}
