//! A tree of boxes over triangles: what a ray meets.
//!
//! Nodes have eight children and leaves eight triangles, each a row of `f32` lanes, so
//! that a ray tests eight boxes or triangles at once.

mod build;
mod trace;

use super::TriangleMesh;

/// Lanes of a node and of a leaf.
const WIDTH: usize = 8;

/// One number for each child or triangle.
type Lanes = [f32; WIDTH];

/// A bounding volume hierarchy of a triangle mesh.
///
/// Built top down by the surface area heuristic in bins (Wald 2007); the tree depends on the
/// mesh only, not on the number of threads.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
    root: Child,
    /// Most nodes on the way to a leaf.
    depth: usize,
}

/// Half a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts `[x, y, z]` (length).
    pub origin: [f32; 3],
    /// Where it goes; distances count in its length.
    pub direction: [f32; 3],
    /// What is farther away is not met (lengths of `direction`).
    pub reach: f32,
}

/// Where a ray meets the mesh first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// How far (lengths of the ray's direction).
    pub distance: f32,
    /// Which triangle.
    pub triangle: u32,
    /// Weights of the triangle's corners; their sum is 1.
    pub weights: [f32; 3],
}

/// What a node has in a lane: the number of a node, or with [`LEAF`] of a leaf.
type Child = u32;
/// Marks leaves.
const LEAF: Child = 1 << 31;
/// No child.
const NOTHING: Child = Child::MAX;

/// Boxes of up to eight children: ends along x, y, z; absent ones are never met.
#[derive(Clone, Debug)]
struct Node {
    low: [Lanes; 3],
    high: [Lanes; 3],
    children: [Child; WIDTH],
}

/// Up to eight triangles, the coordinates of their corners; absent ones are NaN.
#[derive(Clone, Debug)]
struct Leaf {
    corners: [[Lanes; 3]; 3],
    triangles: [u32; WIDTH],
}

impl Bvh {
    /// The tree of all triangles whose corners are finite. About 100 bytes a triangle.
    pub fn new(mesh: &TriangleMesh) -> Self {
        build::build(mesh)
    }

    /// The first triangle on the ray, from either side; the lower number of two that are
    /// equally far. Neighbours leave no gap at their common edge.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        pulp::Arch::new().dispatch(trace::Closest { bvh: self, ray })
    }

    /// Whether any triangle is on the ray.
    pub fn occluded(&self, ray: &Ray) -> bool {
        pulp::Arch::new().dispatch(trace::Any { bvh: self, ray })
    }
}
