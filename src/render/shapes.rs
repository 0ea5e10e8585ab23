//! Meshes of simple bodies: lines, arrows, boxes.

use solvers::mesh::TriangleMesh;

type P = [f64; 3];

/// Sides of round bodies.
const SIDES: usize = 24;

/// A frustum from `a` to `b` with radii there (length), closed by discs; 0 makes a cone.
pub fn frustum(a: P, b: P, radii: [f64; 2]) -> TriangleMesh {
    let d = [0, 1, 2].map(|m| b[m] - a[m]);
    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
    let d = d.map(|v| v / length.max(f64::MIN_POSITIVE));
    // The axis that is most across.
    let axis = (0..3).min_by(|&m, &n| d[m].abs().total_cmp(&d[n].abs())).unwrap_or(0);
    let mut u = d.map(|v| -v * d[axis]);
    u[axis] += 1.0;
    let norm = u.iter().map(|v| v * v).sum::<f64>().sqrt();
    let u = u.map(|v| v / norm);
    let v = [0, 1, 2].map(|m| d[(m + 1) % 3] * u[(m + 2) % 3] - d[(m + 2) % 3] * u[(m + 1) % 3]);
    let mut mesh = TriangleMesh { vertices: vec![a, b], triangles: Vec::new() };
    for n in 0..SIDES {
        let (sin, cos) = (std::f64::consts::TAU * n as f64 / SIDES as f64).sin_cos();
        for (end, r) in [a, b].into_iter().zip(radii) {
            mesh.vertices.push([0, 1, 2].map(|m| end[m] + r * (cos * u[m] + sin * v[m])));
        }
        let (low, next) = (2 + 2 * n as u32, 2 + 2 * ((n + 1) % SIDES) as u32);
        mesh.triangles.push([0, next, low]);
        mesh.triangles.push([1, low + 1, next + 1]);
        mesh.triangles.push([low, next, next + 1]);
        mesh.triangles.push([low, next + 1, low + 1]);
    }
    mesh
}

/// An arrow from `tail` to `head`; `width` is that of its shaft (length).
pub fn arrow(tail: P, head: P, width: f64) -> TriangleMesh {
    let d = [0, 1, 2].map(|m| head[m] - tail[m]);
    let length = d.iter().map(|v| v * v).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let neck = (1.0 - 3.5 * width / length).max(0.0);
    let neck = [0, 1, 2].map(|m| tail[m] + neck * d[m]);
    let mut mesh = frustum(tail, neck, [0.5 * width; 2]);
    append(&mut mesh, &frustum(neck, head, [1.4 * width, 0.0]));
    mesh
}

/// The twelve edges of a box as bars `width` thick (length).
pub fn frame(low: P, high: P, width: f64) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for axis in 0..3 {
        for n in 0..4 {
            let mut a = low;
            a[(axis + 1) % 3] = if n & 1 == 0 { low } else { high }[(axis + 1) % 3];
            a[(axis + 2) % 3] = if n & 2 == 0 { low } else { high }[(axis + 2) % 3];
            let mut b = a;
            b[axis] = high[axis];
            append(&mut mesh, &frustum(a, b, [0.5 * width; 2]));
        }
    }
    mesh
}

/// Adds the triangles of `other`.
pub fn append(mesh: &mut TriangleMesh, other: &TriangleMesh) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| first + v)));
}
