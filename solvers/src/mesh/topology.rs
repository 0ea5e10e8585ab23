//! How the triangles of a mesh hang together.

use super::TriangleMesh;
use rayon::slice::ParallelSliceMut;

impl TriangleMesh {
    /// Sides of all triangles, sorted: low vertex, high vertex, and in the last bit whether the
    /// triangle runs from low to high.
    fn sorted_sides(&self) -> Vec<u64> {
        debug_assert!(self.vertices.len() < 1 << 31);
        let side = |p: u32, q: u32| {
            let (low, high) = (u64::from(p.min(q)), u64::from(p.max(q)));
            (((low << 32) | high) << 1) | u64::from(p < q)
        };
        let all = self.triangles.iter();
        let mut sides: Vec<u64> =
            all.flat_map(|&[a, b, c]| [side(a, b), side(b, c), side(c, a)]).collect();
        sides.par_sort_unstable();
        sides
    }

    /// Euler characteristic V - E + F; unused vertices are not counted.
    pub fn euler_characteristic(&self) -> i64 {
        self.characteristic(&self.sorted_sides())
    }

    fn characteristic(&self, sides: &[u64]) -> i64 {
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let vertices = used.iter().filter(|&&u| u).count() as i64;
        vertices - by_edge(sides).count() as i64 + self.triangles.len() as i64
    }

    /// Number of connected pieces of the surface; unused vertices are none.
    pub fn components(&self) -> usize {
        let mut parent: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let mut pieces = 0;
        let mut used = vec![false; self.vertices.len()];
        for &[a, b, c] in &self.triangles {
            for v in [a, b, c] {
                pieces += usize::from(!std::mem::replace(&mut used[v as usize], true));
            }
            for v in [b, c] {
                let (p, q) = (root(&mut parent, a), root(&mut parent, v));
                parent[p.max(q) as usize] = p.min(q);
                pieces -= usize::from(p != q);
            }
        }
        pieces
    }

    /// Number of handles, of all pieces together: components - chi / 2; `None` if the mesh is
    /// not closed.
    pub fn genus(&self) -> Option<i64> {
        let sides = self.sorted_sides();
        all_shared(&sides).then(|| self.components() as i64 - self.characteristic(&sides) / 2)
    }

    /// The mesh in a box `[0, period]` with opposite faces taken as one: what
    /// [`Caps::Periodic`](crate::isosurface::Caps::Periodic) cut is joined there, so that
    /// components and genus are those on the torus.
    ///
    /// Serves topology: triangles at the far faces reach through the whole box. At least
    /// three nodes an axis.
    #[must_use]
    pub fn on_torus(mut self, period: [f64; 3]) -> Self {
        for vertex in &mut self.vertices {
            for (c, length) in vertex.iter_mut().zip(period) {
                *c = if *c == length { 0.0 } else { *c };
            }
        }
        self.weld()
    }

    /// Vertices at edges of a single triangle, where the surface ends; sorted.
    pub fn border(&self) -> Vec<u32> {
        let sides = self.sorted_sides();
        let ends = |side: u64| [side >> 33, (side >> 1) & u64::from(u32::MAX)].map(|v| v as u32);
        let alone = by_edge(&sides).filter(|same| same.len() == 1);
        let mut border: Vec<u32> = alone.flat_map(|same| ends(same[0])).collect();
        border.sort_unstable();
        border.dedup();
        border
    }

    /// Whether every edge is shared by two triangles that run through it in opposite senses.
    pub fn is_closed(&self) -> bool {
        all_shared(&self.sorted_sides())
    }

    /// Whether the mesh is an oriented manifold, perhaps with a border.
    ///
    /// No edge has more than two triangles nor two in the same sense, and the
    /// triangles around each vertex form a single fan.
    pub fn is_manifold(&self) -> bool {
        let degenerate = self.triangles.iter().any(|[a, b, c]| a == b || b == c || c == a);
        let sides = self.sorted_sides();
        !degenerate && sides.windows(2).all(|pair| pair[0] != pair[1]) && self.single_fans()
    }

    /// Whether the triangles at each vertex hang together through shared sides.
    fn single_fans(&self) -> bool {
        // (vertex, next, last): at `vertex` a triangle turns from `next` to `last`.
        let mut corners: Vec<[u32; 3]> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
            .collect();
        corners.sort_unstable();
        corners.chunk_by(|p, q| p[0] == q[0]).all(|fan| {
            // Start where nothing precedes, if the fan is open, and count the triangles passed.
            let start = fan.iter().find(|t| fan.iter().all(|o| o[2] != t[1])).unwrap_or(&fan[0]);
            let mut at = start;
            let mut passed = 1;
            while let Ok(m) = fan.binary_search_by_key(&at[2], |t| t[1]) {
                if fan[m] == *start || passed > fan.len() {
                    break;
                }
                at = &fan[m];
                passed += 1;
            }
            passed == fan.len()
        })
    }
}

/// Sorted sides in groups of one edge.
fn by_edge(sides: &[u64]) -> impl Iterator<Item = &[u64]> {
    sides.chunk_by(|a, b| a >> 1 == b >> 1)
}

/// Whether every edge has two sides of opposite senses.
fn all_shared(sides: &[u64]) -> bool {
    by_edge(sides).all(|same| same.len() == 2 && same[0] != same[1])
}

/// The first of the vertices joined to `v`; halves the way there.
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        let above = parent[parent[v as usize] as usize];
        parent[v as usize] = above;
        v = above;
    }
    v
}
