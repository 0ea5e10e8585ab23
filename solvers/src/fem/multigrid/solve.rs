//! Conjugate gradients in 8-byte numbers around the V-cycle in 4-byte ones.
//!
//! Flexible: `beta = -alpha (z . q) / (old r . z)` is Polak and Ribiere's `z . (r - old r)`,
//! which forgives that a rounded V-cycle is not quite the same linear map each time.
//! Sums are kept per row of nodes and added in order, for the same bytes on any number of
//! threads.

use super::bands::Part;
use super::rows::{check_finite, collect, dot, spread};
use super::{Multigrid, Report, STALL_FACTOR, STALL_WINDOW, Status};
use crate::{Error, Result};

impl Multigrid {
    /// Solves `K x = rhs` for the stiffness of the last [`Multigrid::update`]; `x` is where to
    /// start from, and the solution on return, 0 where fixed. Both have one number per unknown.
    ///
    /// Done when `|K x - rhs| <= tolerance |rhs|` over the free unknowns, checked with the
    /// true residual. See [`Status`] for the other ends. Several right-hand sides: call it
    /// for one after another. An iteration costs four products on each level in 4-byte
    /// numbers and one on the finest in 8-byte ones, and allocates nothing.
    ///
    /// # Errors
    /// If a length does not fit, a number is not finite, the tolerance is not above 0, or
    /// there was no successful update.
    pub fn solve(
        &mut self,
        rhs: &[f64],
        x: &mut [f64],
        tolerance: f64,
        max_iterations: usize,
    ) -> Result<Report> {
        self.check_length("right-hand side", rhs.len())?;
        self.check_length("start of the iteration", x.len())?;
        check_finite("right-hand side", rhs)?;
        check_finite("start of the iteration", x)?;
        if tolerance.is_nan() || tolerance <= 0.0 {
            return Err(Error::out_of_range("tolerance", tolerance, "(0, inf)"));
        }
        if !self.ready {
            return Err(Error::Invalid("no stiffness: call `update` before `solve`".into()));
        }
        spread(&self.layout, x, &mut self.x);
        self.constraints.clear_fixed(&self.layout, &mut self.x);
        // Loads on supports do nothing.
        let free = rhs.iter().zip(&self.fixed).filter(|&(_, &fixed)| !fixed);
        let largest = free.clone().map(|(b, _)| b.abs()).fold(0.0, f64::max);
        if largest == 0.0 {
            x.fill(0.0);
            return Ok(Report { iterations: 0, residual: 0.0, status: Status::Converged });
        }
        // Scaled, so that no square leaves the range of numbers.
        let norm = largest * free.map(|(b, _)| (b / largest).powi(2)).sum::<f64>().sqrt();
        // On a thread of the pool, which wakes the others faster than one from outside.
        let run = || self.iterate(rhs, norm, tolerance, max_iterations);
        let (report, ()) = rayon::join(run, || ());
        collect(&self.layout, &self.x, x);
        Ok(report)
    }

    fn iterate(&mut self, rhs: &[f64], norm: f64, tolerance: f64, limit: usize) -> Report {
        let mut residual = self.residual(rhs, norm);
        // Whether there is no direction to keep, and what z is to be multiplied with.
        let (mut start, mut scale) = (true, norm);
        let (mut alpha, mut old) = (0.0, 1.0);
        let mut stall = Stall::new();
        for iterations in 0.. {
            if residual <= tolerance * norm && !start {
                // The recurrence has drifted from the truth.
                residual = self.residual(rhs, norm);
                (start, scale) = (true, norm);
            }
            let relative = residual / norm;
            let report = |status| Report { iterations, residual: relative, status };
            if residual <= tolerance * norm {
                return report(Status::Converged);
            }
            if iterations == limit {
                return report(Status::LimitReached);
            }
            if stall.is_reached(iterations, residual) {
                return report(Status::Stalled);
            }
            self.hierarchy.precondition();
            let (rz, qz) = self.dots(scale);
            self.turn(if start { 0.0 } else { -alpha * qz / old }, scale);
            alpha = rz / self.product();
            // Negative curvature, or numbers beyond all bounds: rounding has won.
            if !(alpha > 0.0 && alpha.is_finite()) {
                return report(Status::Stalled);
            }
            (old, scale, start) = (rz, residual, false);
            residual = self.advance(alpha, scale);
        }
        Report { iterations: limit, residual: residual / norm, status: Status::LimitReached }
    }

    /// `r = rhs - K x`; the V-cycle's b becomes `r / scale`; returns `|r|`.
    fn residual(&mut self, rhs: &[f64], scale: f64) -> f64 {
        let row_len = self.layout.row_len();
        let Self { layout, bands, fine, constraints, x, r, work, sums, hierarchy, .. } = self;
        let b = &mut hierarchy.levels[0].b;
        let parts = (
            (bands.part(r, row_len), bands.part(b, row_len)),
            bands.part(sums, 1),
            Part::one_each(work),
        );
        let rhs_len = layout.components * layout.lattice.nodes()[2];
        bands.each(parts, |band, ((r, b), sums, work)| {
            let rows = bands.range(band);
            let start = rows.start;
            fine.product(x, rows, &mut work.data[0], |row, product| {
                let here = (row - start) * row_len;
                let (r, b) = (&mut r.data[here..][..row_len], &mut b.data[here..][..row_len]);
                spread(layout, &rhs[row * rhs_len..][..rhs_len], r);
                constraints.fixed.row(row).iter().for_each(|&place| r[place as usize] = 0.0);
                for c in 0..layout.components {
                    let product = &product[c * layout.wide() + 1..];
                    r[layout.span(c)].iter_mut().zip(product).for_each(|(r, a)| *r -= a);
                }
                b.iter_mut().zip(&*r).for_each(|(b, r)| *b = (r / scale) as f32);
                sums.data[row - start] = dot(r, r);
            });
        });
        sums.iter().sum::<f64>().sqrt()
    }

