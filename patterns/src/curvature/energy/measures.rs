//! What is measured in a phase field besides its energy.

use super::local::{Invariants, Jet, invariants, root};
use super::{Energy, Scalar};
use rayon::prelude::*;

impl<T: Scalar> Energy<T> {
    /// Diffuse principal curvatures `kappa_1,2 = (T +- S) / (2 eps n)` (1/length), greater and
    /// lesser, of shape `[nz, ny, nx]`. Song 2021, eqs. (17), (18).
    ///
    /// They are the curvatures of the level sets where u has the profile of a transition, and
    /// without meaning where it is constant.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn curvatures(&self, u: &[T], kappa1: &mut [T], kappa2: &mut [T]) {
        let [nz, ny, nx] = self.config.shape;
        assert!([u.len(), kappa1.len(), kappa2.len()] == [nz * ny * nx; 3], "one number per voxel");
        let scale = T::from_f64(0.5 / self.config.eps);
        let planes = kappa1.par_chunks_mut(ny * nx).zip(kappa2.par_chunks_mut(ny * nx));
        planes.enumerate().for_each(|(k, (kappa1, kappa2))| {
            self.each(u, k, |n, local| {
                let s = root(local.d, &self.k).0;
                kappa1[n] = (local.trace + s) * local.inverse_n * scale;
                kappa2[n] = (local.trace - s) * local.inverse_n * scale;
            });
        });
    }

    /// Normalized discrepancy, from 0 (the profile of a transition everywhere) to 1:
    /// `sum |eps q / 2 - W / eps| / sum (eps q / 2 + W / eps)` with `q = |grad u|^2`,
    /// `W = (1 - u^2)^2 / 4`. Song 2021, eq. (27).
    ///
    /// # Panics
    /// If `u` has not one number per voxel.
    pub fn discrepancy(&self, u: &[T]) -> f64 {
        assert_eq!(u.len(), self.voxels(), "one number per voxel");
        let eps = self.config.eps;
        let plane = |k: usize| {
            let (mut difference, mut sum) = (0.0, 0.0);
            let values = &u[k * self.plane()..];
            self.each(u, k, |n, local| {
                let u = values[n].to_f64();
                let gradient = 0.5 * eps * local.q.to_f64();
                let well = 0.25 * (1.0 - u * u) * (1.0 - u * u) / eps;
                difference += (gradient - well).abs();
                sum += gradient + well;
            });
            [difference, sum]
        };
        let planes: Vec<[f64; 2]> = (0..self.config.shape[0]).into_par_iter().map(plane).collect();
        let [difference, sum] =
            planes.iter().fold([0.0; 2], |total, plane| [total[0] + plane[0], total[1] + plane[1]]);
        if sum > 0.0 { difference / sum } else { 0.0 }
    }

    fn plane(&self) -> usize {
        self.config.shape[1] * self.config.shape[2]
    }

    /// Calls `f` with the voxels of plane `k`, numbered from its first.
    fn each(&self, u: &[T], k: usize, mut f: impl FnMut(usize, &Invariants<T>)) {
        let [nz, ny, nx] = self.config.shape;
        let edges = self.config.edges;
        let near = |i: usize, n: usize| [-1, 0, 1].map(|step| edges.inside(i as isize + step, n));
        let zs = near(k, nz);
        for j in 0..ny {
            let ys = near(j, ny);
            let row = |z: usize, y: usize| &u[(zs[z] * ny + ys[y]) * nx..][..nx];
            let rows: [[&[T]; 3]; 3] = [0, 1, 2].map(|z| [0, 1, 2].map(|y| row(z, y)));
            for i in 0..nx {
                let xs = near(i, nx);
                let at = |z: usize, y: usize, x: usize| rows[z][y][xs[x]];
                let jet = self.jet(at);
                f(j * nx + i, &invariants(&jet, &self.k));
            }
        }
    }

    /// Differences at a voxel from the values around it.
    fn jet(&self, at: impl Fn(usize, usize, usize) -> T) -> Jet<T> {
        let k = &self.k;
        let u = at(1, 1, 1);
        let two = u + u;
        Jet {
            u,
            g: [
                (at(2, 1, 1) - at(0, 1, 1)) * k.first,
                (at(1, 2, 1) - at(1, 0, 1)) * k.first,
                (at(1, 1, 2) - at(1, 1, 0)) * k.first,
            ],
            h: [
                ((at(2, 1, 1) + at(0, 1, 1)) - two) * k.second,
                ((at(1, 2, 1) + at(1, 0, 1)) - two) * k.second,
                ((at(1, 1, 2) + at(1, 1, 0)) - two) * k.second,
                ((at(2, 2, 1) - at(2, 0, 1)) - (at(0, 2, 1) - at(0, 0, 1))) * k.mixed,
                ((at(2, 1, 2) - at(2, 1, 0)) - (at(0, 1, 2) - at(0, 1, 0))) * k.mixed,
                ((at(1, 2, 2) - at(1, 2, 0)) - (at(1, 0, 2) - at(1, 0, 0))) * k.mixed,
            ],
        }
    }
}
