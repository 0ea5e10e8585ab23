//! Triangle meshes.

mod bvh;
mod cluster;
mod sample;
mod shading;
mod topology;
mod voxelize;

pub use bvh::{Bvh, Hit, Ray};
pub use cluster::Clustered;
pub use sample::SurfaceSamples;

/// A triangle mesh; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions `[x, y, z]` (length).
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each triangle, as indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Sum of the triangles' areas (length^2).
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| 0.5 * norm(self.double_normal(t))).sum()
    }

    /// Volume inside (length^3), by the divergence theorem; meaningful for closed meshes.
    pub fn volume(&self) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or_default();
        let six_volumes = self.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| minus(self.vertices[v as usize], origin));
            dot(a, cross(b, c))
        });
        six_volumes.sum::<f64>() / 6.0
    }

    /// Unit normals of the triangles, outward; zero where a triangle has no area.
    pub fn triangle_normals(&self) -> Vec<[f64; 3]> {
        (0..self.triangles.len()).map(|t| unit(self.double_normal(t))).collect()
    }

    /// Unit normals at the vertices, averages of the triangles around by area.
    pub fn vertex_normals(&self) -> Vec<[f64; 3]> {
        let mut normals = vec![[0.0; 3]; self.vertices.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let n = self.double_normal(t);
            for &v in corners {
                let sum = &mut normals[v as usize];
                (0..3).for_each(|m| sum[m] += n[m]);
            }
        }
        normals.into_iter().map(unit).collect()
    }

    /// Cross product of two sides of triangle `t`: its normal times twice its area.
    fn double_normal(&self, t: usize) -> [f64; 3] {
        let [a, b, c] = self.triangles[t].map(|v| self.vertices[v as usize]);
        cross(minus(b, a), minus(c, a))
    }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = norm(a);
    if length > 0.0 { a.map(|c| c / length) } else { a }
}