    /// `(r . z, q . z)` with `z = scale x` of the V-cycle.
    fn dots(&mut self, scale: f64) -> (f64, f64) {
        let row_len = self.layout.row_len();
        let Self { bands, r, q, hierarchy, sums, more_sums, .. } = self;
        let z = &hierarchy.levels[0].x;
        bands.each((bands.part(sums, 1), bands.part(more_sums, 1)), |band, (rz, qz)| {
            let rows = bands.range(band);
            for (row, (rz, qz)) in rows.zip(rz.data.iter_mut().zip(qz.data)) {
                let all = row * row_len..(row + 1) * row_len;
                let (z, r, q) = (&z[all.clone()], &r[all.clone()], &q[all]);
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || (*rz, *qz) = (mixed_dot(z, r), mixed_dot(z, q)),
                );
            }
        });
        (sums.iter().sum::<f64>() * scale, more_sums.iter().sum::<f64>() * scale)
    }

    /// `p = z + beta p`.
    fn turn(&mut self, beta: f64, scale: f64) {
        let row_len = self.layout.row_len();
        let Self { bands, p, hierarchy, .. } = self;
        let z = &hierarchy.levels[0].x;
        bands.each(bands.part(p, row_len), |band, p| {
            let z = &z[bands.range(band).start * row_len..];
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || {
                    for (p, z) in p.data.iter_mut().zip(z) {
                        // A product with 0 would keep the NaN of a failed solve.
                        let before = if beta == 0.0 { 0.0 } else { beta * *p };
                        *p = scale * f64::from(*z) + before;
                    }
                },
            );
        });
    }

    /// `q = K p`; returns `p . q`.
    fn product(&mut self) -> f64 {
        let row_len = self.layout.row_len();
        let Self { layout, bands, fine, p, q, work, sums, .. } = self;
        let parts = (bands.part(q, row_len), bands.part(sums, 1), Part::one_each(work));
        bands.each(parts, |band, (q, sums, work)| {
            let rows = bands.range(band);
            let start = rows.start;
            fine.product(p, rows, &mut work.data[0], |row, product| {
                let p = &p[row * row_len..][..row_len];
                let q = &mut q.data[(row - start) * row_len..][..row_len];
                for c in 0..layout.components {
                    let span = layout.span(c);
                    q[span.clone()]
                        .copy_from_slice(&product[c * layout.wide() + 1..][..span.len()]);
                }
                sums.data[row - start] = dot(p, q);
            });
        });
        sums.iter().sum()
    }

    /// `x += alpha p`, `r -= alpha q`; the V-cycle's b becomes `r / scale`; returns `|r|`.
    fn advance(&mut self, alpha: f64, scale: f64) -> f64 {
        let row_len = self.layout.row_len();
        let Self { bands, x, r, p, q, sums, hierarchy, .. } = self;
        let b = &mut hierarchy.levels[0].b;
        let parts = (
            (bands.part(x, row_len), bands.part(r, row_len)),
            bands.part(b, row_len),
            bands.part(sums, 1),
        );
        let inverse = 1.0 / scale;
        bands.each(parts, |band, ((x, r), b, sums)| {
            let vectors = x.data.chunks_exact_mut(row_len).zip(r.data.chunks_exact_mut(row_len));
            let vectors = vectors.zip(b.data.chunks_exact_mut(row_len)).zip(sums.data);
            for (row, (((x, r), b), sum)) in bands.range(band).zip(vectors) {
                let (p, q) = (&p[row * row_len..][..row_len], &q[row * row_len..][..row_len]);
                pulp::Arch::new().dispatch(
                    #[inline(always)]
                    || {
                        x.iter_mut().zip(p).for_each(|(x, p)| *x += alpha * p);
                        r.iter_mut().zip(q).for_each(|(r, q)| *r -= alpha * q);
                        b.iter_mut().zip(&*r).for_each(|(b, r)| *b = (r * inverse) as f32);
                        *sum = dot(r, r);
                    },
                );
            }
        });
        sums.iter().sum::<f64>().sqrt()
    }
}

/// Smallest residual norms of the last iterations.
struct Stall {
    past: [f64; STALL_WINDOW],
    best: f64,
}

impl Stall {
    fn new() -> Self {
        Self { past: [f64::INFINITY; STALL_WINDOW], best: f64::INFINITY }
    }

    /// Whether the norm has not fallen by the factor within the window. The smallest counts:
    /// conjugate gradients lower the error's energy, and the residual only in the long run.
    fn is_reached(&mut self, iteration: usize, residual: f64) -> bool {
        self.best = self.best.min(residual);
        let slot = &mut self.past[iteration % STALL_WINDOW];
        let before = std::mem::replace(slot, self.best);
        self.best > STALL_FACTOR * before || !residual.is_finite()
    }
}

/// Sum of products, in eight interleaved parts: a vector's lanes.
#[inline(always)]
fn mixed_dot(a: &[f32], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for i in 0..8 {
            sums[i] += f64::from(a[i]) * b[i];
        }
    }
    sums.iter().sum()
}
