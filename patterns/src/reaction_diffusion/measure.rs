//! What is measured on a pattern, and linear theory's prediction beside it.

use super::curve::Border;
use super::general;
use super::setup::Start;
use crate::{Axis, Mark, Metric, Plot, Result, Series};
use solvers::level_set::{Measures, redistance};
use solvers::spectral::{LaplacianSymbol, RadialSpectrum, Window};
use solvers::stability::{Linearization, steady_state};
use solvers::{Boundary, Field, isosurface};

/// Components of fewer cells are not counted as spots.
const LEAST_CELLS: usize = 4;

/// phi of the ink by threshold: negative where the concentration is ink.
pub(super) fn threshold(border: Border<'_>) -> Field {
    let (level, _) = border.level_std();
    let mut phi = border.c.clone();
    let side = if border.below { 1.0 } else { -1.0 };
    phi.as_mut_slice().iter_mut().for_each(|v| *v = side * (*v - level));
    phi
}

/// `components` of at least 4 cells, `mean_area` (cells), `ink_fraction`, `perimeter`, `euler_number`.
pub(super) fn ink(phi: &Field, boundary: Boundary) -> Vec<Metric> {
    let measures = Measures::of(phi, boundary);
    let (components, mean_area) = measures.components_of_at_least(LEAST_CELLS);
    let inside = phi.as_slice().iter().filter(|&&v| v < 0.0).count() as f64;
    vec![
        Metric::new("components", components as f64, "1"),
        Metric::new("mean_area", mean_area, "cells"),
        Metric::new("ink_fraction", inside / phi.as_slice().len() as f64, "1"),
        Metric::new("perimeter", measures.perimeter, "cells"),
        Metric::new("euler_number", measures.euler_number as f64, "1"),
    ]
}

/// Share of the nodes on whose side the curve and the concentration agree.
pub(super) fn agreement(phi: &Field, border: Border<'_>) -> f64 {
    let (level, _) = border.level_std();
    let pairs = phi.as_slice().iter().zip(border.c.as_slice());
    let agreeing = pairs.filter(|&(&v, &c)| (v < 0.0) == border.is_ink(c, level)).count();
    agreeing as f64 / phi.as_slice().len() as f64
}

/// Mean distance (cells) from the curve to the level line of the concentration, 2D only.
pub(super) fn contour_distance(phi: &Field, border: Border<'_>) -> Result<Option<f64>> {
    let grid = phi.grid();
    if grid.dim() != 2 {
        return Ok(None);
    }
    let mut exact = threshold(border);
    redistance(&mut exact, Boundary::Neumann)?;
    let [_, ny, nx] = grid.shape();
    let at = |[x, y]: [f64; 2]| {
        let (i, j) =
            ((x as usize).min(nx.saturating_sub(2)), (y as usize).min(ny.saturating_sub(2)));
        let (fx, fy) = (x - i as f64, y - j as f64);
        let row = |j: usize| (1.0 - fx) * exact.at(0, j, i) + fx * exact.at(0, j, i + 1);
        ((1.0 - fy) * row(j) + fy * row(j + 1)).abs()
    };
    let lines = isosurface::contour_lines(phi, 0.0);
    let distances: Vec<f64> = lines.iter().flat_map(|line| &line.points).map(|&p| at(p)).collect();
    let count = distances.len();
    Ok((count > 0).then(|| distances.iter().sum::<f64>() / count as f64))
}

/// The radial spectrum of a concentration, by cosine series on mirrored grids.
pub(super) fn spectrum(c: &Field, boundary: Boundary) -> Result<RadialSpectrum> {
    Ok(RadialSpectrum::new(c, boundary, Window::None)?)
}

/// What linear theory says of the homogeneous state.
pub(super) struct Prediction {
    linear: Linearization,
    symbol: LaplacianSymbol,
    /// Greatest growth rate (1/time).
    pub(super) growth: f64,
    /// Wavelength of the fastest growing wave (cells), mean over directions; `None` if
    /// the homogeneous state itself grows fastest.
    pub(super) wavelength: Option<f64>,
}

/// The prediction at the means of the parameters, or `None` where there is no steady
/// state, or a linear part that is not constant.
pub(super) fn predict(start: &Start) -> Result<Option<Prediction>> {
    let reaction = start.mean_reaction()?;
    let Some(parts) = start.linear().and_then(|linear| linear.parts()) else { return Ok(None) };
    let guess: Vec<f64> = start.initial.iter().map(|field| field.mean_std().0).collect();
    let state = steady_state(reaction.as_ref(), 0, &guess)?;
    if !state.converged {
        return Ok(None);
    }
    let linear = Linearization::new(reaction.as_ref(), 0, &state.u, &parts)?;
    let (grid, symbol) = (start.setup.grid, general::symbol(start.setup.stencil));
    let fastest = linear.most_unstable(symbol.largest(grid.dim(), 1.0));
    let wavelength = symbol
        .mean_wavenumber(fastest.symbol, 1.0, grid.dim())
        .filter(|&k| k > 0.0)
        .map(|k| std::f64::consts::TAU / k);
    Ok(Some(Prediction { linear, symbol, growth: fastest.growth, wavelength }))
}

/// Growth rate against wavenumber, with the predicted and the measured wavenumber.
pub(super) fn dispersion_plot(prediction: &Prediction, measured: Option<f64>) -> Plot {
    let wavenumbers: Vec<f64> = (0..=200).map(|n| f64::from(n) * 0.01 * 1.5).collect();
    let curve = prediction.linear.dispersion(prediction.symbol, 1.0, &wavenumbers);
    // Far below the most unstable wave nothing is to be seen.
    let floor = -3.0 * prediction.growth.abs().max(0.02 * spread(&curve.growth));
    let points = curve.wavenumber.iter().zip(&curve.growth).map(|(&k, &g)| [k, g]);
    let mut series = vec![Series {
        label: "growth rate of the homogeneous state".into(),
        points: points.filter(|p| p[1] >= floor).collect(),
        mark: Mark::Line,
    }];
    series.extend(marks(prediction.wavelength, measured));
    Plot {
        name: "dispersion".into(),
        title: "Growth rate against wavenumber".into(),
        x: Axis::linear("wavenumber (1/cell)"),
        y: Axis::linear("growth rate (1/time)"),
        series,
    }
}

fn spread(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    high - low
}

/// Power against wavenumber.
pub(super) fn spectrum_plot(spectrum: &RadialSpectrum, predicted: Option<f64>) -> Plot {
    let points = spectrum.wavenumber.iter().zip(&spectrum.power).map(|(&k, &p)| [k, p]);
    let mut series = vec![Series {
        label: "power of a mode".into(),
        points: points.filter(|p| p[1] > 0.0).collect(),
        mark: Mark::Line,
    }];
    series.extend(marks(predicted, spectrum.peak_wavelength()));
    Plot {
        name: "spectrum".into(),
        title: "Radial power spectrum".into(),
        x: Axis::linear("wavenumber (1/cell)"),
        y: Axis::log("mean power of a mode (concentration^2)"),
        series,
    }
}

/// Vertical lines at the predicted and the measured wavelength (cells).
fn marks(predicted: Option<f64>, measured: Option<f64>) -> Vec<Series> {
    let mark = |name: &str, wavelength: Option<f64>| {
        wavelength.map(|length| Series {
            label: format!("{name} wavelength {length:.3} cells"),
            points: vec![[std::f64::consts::TAU / length, 0.0]],
            mark: Mark::Vertical,
        })
    };
    mark("predicted", predicted).into_iter().chain(mark("measured", measured)).collect()
}
