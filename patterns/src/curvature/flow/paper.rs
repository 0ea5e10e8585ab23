//! The published flow: Adam on the vector potential.

use super::StepInfo;
use crate::curvature::energy::{Energy, Scalar};
use crate::curvature::{Mask, Potential};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use solvers::optimize::{Adam, AdamConfig};
use solvers::random::{stream, uniform};
use solvers::slab::planes_per_slab;
use solvers::{Aligned, Result};

/// Constants of the published flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperConfig {
    /// Of Adam; its epsilon is 1e-2, and matters once gradients have fallen to its size.
    pub adam: AdamConfig,
}

impl Default for PaperConfig {
    fn default() -> Self {
        Self { adam: AdamConfig { epsilon: 1e-2, ..AdamConfig::default() } }
    }
}

/// Adam on A, with `u = k * (div A + m0)`: the mean of u is that of m0. Song 2021, algorithm 1.
#[derive(Clone, Debug)]
pub struct Paper<T> {
    config: PaperConfig,
    energy: Energy<T>,
    potential: Potential<T>,
    mask: Option<Mask<T>>,
    /// A, mean gradient, mean squared gradient; components along z, y, x.
    state: [[Aligned<T>; 3]; 3],
    steps: u64,
    u: Aligned<T>,
    gradient: Aligned<T>,
    between: Aligned<T>,
    norms: Vec<f64>,
    /// A plane of differences and one of zeros for each slab.
    planes: Vec<Aligned<T>>,
}

/// The published start `A = 40 dx U`, U uniform in [0, 1): components along z, y, x.
pub fn start<T: Scalar>(voxels: usize, dx: f64, seed: u64) -> [Vec<T>; 3] {
    [0, 1, 2].map(|axis| {
        let mut stream = stream(seed, "curvature potential", axis);
        (0..voxels).map(|_| T::from_f64(40.0 * dx * uniform(&mut stream))).collect()
    })
}

impl<T: Scalar> Paper<T> {
    /// The published start, `A = 40 dx U` with U uniform in [0, 1) at each voxel.
    ///
    /// # Errors
    /// If a constant is out of its range.
    pub fn new(
        energy: Energy<T>,
        potential: Potential<T>,
        config: PaperConfig,
        seed: u64,
    ) -> Result<Self> {
        let a = start(energy.voxels(), energy.config().dx, seed);
        Self::from_potential(energy, potential, config, a)
    }

    /// From a given A.
    ///
    /// # Errors
    /// If a constant is out of its range.
    ///
    /// # Panics
    /// If A has not one number per voxel and component.
    pub fn from_potential(
        energy: Energy<T>,
        potential: Potential<T>,
        config: PaperConfig,
        a: [Vec<T>; 3],
    ) -> Result<Self> {
        config.adam.check()?;
        let n = energy.voxels();
        assert!(a.iter().all(|a| a.len() == n), "one number per voxel");
        let zeros = || Aligned::new(n, T::from_f64(0.0));
        let a = a.map(|a| Aligned::from(&a[..]));
        let state = [a, [zeros(), zeros(), zeros()], [zeros(), zeros(), zeros()]];
        let norms = vec![0.0; energy.config().shape[0]];
        let (u, gradient, between) = (zeros(), zeros(), zeros());
        let (mask, planes) = (None, Vec::new());
        let mut flow = Self {
            config,
            energy,
            potential,
            mask,
            state,
            steps: 0,
            u,
            gradient,
            between,
            norms,
            planes,
        };
        flow.compute_phase();
        Ok(flow)
    }

    /// Gives u at some voxels.
    #[must_use]
    pub fn with_mask(mut self, mask: Mask<T>) -> Self {
        self.mask = Some(mask);
        self.compute_phase();
        self
    }

    /// Evaluates, then steps.
    ///
    /// # Errors
    /// If the energy or its gradient is not finite; the state is then of no use.
    pub fn step(&mut self) -> Result<StepInfo> {
        let energy = self.energy.value_and_gradient(&self.u, &mut self.gradient);
        let info = StepInfo { iteration: self.steps, energy, gradient_norm: 0.0 }.check()?;
        if let Some(mask) = &self.mask {
            mask.clear(&mut self.gradient);
        }
        self.potential.blur_gradient(&mut self.gradient, &mut self.between);
        self.steps += 1;
        let gradient_norm = self.update();
        self.compute_phase();
        StepInfo { gradient_norm, ..info }.check()
    }

    fn compute_phase(&mut self) {
        let a = [0, 1, 2].map(|axis| &self.state[0][axis][..]);
        self.potential.phase(a, &mut self.between, &mut self.u);
        if let Some(mask) = &self.mask {
            mask.fix(&mut self.u);
        }
    }

