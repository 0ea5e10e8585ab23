//! Smoothing that leaves out what is hidden.

use super::Masked;

/// Gaussian mean of the visible pixels around each pixel, and the share of the Gaussian's
/// weight that is visible, in [0, 1]; `sigma` in pixels. Where nothing is visible the mean is 0.
///
/// Normalized convolution (Knutsson & Westin 1993): the convolution of value times
/// visibility over that of the visibility. Linear in the pixels and in `sigma`.
pub fn normalized_convolution(
    shape: [usize; 2],
    values: &[f64],
    weights: &[f64],
    sigma: f64,
) -> (Vec<f64>, Vec<f64>) {
    let weighted: Vec<f64> = values.iter().zip(weights).map(|(v, w)| v * w).collect();
    let mut mean = gaussian(shape, &weighted, sigma);
    let cover = gaussian(shape, weights, sigma);
    for (mean, &cover) in mean.iter_mut().zip(&cover) {
        *mean = if cover > 1e-12 { *mean / cover } else { 0.0 };
    }
    (mean, cover)
}

/// A picture's pixels as numbers, smoothed.
pub(super) fn smooth_ink(picture: &Masked<'_>, sigma: f64) -> (Vec<f64>, Vec<f64>) {
    normalized_convolution(picture.shape, &picture.values(), &picture.weights(), sigma)
}

/// Separable Gaussian, cut at 3 sigma, zero outside.
fn gaussian([ny, nx]: [usize; 2], values: &[f64], sigma: f64) -> Vec<f64> {
    let reach = (3.0 * sigma).ceil() as usize;
    let kernel: Vec<f64> =
        (0..=reach).map(|d| libm::exp(-0.5 * (d as f64 / sigma).powi(2))).collect();
    let total = kernel[0] + 2.0 * kernel[1..].iter().sum::<f64>();
    let kernel: Vec<f64> = kernel.iter().map(|k| k / total).collect();
    let mut rows = vec![0.0; values.len()];
    let mut line = vec![0.0; nx + 2 * reach];
    for j in 0..ny {
        line[reach..reach + nx].copy_from_slice(&values[j * nx..][..nx]);
        for (i, out) in rows[j * nx..][..nx].iter_mut().enumerate() {
            let mut sum = kernel[0] * line[i + reach];
            for (d, k) in kernel.iter().enumerate().skip(1) {
                sum += k * (line[i + reach - d] + line[i + reach + d]);
            }
            *out = sum;
        }
    }
    let mut out = vec![0.0; values.len()];
    for j in 0..ny {
        for (d, k) in kernel.iter().enumerate() {
            let above = j.checked_sub(d);
            let below = (d > 0 && j + d < ny).then_some(j + d);
            for source in [above, below].into_iter().flatten() {
                let target = &mut out[j * nx..][..nx];
                for (t, s) in target.iter_mut().zip(&rows[source * nx..][..nx]) {
                    *t += k * s;
                }
            }
        }
    }
    out
}
