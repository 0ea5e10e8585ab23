//! Pictures, curves and outlines of a design.

use super::{build::Problem, marks};
use crate::{Artifact, Colors, Image};
use solvers::{
    Field, Grid,
    isosurface::{self, Caps},
};

/// Mean of `4 rho (1 - rho)`: 0 for black and white, 1 for grey (Sigmund 2007, M_nd).
pub(super) fn greyness(rho: &[f64]) -> f64 {
    rho.iter().map(|x| 4.0 * x * (1.0 - x)).sum::<f64>() / rho.len() as f64
}

/// 1 for the elements of least `order`, as many as `volume` allows, 0 for the rest.
pub(super) fn threshold(order: &[f64], volume: f64) -> Vec<f64> {
    let mut sorted: Vec<usize> = (0..order.len()).collect();
    sorted.sort_by(|&a, &b| order[a].total_cmp(&order[b]));
    let mut rho = vec![0.0; order.len()];
    let count = (volume * order.len() as f64).round() as usize;
    sorted[..count.min(order.len())].iter().for_each(|&e| rho[e] = 1.0);
    rho
}

/// Densities as ink: black is solid. A solid is seen through along z: black where all of its
/// depth is solid.
pub(super) fn ink(density: Field) -> Image {
    let [nz, ny, nx] = density.grid().shape();
    let flat = Grid::new(&[ny, nx], density.grid().spacing());
    let mut field = flat.map_or_else(|_| density.clone(), |grid| Field::constant(grid, 1.0));
    for (paper, e) in field.as_mut_slice().iter_mut().zip(0..) {
        let column = (0..nz).map(|k| density.as_slice()[k * ny * nx + e]);
        *paper = 1.0 - column.sum::<f64>() / nz as f64;
    }
    Image {
        name: "ink".into(),
        field,
        label: "density".into(),
        colors: Colors::Ink,
        range: Some([0.0, 1.0]),
        contour: None,
        rows: None,
    }
}

/// `0.5 - density`: negative inside the part.
pub(super) fn phi(density: &Field) -> Field {
    let mut phi = density.clone();
    phi.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 - *v);
    phi
}

/// Everything that is drawn or saved.
pub(super) fn artifacts(problem: &Problem, density: &Field) -> Vec<Artifact> {
    let mut artifacts = vec![
        Artifact::Drawing { image: ink(density.clone()), strokes: marks::strokes(problem) },
        Artifact::Image(Image {
            name: "density".into(),
            field: density.clone(),
            label: "density (1)".into(),
            colors: Colors::Sequential,
            range: Some([0.0, 1.0]),
            contour: None,
            rows: None,
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
    artifacts
}
