//! Pictures, curves and outlines of a design.

use super::{config::Config, problem::Problem};
use crate::{Artifact, Axis, Colors, Image, Mark, Plot, Series};
use solvers::{
    Field,
    isosurface::{self, Caps},
};

/// Mean of `4 rho (1 - rho)`: 0 for black and white, 1 for grey (Sigmund 2007, M_nd).
pub(super) fn greyness(rho: &[f64]) -> f64 {
    rho.iter().map(|x| 4.0 * x * (1.0 - x)).sum::<f64>() / rho.len() as f64
}

/// Densities as ink: black is solid.
pub(super) fn ink(mut density: Field) -> Image {
    density.as_mut_slice().iter_mut().for_each(|v| *v = 1.0 - *v);
    Image {
        name: "ink".into(),
        field: density,
        label: "density".into(),
        colors: Colors::Ink,
        range: Some([0.0, 1.0]),
        contour: None,
    }
}

/// `0.5 - density`: negative inside the part.
pub(super) fn phi(density: &Field) -> Field {
    let mut phi = density.clone();
    phi.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 - *v);
    phi
}

/// Everything that is drawn or saved.
pub(super) fn artifacts(
    config: &Config,
    problem: &Problem,
    density: &Field,
    history: &[[f64; 3]],
    objective: &str,
) -> Vec<Artifact> {
    let mut artifacts = vec![
        Artifact::Image(ink(density.clone())),
        Artifact::Image(Image {
            name: "density".into(),
            field: density.clone(),
            label: "density (1)".into(),
            colors: Colors::Sequential,
            range: Some([0.0, 1.0]),
            contour: None,
        }),
    ];
    let phi = phi(density);
    if problem.grid.dim() == 3 {
        if let Ok(mesh) = isosurface::triangulate(&phi, 0.0, Caps::Closed) {
            artifacts.push(Artifact::Mesh { name: "part".into(), mesh });
        }
    } else {
        let mut lines = isosurface::closed_contours(&phi, 0.0);
        // Elements are unit squares: their middles lie half an edge from the corner.
        lines.iter_mut().flat_map(|line| &mut line.points).for_each(|[x, y]| {
            *x += 0.5;
            *y += 0.5;
        });
        let [_, ny, nx] = problem.grid.shape();
        let size = [nx as f64, ny as f64];
        artifacts.push(Artifact::Contour { name: "outline".into(), lines, size });
    }
    artifacts.extend(curves(config, history, objective));
    artifacts
}

/// Objective, volume and change against the iteration.
fn curves(config: &Config, history: &[[f64; 3]], objective: &str) -> Vec<Artifact> {
    let curve = |n: usize| -> Vec<[f64; 2]> {
        history.iter().enumerate().map(|(i, h)| [i as f64 + 1.0, h[n]]).collect()
    };
    let plot = |name: &str, label: &str, log: bool, series: Vec<(&str, usize)>| {
        let y = if log { Axis::log(label) } else { Axis::linear(label) };
        let series = series.into_iter().map(|(label, n)| Series {
            label: label.into(),
            points: curve(n),
            mark: Mark::Line,
        });
        let about = &config.problem.name;
        Artifact::Plot(Plot {
            name: name.into(),
            title: if about.is_empty() { label.into() } else { format!("{about}: {label}") },
            x: Axis::linear("iteration"),
            y,
            series: series.collect(),
        })
    };
    let positive = history.iter().all(|h| h[0] > 0.0);
    vec![
        plot(
            "convergence",
            &format!("{objective} (force x length)"),
            positive,
            vec![(objective, 0)],
        ),
        plot("change", "fraction (1)", true, vec![("volume", 1), ("greatest change", 2)]),
    ]
}
