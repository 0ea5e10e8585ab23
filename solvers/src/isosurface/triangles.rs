//! Marching tetrahedra.

use super::samples::fraction;
use super::{Caps, Frame, Samples};
use crate::mesh::TriangleMesh;
use crate::{Error, Field, Result};

/// Least distance of a vertex from a node, as a fraction of the edge: keeps
/// triangles from collapsing where a node lies on the level.
const MARGIN: f64 = 1e-4;

/// Thickness (cells) of the layer beyond the faces in which caps are drawn.
const SKIN: f64 = 1e-3;

/// The corners of the six tetrahedra of a box (Kuhn 1960), bits of a corner = x, y, z.
///
/// Each is a way from corner 0 to corner 7, one axis at a time; the flag is true
/// where the axes are in an odd order, which mirrors the tetrahedron.
const TETRAHEDRA: [([usize; 4], bool); 6] = [
    ([0, 1, 3, 7], false),
    ([0, 1, 5, 7], true),
    ([0, 2, 3, 7], true),
    ([0, 2, 6, 7], false),
    ([0, 4, 5, 7], false),
    ([0, 4, 6, 7], true),
];

/// Surface `phi = level` of a field in space, outward from `phi < level`.
///
/// Marching tetrahedra: every mesh is a manifold, closed with [`Caps::Closed`]
/// and wherever it does not meet the border, its vertices shared, its order that
/// of the boxes. Vertices lie on the linear interpolant: second order.
///
/// # Errors
/// If the field has not three axes.
pub fn triangulate(phi: &Field, level: f64, caps: Caps) -> Result<TriangleMesh> {
    Ok(surface(phi, level, caps)?.mesh)
}

/// A surface that knows where it was closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: TriangleMesh,
    /// Whether each triangle closes the surface along the border of the box.
    pub caps: Vec<bool>,
}

/// As [`triangulate`], with the caps marked.
///
/// # Errors
/// If the field has not three axes.
pub fn surface(phi: &Field, level: f64, caps: Caps) -> Result<Surface> {
    if phi.grid().dim() != 3 {
        return Err(Error::out_of_range("number of axes", phi.grid().dim() as f64, "[3, 3]"));
    }
    let frame = match caps {
        Caps::Open => Frame::Nodes,
        Caps::Closed => Frame::Capped,
        Caps::Periodic => Frame::Wrapped,
        Caps::PeriodicClosed => Frame::WrappedCapped,
    };
    let samples = Samples::new(phi, level, frame, SKIN);
    let [_, ny, nx] = samples.shape;
    let mut builder = Builder {
        samples: &samples,
        planes: [vec![[u32::MAX; 7]; nx * ny], vec![[u32::MAX; 7]; nx * ny]],
        mesh: TriangleMesh::default(),
    };
    march(&samples, &mut builder);
    let mesh = builder.mesh;
    let caps = match caps {
        Caps::Open | Caps::Periodic => vec![false; mesh.triangles.len()],
        Caps::Closed | Caps::PeriodicClosed => mark_caps(&samples, &mesh),
    };
    Ok(Surface { mesh, caps })
}

/// The triangles beyond one face of the box that lie along it: the others there continue the
/// surface through the layer.
fn mark_caps(samples: &Samples, mesh: &TriangleMesh) -> Vec<bool> {
    // Faces along x, y, z.
    let faces = [2, 1, 0].map(|axis| {
        let x = &samples.coordinates[axis];
        [x[1], x[x.len() - 2]]
    });
    let is_cap = |(t, normal): (&[u32; 3], [f64; 3])| {
        let corners = t.map(|v| mesh.vertices[v as usize]);
        (0..3).any(|axis| {
            let [low, high] = faces[axis];
            normal[axis].abs() > 0.5
                && (corners.iter().all(|p| p[axis] <= low)
                    || corners.iter().all(|p| p[axis] >= high))
        })
    };
    mesh.triangles.iter().zip(mesh.triangle_normals()).map(is_cap).collect()
}

/// Receives the pieces of a cut lattice of tetrahedra.
pub(crate) trait Visit {
    /// A triangle whose corners lie on edges (inside sample, outside sample).
    fn triangle(&mut self, corners: [(usize, usize); 3]);
    /// A tetrahedron that is cut, of six equal parts of a box: the inside fraction of it.
    fn part(&mut self, fraction: f64, box_corner: usize);
    /// A box that lies inside.
    fn full(&mut self, box_corner: usize);
    /// The boxes between sample planes `k` and `k + 1` follow.
    fn plane(&mut self, _k: usize) {}
}

