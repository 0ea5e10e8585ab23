//! The phase-field energy of curvature polynomials and its gradient, in one pass.
//!
//! F(u) = dx^3 sum of c1 M + c2 T S + c3 T^2 + c4 n T + c5 n S + c6 |g|^2 + mu eps (theta . g)^2
//! (`local.rs` has the symbols), with c1 = (a20 + a02 - a11) / 2 eps, c2 = (a20 - a02) / 2 eps,
//! c3 = a11 / 2 eps, c4 = (b10 + b01) / 2, c5 = (b10 - b01) / 2, c6 = c eps. Song 2021,
//! "Generation of tubular and membranous shape textures with curvature functionals", eq. (20).

mod assemble;
mod edges;
mod local;
mod measures;
mod row;
mod rows;
mod slab;

pub use edges::Edges;

use super::Coefficients;
use local::{Constants, Weights};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use slab::{Job, Source, Spread, Work};
use solvers::slab::planes_per_slab;
use solvers::{Error, Float, Result};

/// One number, or a value at each voxel.
#[derive(Clone, Debug, PartialEq)]
pub enum Spatial {
    /// The same everywhere.
    Uniform(f64),
    /// A value at each voxel, of shape `[nz, ny, nx]`, row-major.
    Map(Vec<f64>),
}

/// A preferred direction of the surface: `mu eps (theta . grad u)^2` is added to the density.
///
/// With `mu > 0` the surface's normals avoid theta: tubes and sheets run along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Orientation {
    /// Strength, 1/length^2 times that of `c`.
    pub mu: Spatial,
    /// Components along z, y, x (no unit).
    pub theta: [Spatial; 3],
}

/// What an [`Energy`] is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct EnergyConfig {
    /// Voxels `[nz, ny, nx]`, at least 4 each.
    pub shape: [usize; 3],
    /// Distance of voxels (length), positive.
    pub dx: f64,
    /// Width of the phase field's transition (length), positive; twice `dx` in the paper.
    pub eps: f64,
    /// Least length of a gradient (1/length), positive: `n = sqrt(|grad u|^2 + xi^2)`.
    pub xi: f64,
    /// Width of the softplus that stands for the positive part (1), positive.
    pub width: f64,
    /// What stands beyond the box.
    pub edges: Edges,
    /// `a20, a11, a02, b10, b01, c` as in [`Coefficients`].
    pub coefficients: [Spatial; 6],
    /// A preferred direction.
    pub orientation: Option<Orientation>,
}

impl EnergyConfig {
    /// Uniform coefficients in a periodic box, the published xi = width = 1e-6.
    pub fn new(shape: [usize; 3], dx: f64, eps: f64, coefficients: Coefficients) -> Self {
        Self {
            shape,
            dx,
            eps,
            xi: 1e-6,
            width: 1e-6,
            edges: Edges::Periodic,
            coefficients: coefficients.to_array().map(Spatial::Uniform),
            orientation: None,
        }
    }

