//! Triangle meshes.

/// A triangle mesh; counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions `[x, y, z]` (length).
    pub vertices: Vec<[f64; 3]>,
    /// Corners of each triangle, as indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
}
