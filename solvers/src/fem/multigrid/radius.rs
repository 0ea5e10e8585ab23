//! Spectral radius of a level's `D^-1 A`, on which the smoother depends.

use super::bands::Part;
use super::level::Level;

/// Steps of the power method, and what its result is multiplied with: 10 steps from noise
/// stay up to a tenth below, and too small a radius makes the smoother diverge where too
/// large a one only makes it slower.
const POWER_STEPS: usize = 10;
const POWER_MARGIN: f64 = 1.1;

impl Level {
    /// Estimates the radius by the power method, in the norm of D.
    pub(super) fn estimate_radius(&mut self) {
        noise(&mut self.z, &self.inverse_diagonal);
        let row_len = self.layout.row_len();
        let mut squares = 1.0;
        for _ in 0..POWER_STEPS {
            let Self { layout, bands, operator, inverse_diagonal, z, y, work, sums, .. } = self;
            let scale = (1.0 / f64::sqrt(squares)) as f32;
            let parts = (bands.part(y, row_len), bands.part(sums, 1), Part::one_each(work));
            bands.each(parts, |band, (y, sums, work)| {
                let rows = bands.range(band);
                let start = rows.start;
                operator.product(z, rows, &mut work.data[0], |row, product| {
                    let y = &mut y.data[(row - start) * row_len..][..row_len];
                    let diagonal = &inverse_diagonal[row * row_len..];
                    let mut sum = 0.0;
                    for c in 0..layout.components {
                        let span = layout.span(c);
                        let product = &product[c * layout.wide() + 1..];
                        let diagonal = &diagonal[span.clone()];
                        for ((y, d), a) in y[span].iter_mut().zip(diagonal).zip(product) {
                            let a = a * scale;
                            *y = d * a;
                            sum += f64::from(*y) * f64::from(a);
                        }
                    }
                    sums.data[row - start] = sum;
                });
            });
            squares = self.sums.iter().sum();
            std::mem::swap(&mut self.z, &mut self.y);
        }
        // The last but one vector had norm 1 after its scaling.
        self.radius = if squares > 0.0 { squares.sqrt() * POWER_MARGIN } else { 1.0 };
    }
}

/// The same noise in (-1, 1) for a level of a size each time (a Weyl sequence), 0 where fixed.
fn noise(z: &mut [f32], inverse_diagonal: &[f32]) {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    for (i, (z, &d)) in z.iter_mut().zip(inverse_diagonal).enumerate() {
        let t = (i as f64 * GOLDEN).fract();
        let scrambled = (t * 7919.0).fract();
        *z = if d > 0.0 { (2.0 * scrambled - 1.0) as f32 } else { 0.0 };
    }
}