    fn check(&self) -> Result<()> {
        for (axis, n) in ["nz", "ny", "nx"].iter().zip(self.shape) {
            if n < 4 {
                return Err(Error::out_of_range(axis, n as f64, "[4, inf)"));
            }
        }
        let positive = [("dx", self.dx), ("eps", self.eps), ("xi", self.xi), ("width", self.width)];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::out_of_range(name, value, "(0, inf)"));
            }
        }
        let voxels = self.shape.iter().product::<usize>();
        let names = ["a20", "a11", "a02", "b10", "b01", "c", "mu", "theta_z", "theta_y", "theta_x"];
        for (name, values) in names.iter().zip(self.spatial()) {
            let values = match values {
                Spatial::Uniform(value) => std::slice::from_ref(value),
                Spatial::Map(values) if values.len() == voxels => values,
                Spatial::Map(values) => {
                    return Err(Error::Shape {
                        name: (*name).into(),
                        actual: vec![values.len()],
                        expected: self.shape.to_vec(),
                    });
                }
            };
            if let Some(&bad) = values.iter().find(|value| !value.is_finite()) {
                return Err(Error::out_of_range(name, bad, "(-inf, inf)"));
            }
        }
        Ok(())
    }

    /// The coefficients, then mu and theta if there are any.
    fn spatial(&self) -> impl Iterator<Item = &Spatial> {
        let orientation = self.orientation.iter();
        let orientation = orientation.flat_map(|o| std::iter::once(&o.mu).chain(&o.theta));
        self.coefficients.iter().chain(orientation)
    }

    /// c1 to c6 and mu eps.
    fn weights(&self, voxel: usize) -> [f64; 6] {
        let [a20, a11, a02, b10, b01, c] =
            [0, 1, 2, 3, 4, 5].map(|i| self.coefficients[i].at(voxel));
        let half = 0.5 / self.eps;
        [
            half * (a20 + a02 - a11),
            half * (a20 - a02),
            half * a11,
            0.5 * (b10 + b01),
            0.5 * (b10 - b01),
            c * self.eps,
        ]
    }

    fn source<T: Float>(&self) -> Source<T> {
        let maps = self.spatial().any(|s| matches!(s, Spatial::Map(_)));
        let uniform = self.weights(0).map(T::from_f64);
        if !maps && self.orientation.is_none() {
            return Source::Uniform(Weights { c: uniform, ..Weights::default() });
        }
        let voxels = self.shape.iter().product::<usize>();
        let varies = self.coefficients.iter().any(|s| matches!(s, Spatial::Map(_)));
        let mut fields: Vec<Spread<T>> = if varies {
            let column = |i: usize| (0..voxels).map(|n| T::from_f64(self.weights(n)[i])).collect();
            (0..6).map(|i| Spread::Map(column(i))).collect()
        } else {
            uniform.map(Spread::Number).to_vec()
        };
        let none = Spatial::Uniform(0.0);
        let orientation = self.orientation.as_ref();
        fields.push(orientation.map_or(&none, |o| &o.mu).spread(self.eps));
        for axis in 0..3 {
            fields.push(orientation.map_or(&none, |o| &o.theta[axis]).spread(1.0));
        }
        Source::Fields(fields)
    }

    fn constants<T: Float>(&self) -> Constants<T> {
        let (first, second) = (0.5 / self.dx, self.eps / (self.dx * self.dx));
        let volume = self.dx * self.dx * self.dx;
        Constants {
            first: T::from_f64(first),
            second: T::from_f64(second),
            mixed: T::from_f64(0.25 * second),
            inverse_eps: T::from_f64(1.0 / self.eps),
            xi2: T::from_f64(self.xi * self.xi),
            width: T::from_f64(self.width),
            inverse_width: T::from_f64(1.0 / self.width),
            sharp: T::from_f64(self.width * T::NEGLIGIBLE),
            to_first: T::from_f64(volume * first),
            to_second: T::from_f64(volume * second),
            to_mixed: T::from_f64(0.25 * volume * second),
            to_well: T::from_f64(volume / self.eps),
        }
    }
}

impl Spatial {
    fn at(&self, voxel: usize) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Map(values) => values[voxel],
        }
    }

    fn spread<T: Float>(&self, factor: f64) -> Spread<T> {
        match self {
            Self::Uniform(value) => Spread::Number(T::from_f64(value * factor)),
            Self::Map(v) => Spread::Map(v.iter().map(|&v| T::from_f64(v * factor)).collect()),
        }
    }
}

/// The energy of phase fields of one shape.
///
/// Storage and arithmetic in `T`, sums in f64. The same bytes result for any number of threads.
#[derive(Clone, Debug)]
pub struct Energy<T> {
    config: EnergyConfig,
    k: Constants<T>,
    source: Source<T>,
    work: Vec<Work<T>>,
    planes: Vec<f64>,
}

impl<T: Scalar> Energy<T> {
    /// # Errors
    /// If a number is out of its range or a map has another shape.
    pub fn new(config: EnergyConfig) -> Result<Self> {
        config.check()?;
        let planes = vec![0.0; config.shape[0]];
        Ok(Self {
            k: config.constants(),
            source: config.source(),
            work: Vec::new(),
            planes,
            config,
        })
    }

    /// What it is made of.
    pub fn config(&self) -> &EnergyConfig {
        &self.config
    }

    /// Number of voxels.
    pub fn voxels(&self) -> usize {
        self.config.shape.iter().product()
    }

