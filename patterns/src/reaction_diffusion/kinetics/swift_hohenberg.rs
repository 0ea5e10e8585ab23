//! Swift and Hohenberg's fourth-order equation of pattern-forming convection.
//!
//! Explicit steps need the Laplacian of the Laplacian, which reaches two cells
//! far. It is carried as a second field `w = lap u`, which the first of two
//! sweeps per step fills: both sweeps then reach one cell only. The other steppers
//! have the operator as a linear part, -(k0^2 - s)^2 at the Laplacian's symbol s, and
//! r u + g u^2 - u^3 as the reaction.

use super::{Kinetics, range, reaction};
use crate::reaction_diffusion::grown::Stretchable;
use crate::reaction_diffusion::stepper::{self, Setup, Stepper};
use crate::{Preset, Result};
use solvers::Grid;
use solvers::diffusion::explicit::{Cell, Kernel, Parameter, Real, Rows, Stencil};
use solvers::spectral::LinearPart;

/// Registry entry.
pub static KINETICS: Kinetics = Kinetics {
    name: "swift-hohenberg",
    equations: "u: r u - (k0^2 + lap)^2 u + g u^2 - u^3",
    source: "Swift and Hohenberg 1977; Cross and Hohenberg 1993",
    species: &["u"],
    parameters: &[range("r", -10.0, 10.0), range("g", -10.0, 10.0), range("k0", 0.0, 2.0)],
    defaults: DEFAULTS,
    presets: PRESETS,
    explicit,
    linear: Some(linear),
    reaction: reaction::<SwiftHohenberg, 1, 3>,
};

/// The reaction of one cell, without the linear operator.
struct SwiftHohenberg;

impl Cell<1, 3> for SwiftHohenberg {
    #[inline(always)]
    fn rates<T: Real>([u]: [T; 1], [r, g, _]: [T; 3]) -> [T; 1] {
        [r * u + (g - u) * u * u]
    }
}

fn linear(parameters: &[Parameter]) -> Option<Vec<LinearPart>> {
    let Parameter::Uniform(k0) = *parameters.get(2)? else { return None };
    Some(vec![LinearPart::new(move |s| -(k0 * k0 - s) * (k0 * k0 - s))])
}

const DEFAULTS: &str = r#"
size = [128, 128]
iterations = 8000
dt = 0.05
boundary = "periodic"
clamp = false
diffusion = {}
initial = { u = 0.0 }
ink = { species = "u", level = "mean", below = false }
curve = { speed = "off" }
perturbation = [{ target = "u", kind = "noise", amplitude = 0.1, region = "all" }]
"#;

pub(crate) const PRESETS: &[Preset] = &[
    Preset {
        name: "swift-hohenberg-stripes",
        about: "Stripes, as convection rolls; wavelength 8 cells",
        config: "kinetics = 'swift-hohenberg'\n\
                 parameters = { r = 0.2, g = 0.0, k0 = 0.7853981633974483 }",
    },
    Preset {
        name: "swift-hohenberg-spots",
        about: "Spots, by the quadratic term; wavelength 8 cells",
        config: "kinetics = 'swift-hohenberg'\n\
                 parameters = { r = 0.02, g = 1.2, k0 = 0.7853981633974483 }",
    },
];

/// The two sweeps of a step; species 0 is u, species 1 its Laplacian.
#[derive(Clone, Debug)]
struct Sweeps<T> {
    stencil: Stencil,
    volumetric: bool,
    dt: T,
    scale: T,
    /// r, g, k0: a value per node, or one row.
    parameters: [Vec<T>; 3],
}

fn explicit(setup: &Setup) -> Result<Box<dyn Stepper>> {
    // The largest |symbol| of -(k0^2 + lap)^2 limits the step as in any Euler method.
    let k0 = (0..setup.grid.len()).map(|n| setup.parameters[2].at(n)).fold(0.0, f64::max);
    let largest = setup.stencil.max_symbol(setup.grid);
    setup.check_rate((largest - k0 * k0).powi(2).max(k0.powi(4)))?;
    setup.check_double()?;
    stepper::explicit_kernel(setup, kernel::<f64>(setup)?)
}

fn kernel<T: Real>(setup: &Setup) -> Result<Sweeps<T>> {
    let parameters: [Parameter; 3] = stepper::array(&setup.parameters)?;
    Ok(Sweeps {
        stencil: setup.stencil,
        volumetric: setup.grid.shape()[0] > 1,
        dt: T::from_f64(setup.dt),
        scale: T::from_f64(setup.stencil.scale(setup.grid)),
        parameters: parameters.map(|parameter| match parameter {
            Parameter::Uniform(value) => vec![T::from_f64(value); setup.grid.shape()[2]],
            Parameter::Map(field) => field.as_slice().iter().map(|&v| T::from_f64(v)).collect(),
        }),
    })
}

impl<T: Real> Stretchable for Sweeps<T> {
    fn scale_laplacian(&mut self, grid: Grid, _: &[f64], factor: f64) {
        self.scale = T::from_f64(self.stencil.scale(grid) * factor);
    }
}

impl<T: Real> Kernel<T> for Sweeps<T> {
    fn species(&self) -> usize {
        2
    }

    fn phases(&self) -> usize {
        2
    }

    #[inline(always)]
    fn row(&self, phase: usize, first: usize, rows: &Rows<'_, T>, out: &mut [T], _: &mut [T]) {
        let nx = rows.cells;
        let (u, w) = (&rows.center[1..][..nx], &rows.center[rows.stride + 1..][..nx]);
        let (out_u, out_w) = out.split_at_mut(rows.stride);
        let (out_u, out_w) = (&mut out_u[1..][..nx], &mut out_w[1..][..nx]);
        if phase == 0 {
            out_u.copy_from_slice(u);
            self.stencil.sum_row(self.volumetric, 0, rows, out_w);
            out_w.iter_mut().for_each(|w| *w = *w * self.scale);
            return;
        }
        out_w.copy_from_slice(w);
        // Until the end of the loop, `out_u` holds the sum that makes the Laplacian of w.
        self.stencil.sum_row(self.volumetric, 1, rows, out_u);
        let [r, g, k0] = [0, 1, 2].map(|p| {
            let values = &self.parameters[p];
            let first = if values.len() == nx { 0 } else { first };
            &values[first..][..nx]
        });
        let two = T::from_f64(2.0);
        for i in 0..nx {
            let square = k0[i] * k0[i];
            let linear = r[i] * u[i] - square * (square * u[i] + two * w[i]);
            let rate = linear - self.scale * out_u[i] + (g[i] - u[i]) * u[i] * u[i];
            out_u[i] = u[i] + self.dt * rate;
        }
    }
}