    /// Adam's update, with the gradient taken from differences of the blurred one.
    fn update(&mut self) -> f64 {
        let shape @ [nz, ny, nx] = self.energy.config().shape;
        let adam = Adam::new(&self.config.adam, self.steps);
        let factor = self.potential.factor();
        let blurred = &self.gradient[..];
        let slab = planes_per_slab(nz, blurred.len());
        let size = slab * ny * nx;
        self.planes.resize_with(nz.div_ceil(slab), || Aligned::new(2 * ny * nx, T::from_f64(0.0)));
        let [a, m, v] = &mut self.state;
        let parts = a.iter_mut().zip(m).zip(v).map(|((a, m), v)| {
            let parts = a.par_chunks_mut(size).zip(m.par_chunks_mut(size));
            parts.zip(v.par_chunks_mut(size))
        });
        let mut parts = parts;
        let (Some(z), Some(y), Some(x)) = (parts.next(), parts.next(), parts.next()) else {
            return 0.0;
        };
        let norms = self.norms.par_chunks_mut(slab);
        let all = z.zip(y).zip(x).zip(norms).zip(self.planes.par_iter_mut()).enumerate();
        all.for_each(|(index, ((((z, y), x), norms), planes))| {
            let state = [z, y, x].map(|((a, m), v)| [a, m, v]);
            let first = index * slab;
            let update = Update { shape, adam, factor, blurred, first, state, norms, planes };
            Arch::new().dispatch(update);
        });
        self.norms.iter().sum::<f64>().sqrt()
    }

    /// The phase field of the current A, shape `[nz, ny, nx]`.
    pub fn phase(&self) -> &[T] {
        &self.u
    }

    /// Its energy's constants and measures.
    pub fn energy(&self) -> &Energy<T> {
        &self.energy
    }

    /// Steps made.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// A, mean gradient, mean squared gradient, each along z, y, x: with [`Paper::steps`] all
    /// that a checkpoint needs.
    pub fn state(&self) -> &[[Aligned<T>; 3]; 3] {
        &self.state
    }

    /// Takes up a state of [`Paper::state`] after `steps` steps.
    ///
    /// # Panics
    /// If it has not one number per voxel.
    pub fn restore(&mut self, state: [[Vec<T>; 3]; 3], steps: u64) {
        let n = self.energy.voxels();
        assert!(state.iter().flatten().all(|values| values.len() == n), "one number per voxel");
        self.state = state.map(|fields| fields.map(|values| Aligned::from(&values[..])));
        self.steps = steps;
        self.compute_phase();
    }
}

/// Adam's update of a slab of planes.
struct Update<'a, T> {
    shape: [usize; 3],
    adam: Adam<T>,
    factor: T,
    blurred: &'a [T],
    first: usize,
    state: [[&'a mut [T]; 3]; 3],
    norms: &'a mut [f64],
    planes: &'a mut [T],
}

impl<T: Scalar> NullaryFnOnce for Update<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { shape: [nz, ny, nx], adam, factor, blurred, first, state, norms, planes } = self;
        let [[az, mz, vz], [ay, my, vy], [ax, mx, vx]] = state;
        let size = ny * nx;
        let (difference, none) = planes.split_at_mut(size);
        for (index, norm) in norms.iter_mut().enumerate() {
            let k = first + index;
            let plane = |k: usize| &blurred[k % nz * size..][..size];
            let own = index * size..(index + 1) * size;
            let center = plane(k);
            let near = [plane(k + 1), plane(k + nz - 1)];
            let state = [&mut az[own.clone()], &mut mz[own.clone()], &mut vz[own.clone()]];
            *norm = adam.update(state, near, factor);
            // Long stretches: the tails of single numbers are as dear as the rest of a row.
            let row = |j: usize| &center[j % ny * nx..][..nx];
            let last = (ny - 1) * nx;
            let stretches = [
                (0..nx, [row(1), row(ny - 1)]),
                (nx..last, [&center[2 * nx..], &center[..last - nx]]),
                (last..size, [row(0), row(ny - 2)]),
            ];
            for (stretch, near) in stretches {
                let at = index * size + stretch.start..index * size + stretch.end;
                let state = [&mut ay[at.clone()], &mut my[at.clone()], &mut vy[at]];
                *norm += adam.update(state, near, factor);
            }
            for (row, out) in center.chunks_exact(nx).zip(difference.chunks_exact_mut(nx)) {
                let inner = out[1..nx - 1].iter_mut();
                for ((out, &west), &east) in inner.zip(&row[..nx - 2]).zip(&row[2..]) {
                    *out = east - west;
                }
                out[0] = row[1] - row[nx - 1];
                out[nx - 1] = row[0] - row[nx - 2];
            }
            let state = [&mut ax[own.clone()], &mut mx[own.clone()], &mut vx[own]];
            *norm += adam.update(state, [difference, none], factor);
        }
    }
}