    /// F(u); `u` of shape `[nz, ny, nx]`, row-major.
    ///
    /// # Panics
    /// If `u` has another length.
    pub fn value(&mut self, u: &[T]) -> f64 {
        self.evaluate(u, &mut [])
    }

    /// F(u), and dF/du at each voxel into `gradient`.
    ///
    /// # Panics
    /// If `u` or `gradient` has another length than there are voxels.
    pub fn value_and_gradient(&mut self, u: &[T], gradient: &mut [T]) -> f64 {
        assert_eq!(gradient.len(), self.voxels(), "one number per voxel");
        self.evaluate(u, gradient)
    }

    fn evaluate(&mut self, u: &[T], gradient: &mut [T]) -> f64 {
        assert_eq!(u.len(), self.voxels(), "one number per voxel");
        let [nz, ny, nx] = self.config.shape;
        let planes = planes_per_slab(nz, u.len());
        let slabs = nz.div_ceil(planes);
        let general = matches!(self.source, Source::Fields(_));
        if self.work.len() != slabs {
            self.work.resize_with(slabs, || Work::new(self.config.shape, general));
        }
        let edges = self.config.edges;
        let job = Job { shape: self.config.shape, edges, k: self.k, source: &self.source, u };
        let run = |index: usize, energies: &mut [f64], gradient: &mut [T], work: &mut Work<T>| {
            let task = Task { job: &job, first: index * planes, energies, gradient, work };
            T::densities(task);
        };
        let energies = self.planes.par_chunks_mut(planes);
        let work = self.work.par_iter_mut();
        if slabs == 1 {
            run(0, &mut self.planes, gradient, &mut self.work[0]);
        } else if gradient.is_empty() {
            let tasks = energies.zip(work).enumerate();
            tasks.for_each(|(index, (energies, work))| run(index, energies, &mut [], work));
        } else {
            let tasks =
                gradient.par_chunks_mut(planes * ny * nx).zip(energies).zip(work).enumerate();
            tasks.for_each(|(index, ((gradient, energies), work))| {
                run(index, energies, gradient, work);
            });
        }
        if !gradient.is_empty() {
            slab::join(&self.work, edges, [planes, ny * nx], gradient);
        }
        self.planes.iter().sum::<f64>() * self.config.dx.powi(3)
    }
}

/// Floats for which the energy is compiled: once each, in this crate.
pub trait Scalar: Float {
    #[doc(hidden)]
    fn densities(task: Task<'_, '_, Self>);
}

impl Scalar for f32 {
    fn densities(task: Task<'_, '_, Self>) {
        // Maps and directions do without the widest vectors: the compiler's time is longer
        // than what they gain.
        match (task.job.source, Arch::new()) {
            (Source::Uniform(_), arch) => arch.dispatch(Uniform(task)),
            (Source::Fields(_), _) => narrow(General(task)),
        }
    }
}

impl Scalar for f64 {
    fn densities(task: Task<'_, '_, Self>) {
        match task.job.source {
            Source::Uniform(_) => narrow(Uniform(task)),
            Source::Fields(_) => narrow(General(task)),
        }
    }
}

/// At most 256-bit vectors.
fn narrow<F: NullaryFnOnce>(f: F) -> F::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(f);
    }
    f.call()
}

/// A slab of planes.
#[allow(missing_debug_implementations, reason = "it lives for a call")]
pub struct Task<'a, 'b, T> {
    job: &'a Job<'b, T>,
    first: usize,
    energies: &'a mut [f64],
    gradient: &'a mut [T],
    work: &'a mut Work<T>,
}

/// A slab without maps or directions.
struct Uniform<'a, 'b, T>(Task<'a, 'b, T>);

/// Any slab.
struct General<'a, 'b, T>(Task<'a, 'b, T>);

impl<T: Float> NullaryFnOnce for Uniform<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Task { job, first, energies, gradient, work } = self.0;
        job.run::<{ row::UNIFORM }>(first, energies, gradient, work);
    }
}

impl<T: Float> NullaryFnOnce for General<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Task { job, first, energies, gradient, work } = self.0;
        job.run::<{ row::GENERAL }>(first, energies, gradient, work);
    }
}