/// Walks all boxes, plane by plane.
pub(crate) fn march(samples: &Samples, visitor: &mut impl Visit) {
    let [nz, ny, nx] = samples.shape;
    let offset: [usize; 8] =
        std::array::from_fn(|c| (c & 1) + (c >> 1 & 1) * nx + (c >> 2) * nx * ny);
    for k in 0..nz.saturating_sub(1) {
        visitor.plane(k);
        for j in 0..ny.saturating_sub(1) {
            for i in 0..nx.saturating_sub(1) {
                let n = (k * ny + j) * nx + i;
                let v = offset.map(|o| samples.values[n + o]);
                let count = v.iter().filter(|&&v| v < 0.0).count();
                if count == 8 {
                    visitor.full(n);
                } else if count > 0 {
                    for (corners, mirrored) in TETRAHEDRA {
                        tetrahedron(visitor, n, &v, &offset, corners, mirrored);
                    }
                }
            }
        }
    }
}

/// Cuts one tetrahedron of the box at sample `n`.
fn tetrahedron(
    visitor: &mut impl Visit,
    n: usize,
    v: &[f64; 8],
    offset: &[usize; 8],
    corners: [usize; 4],
    mirrored: bool,
) {
    // Inside corners first, keeping track of the orientation.
    let mut order = corners;
    let mut odd = mirrored;
    for a in 0..4 {
        for b in (a + 1)..4 {
            if v[order[b]] < 0.0 && v[order[a]] >= 0.0 {
                order.swap(a, b);
                odd = !odd;
            }
        }
    }
    let edge = |a: usize, b: usize| (n + offset[order[a]], n + offset[order[b]]);
    let t = |a: usize, b: usize| fraction(v[order[a]], v[order[b]]);
    let mut triangle = |p, q, r| visitor.triangle(if odd { [p, r, q] } else { [p, q, r] });
    let part = match order.iter().filter(|&&c| v[c] < 0.0).count() {
        0 => return,
        1 => {
            triangle(edge(0, 1), edge(0, 2), edge(0, 3));
            t(0, 1) * t(0, 2) * t(0, 3)
        }
        2 => {
            triangle(edge(0, 2), edge(0, 3), edge(1, 3));
            triangle(edge(0, 2), edge(1, 3), edge(1, 2));
            let (a, b, c, d) = (t(0, 2), t(0, 3), t(1, 2), t(1, 3));
            a * b * (1.0 - d) + a * (1.0 - c) * d + c * d
        }
        3 => {
            triangle(edge(0, 3), edge(1, 3), edge(2, 3));
            1.0 - (1.0 - t(0, 3)) * (1.0 - t(1, 3)) * (1.0 - t(2, 3))
        }
        _ => 1.0,
    };
    visitor.part(part, n);
}

impl Samples {
    /// Where the level crosses the edge from sample `a` to sample `b`, kept `margin` off both.
    pub(crate) fn crossing(&self, a: usize, b: usize, margin: f64) -> [f64; 3] {
        let t = fraction(self.values[a], self.values[b]).clamp(margin, 1.0 - margin);
        let (p, q) = (self.position(a), self.position(b));
        std::array::from_fn(|m| p[m] + t * (q[m] - p[m]))
    }

    /// Position `[x, y, z]` of a sample.
    pub(crate) fn position(&self, n: usize) -> [f64; 3] {
        let [_, ny, nx] = self.shape;
        let [z, y, x] = &self.coordinates;
        [x[n % nx], y[n / nx % ny], z[n / (nx * ny)]]
    }
}

/// Builds a mesh; remembers the vertices on the edges that start in two planes.
struct Builder<'a> {
    samples: &'a Samples,
    /// By the parity of the plane.
    planes: [Vec<[u32; 7]>; 2],
    mesh: TriangleMesh,
}

impl Builder<'_> {
    fn vertex(&mut self, a: usize, b: usize) -> u32 {
        let [_, ny, nx] = self.samples.shape;
        let (low, high) = (a.min(b), a.max(b));
        let apart = high - low;
        // Bits of the step along x, y, z.
        let (dz, rest) = (apart / (nx * ny), apart % (nx * ny));
        let slot = (rest % nx) + 2 * (rest / nx) + 4 * dz - 1;
        let known = &mut self.planes[low / (nx * ny) % 2][low % (nx * ny)][slot];
        if *known == u32::MAX {
            *known = self.mesh.vertices.len() as u32;
            self.mesh.vertices.push(self.samples.crossing(a, b, MARGIN));
        }
        *known
    }
}

impl Visit for Builder<'_> {
    fn triangle(&mut self, corners: [(usize, usize); 3]) {
        let triangle = corners.map(|(a, b)| self.vertex(a, b));
        self.mesh.triangles.push(triangle);
    }

    fn part(&mut self, _: f64, _: usize) {}

    fn full(&mut self, _: usize) {}

    fn plane(&mut self, k: usize) {
        self.planes[(k + 1) % 2].fill([u32::MAX; 7]);
    }
}
