//! Steps of the smoother for one row of nodes.

use super::lattice::Layout;

/// Coefficients of a step.
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub keep: f32,
    pub gain: f32,
    pub old: f32,
    pub new: f32,
}

/// First step: `r = b - A x`, `z = gain D^-1 r`.
pub(super) struct First<'a> {
    pub layout: &'a Layout,
    pub gain: f32,
    pub product: &'a [f32],
    pub diagonal: &'a [f32],
    pub b: &'a [f32],
    pub r: &'a mut [f32],
    pub z: &'a mut [f32],
}

impl First<'_> {
    #[inline(always)]
    pub(super) fn run(self) {
        let n = self.layout.lattice.nodes()[2];
        for c in 0..self.layout.components {
            let span = self.layout.span(c);
            let product = &self.product[c * self.layout.wide() + 1..][..n];
            let (d, b) = (&self.diagonal[span.clone()][..n], &self.b[span.clone()][..n]);
            let (r, z) = (&mut self.r[span.clone()][..n], &mut self.z[span][..n]);
            for i in 0..n {
                let residual = b[i] - product[i];
                r[i] = residual;
                z[i] = self.gain * (d[i] * residual);
            }
        }
    }
}

/// Another: `r -= A z`, `z' = keep z + gain D^-1 r`, `x += old z + new z'`, z' in y.
pub(super) struct Next<'a> {
    pub layout: &'a Layout,
    pub step: Step,
    /// Whether x was 0, and r is still b.
    pub from_zero: bool,
    pub b: &'a [f32],
    pub product: &'a [f32],
    pub diagonal: &'a [f32],
    pub z: &'a [f32],
    pub r: &'a mut [f32],
    pub y: &'a mut [f32],
    pub x: &'a mut [f32],
}

impl Next<'_> {
    #[inline(always)]
    pub(super) fn run(self) {
        let n = self.layout.lattice.nodes()[2];
        let Step { keep, gain, old, new } = self.step;
        for c in 0..self.layout.components {
            let span = self.layout.span(c);
            let product = &self.product[c * self.layout.wide() + 1..][..n];
            let (d, z) = (&self.diagonal[span.clone()][..n], &self.z[span.clone()][..n]);
            let (r, y) = (&mut self.r[span.clone()][..n], &mut self.y[span.clone()][..n]);
            let b = &self.b[span.clone()][..n];
            let x = &mut self.x[span][..n];
            for i in 0..n {
                let residual = if self.from_zero { b[i] } else { r[i] } - product[i];
                let next = keep * z[i] + gain * (d[i] * residual);
                r[i] = residual;
                y[i] = next;
                // A product with 0 would keep the NaN of a failed solve.
                let before = if self.from_zero { 0.0 } else { x[i] };
                x[i] = before + (old * z[i] + new * next);
            }
        }
    }
}
