//! Fewer triangles: the vertices of a cell become one.

use super::TriangleMesh;
use rayon::slice::ParallelSliceMut;

/// A coarser mesh, and where its parts come from.
#[derive(Clone, Debug, Default)]
pub struct Clustered {
    /// The mesh.
    pub mesh: TriangleMesh,
    /// For each vertex one of those that it stands for.
    pub vertices: Vec<u32>,
    /// For each triangle the one that it was.
    pub triangles: Vec<u32>,
}

impl TriangleMesh {
    /// The vertices of each cube of width `cell` (length) become their mean, triangles with two
    /// corners in one cube go: for pictures (Rossignac and Borrel 1993). Sheets thinner than a
    /// cell may collapse.
    ///
    /// # Panics
    /// Unless `cell` is positive.
    pub fn clustered(&self, cell: f64) -> Clustered {
        assert!(cell > 0.0, "cells of width {cell}");
        let all = self.vertices.iter();
        let low = all.fold([f64::INFINITY; 3], |low, p| [0, 1, 2].map(|c| low[c].min(p[c])));
        // 21 bits an axis; what lies farther shares the last cells.
        let key = |p: [f64; 3]| {
            let at = [0, 1, 2].map(|c| (((p[c] - low[c]) / cell) as u64).min((1 << 21) - 1));
            (at[0] << 42) | (at[1] << 21) | at[2]
        };
        let mut order: Vec<(u64, u32)> =
            self.vertices.iter().zip(0..).map(|(&p, n)| (key(p), n)).collect();
        order.par_sort_unstable();
        let mut number = vec![0; self.vertices.len()];
        let mut coarse = Clustered::default();
        for same in order.chunk_by(|a, b| a.0 == b.0) {
            let mut sum = [0.0; 3];
            for &(_, n) in same {
                number[n as usize] = coarse.vertices.len() as u32;
                sum.iter_mut().zip(self.vertices[n as usize]).for_each(|(s, c)| *s += c);
            }
            coarse.vertices.push(same[0].1);
            coarse.mesh.vertices.push(sum.map(|s| s / same.len() as f64));
        }
        for (triangle, n) in self.triangles.iter().zip(0..) {
            let [a, b, c] = triangle.map(|v| number[v as usize]);
            if a != b && b != c && c != a {
                coarse.mesh.triangles.push([a, b, c]);
                coarse.triangles.push(n);
            }
        }
        coarse
    }
}

#[cfg(test)]
mod tests {
    use crate::isosurface::{Caps, surface};
    use crate::{Field, Grid};

    #[test]
    fn a_coarser_ball_is_a_ball() {
        let grid = Grid::new(&[48; 3], 1.0).unwrap();
        let far = |p: [f64; 3]| p.iter().map(|x| (x - 23.3).powi(2)).sum::<f64>().sqrt();
        let ball = Field::from_fn(grid, |p| far(p) - 20.0);
        let mesh = surface(&ball, 0.0, Caps::Closed).unwrap().mesh;
        let coarse = mesh.clustered(2.0);
        let count = coarse.mesh.triangles.len();
        assert!(5 * count < 2 * mesh.triangles.len(), "{count} of {}", mesh.triangles.len());
        // Chords of 2 on a radius of 20 lose (2 / 20)^2 / 8 of it at most.
        assert!((coarse.mesh.area() / mesh.area() - 1.0).abs() < 0.01);
        assert!((coarse.mesh.volume() / mesh.volume() - 1.0).abs() < 0.01);
        for (&[a, ..], &n) in coarse.mesh.triangles.iter().zip(&coarse.triangles) {
            let (new, old) = (coarse.mesh.vertices[a as usize], mesh.triangles[n as usize][0]);
            let old = mesh.vertices[old as usize];
            assert!((0..3).all(|c| (new[c] - old[c]).abs() <= 2.0));
        }
        // Cells smaller than any side change nothing but the order.
        let same = mesh.clustered(3e-5);
        assert_eq!(same.mesh.triangles.len(), mesh.triangles.len());
        assert_eq!(same.mesh.vertices.len(), mesh.vertices.len());
    }
}
