//! A level of the hierarchy and its smoother.

use super::bands::{Bands, Part};
use super::fine::{Fine, Work};
use super::lattice::Layout;
use super::smooth::{First, Next, Step};
use super::stencil::Stencil;
use std::ops::Range;

/// Chebyshev polynomials of the fourth kind, best for V-cycles: weights of the steps, by
/// degree. Lottes 2023, "Optimal polynomial smoothers for multigrid V-cycles" (arXiv 2202.08830).
const WEIGHTS: [&[f64]; 3] = [
    &[1.023_872_875_703_13, 1.264_089_053_710_85],
    &[1.008_425_447_820_28, 1.088_678_392_087_30, 1.337_531_259_096_18],
    &[1.003_913_104_272_85, 1.040_358_111_885_93, 1.148_634_985_462_54, 1.382_688_692_410_00],
];

/// Degrees of the smoother that there are weights for.
pub(super) const DEGREES: Range<usize> = 2..5;

/// The product of a level.
#[derive(Clone, Debug)]
pub(super) enum Operator {
    Fine(Fine<f32>),
    Stencil(Stencil),
}

impl Operator {
    /// Calls `each(row, that row of the product, components [`Layout::wide`] apart)`.
    pub(super) fn product(
        &self,
        x: &[f32],
        rows: Range<usize>,
        work: &mut Work<f32>,
        mut each: impl FnMut(usize, &mut [f32]),
    ) {
        match self {
            Self::Fine(fine) => fine.product(x, rows, work, each),
            Self::Stencil(stencil) => {
                for row in rows {
                    stencil.product(row, x, &mut work.product);
                    each(row, &mut work.product);
                }
            }
        }
    }
}

/// One level: `A x = b`.
#[derive(Clone, Debug)]
pub(super) struct Level {
    pub layout: Layout,
    pub bands: Bands,
    pub operator: Operator,
    /// 1 / diagonal, 0 where an unknown is fixed: it stays 0 then.
    pub inverse_diagonal: Vec<f32>,
    /// Largest eigenvalue of `D^-1 A`, or a little more.
    pub radius: f64,
    pub b: Vec<f32>,
    pub x: Vec<f32>,
    pub r: Vec<f32>,
    pub z: Vec<f32>,
    pub y: Vec<f32>,
    pub work: Vec<Work<f32>>,
    /// One per row.
    pub sums: Vec<f64>,
    degree: usize,
}

impl Level {
    pub(super) fn new(operator: Operator, degree: usize) -> Self {
        let (layout, bands) = match &operator {
            Operator::Fine(fine) => (fine.layout, Fine::<f32>::bands(&fine.layout)),
            Operator::Stencil(s) => (s.layout, Bands::new(s.layout.rows(), 1, s.layout.row_len())),
        };
        let work = match &operator {
            Operator::Fine(_) => Work::new(&layout),
            Operator::Stencil(_) => Work::of_stencil(&layout),
        };
        let zeros = || vec![0.0; layout.len()];
        Self {
            layout,
            bands,
            operator,
            inverse_diagonal: zeros(),
            radius: 2.0,
            b: zeros(),
            x: zeros(),
            r: zeros(),
            z: zeros(),
            y: zeros(),
            work: vec![work; bands.count],
            sums: vec![0.0; layout.rows()],
            degree,
        }
    }

    /// Smooths x; if it is to start from 0, x need not be set.
    pub(super) fn relax(&mut self, from_zero: bool) {
        self.first(from_zero);
        for index in 2..=self.degree {
            self.step(index, from_zero && index == 2);
        }
    }

    /// `gain` of step `index`, from 1.
    fn gain(&self, index: usize) -> f32 {
        let i = index as f64;
        ((8.0 * i - 4.0) / ((2.0 * i + 1.0) * self.radius)) as f32
    }

    /// `r = b - A x`, `z = gain D^-1 r`.
    fn first(&mut self, from_zero: bool) {
        let gain = self.gain(1);
        let row_len = self.layout.row_len();
        let Self { layout, bands, operator, inverse_diagonal, b, x, r, z, work, .. } = self;
        if from_zero {
            // r is b then, and the first step takes it from there.
            return bands.each(bands.part(z, row_len), |band, z| {
                let first = bands.range(band).start * row_len;
                let known = inverse_diagonal[first..].iter().zip(&b[first..]);
                z.data.iter_mut().zip(known).for_each(|(z, (d, b))| *z = gain * (d * b));
            });
        }
        let parts = (bands.part(r, row_len), bands.part(z, row_len), Part::one_each(work));
        bands.each(parts, |band, (r, z, work)| {
            let rows = bands.range(band);
            let start = rows.start;
            operator.product(x, rows, &mut work.data[0], |row, product| {
                let (here, all) = ((row - start) * row_len, row * row_len);
                let row = First {
                    layout,
                    gain,
                    product,
                    diagonal: &inverse_diagonal[all..],
                    b: &b[all..],
                    r: &mut r.data[here..],
                    z: &mut z.data[here..],
                };
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || row.run(),
                );
            });
        });
    }

    /// `r -= A z`, then the next z, which is added to x.
    fn step(&mut self, index: usize, from_zero: bool) {
        let weights = WEIGHTS[self.degree - DEGREES.start];
        let step = Step {
            keep: (2.0 * index as f64 - 3.0) as f32 / (2.0 * index as f64 + 1.0) as f32,
            gain: self.gain(index),
            old: if index == 2 { weights[0] as f32 } else { 0.0 },
            new: weights[index - 1] as f32,
        };
        let row_len = self.layout.row_len();
        let Self { layout, bands, operator, inverse_diagonal, b, x, r, z, y, work, .. } = self;
        let parts = (
            bands.part(x, row_len),
            bands.part(r, row_len),
            bands.part(y, row_len),
            Part::one_each(work),
        );
        bands.each(parts, |band, (x, r, y, work)| {
            let rows = bands.range(band);
            let start = rows.start;
            operator.product(z, rows, &mut work.data[0], |row, product| {
                let (here, all) = ((row - start) * row_len, row * row_len);
                let row = Next {
                    layout,
                    step,
                    from_zero,
                    b: &b[all..],
                    product,
                    diagonal: &inverse_diagonal[all..],
                    z: &z[all..],
                    r: &mut r.data[here..],
                    y: &mut y.data[here..],
                    x: &mut x.data[here..],
                };
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || row.run(),
                );
            });
        });
        std::mem::swap(z, y);
    }

    /// `r = b - A x`.
    pub(super) fn residual(&mut self) {
        let row_len = self.layout.row_len();
        let Self { layout, bands, operator, b, x, r, work, .. } = self;
        let parts = (bands.part(r, row_len), Part::one_each(work));
        bands.each(parts, |band, (r, work)| {
            let rows = bands.range(band);
            let start = rows.start;
            operator.product(x, rows, &mut work.data[0], |row, product| {
                let r = &mut r.data[(row - start) * row_len..][..row_len];
                for c in 0..layout.components {
                    let span = layout.span(c);
                    let b = &b[row * row_len..][span.clone()];
                    let product = &product[c * layout.wide() + 1..];
                    for ((r, b), a) in r[span].iter_mut().zip(b).zip(product) {
                        *r = b - a;
                    }
                }
            });
        });
    }
}
