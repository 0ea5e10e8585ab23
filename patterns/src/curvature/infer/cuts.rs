//! The part of a surface that a box does not cut.

use solvers::{Grid, mesh::TriangleMesh};

/// Voxels along the faces of the box whose curvatures take in what stands beyond, which is not
/// known: their neighbours would.
const FACE: f64 = 1.0;

/// The triangles off the faces of the box, and `margin` voxels from where the surface is cut.
pub(super) fn inner(mesh: &TriangleMesh, grid: Grid, margin: f64) -> TriangleMesh {
    let [nz, ny, nx] = grid.shape();
    let place = |vertex: u32| mesh.vertices[vertex as usize].map(|x| x / grid.spacing());
    let node = |[x, y, z]: [f64; 3]| [z, y, x].map(|x| x.round().max(0.0) as usize);
    let mut near_cuts = vec![false; nz * ny * nx];
    let reach = margin.ceil() as usize;
    let around = |at: usize, n: usize| at.saturating_sub(reach)..(at + reach + 1).min(n);
    let mut cuts: Vec<[usize; 3]> = mesh.border().into_iter().map(|v| node(place(v))).collect();
    cuts.sort_unstable();
    cuts.dedup();
    for [k, j, i] in cuts {
        for (k, j) in around(k, nz).flat_map(|k| around(j, ny).map(move |j| (k, j))) {
            let row = &mut near_cuts[(k * ny + j) * nx..][..nx];
            row[around(i, nx)].fill(true);
        }
    }
    let within = |&vertex: &u32| {
        let place = place(vertex);
        let inside = |(x, n): (&f64, usize)| (FACE..=(n - 1) as f64 - FACE).contains(x);
        let [k, j, i] = node(place);
        place.iter().zip([nx, ny, nz]).all(inside) && !near_cuts[(k * ny + j) * nx + i]
    };
    let kept = |triangle: &&[u32; 3]| triangle.iter().all(within);
    let triangles = mesh.triangles.iter().filter(kept).copied().collect();
    TriangleMesh { triangles, ..mesh.clone() }
}

#[cfg(test)]
mod tests {
    use super::inner;
    use crate::curvature::view;
    use solvers::{Field, Grid, isosurface::Caps};

    /// A ball that touches the faces and is cut by none keeps most of its surface.
    #[test]
    fn a_whole_shape_is_measured_whole() {
        let grid = Grid::new(&[32; 3], 0.01).unwrap();
        let ball = |p: [f64; 3]| {
            let square: f64 = p.iter().map(|x| (x - 0.155).powi(2)).sum();
            0.15 - square.sqrt()
        };
        let phase = Field::from_fn(grid, ball);
        let mesh = view::surface(phase, 0.0, Caps::Open).mesh;
        let part = inner(&mesh, grid, 6.0).area() / mesh.area();
        assert!(part > 0.8, "{part}");
    }
}
