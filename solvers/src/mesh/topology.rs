//! How the triangles of a mesh hang together.

use super::TriangleMesh;

impl TriangleMesh {
    /// Sides of all triangles as (low, high, forward), sorted.
    fn sorted_sides(&self) -> Vec<(u32, u32, bool)> {
        let mut sides: Vec<_> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(p, q)| (p.min(q), p.max(q), p < q))
            .collect();
        sides.sort_unstable();
        sides
    }

    /// Euler characteristic V - E + F; unused vertices are not counted.
    pub fn euler_characteristic(&self) -> i64 {
        let mut used = vec![false; self.vertices.len()];
        self.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        let vertices = used.iter().filter(|&&u| u).count() as i64;
        let sides = self.sorted_sides();
        let edges = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).count() as i64;
        vertices - edges + self.triangles.len() as i64
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
        self.is_closed().then(|| self.components() as i64 - self.euler_characteristic() / 2)
    }

    /// The mesh in a box `[0, period]` with opposite faces taken as one: what
    /// [`Caps::Periodic`](crate::isosurface::Caps::Periodic) cut is joined there, so that
    /// components and genus are those on the torus.
    ///
    /// Serves topology: triangles at the far faces reach through the whole box. At least
    /// three nodes an axis.
    #[must_use]
    pub fn on_torus(&self, period: [f64; 3]) -> Self {
        let mut mesh = self.clone();
        for vertex in &mut mesh.vertices {
            for (c, length) in vertex.iter_mut().zip(period) {
                *c = if *c == length { 0.0 } else { *c };
            }
        }
        mesh.weld()
    }

    /// Whether every edge is shared by two triangles that run through it in opposite senses.
    pub fn is_closed(&self) -> bool {
        let sides = self.sorted_sides();
        sides
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .all(|same| same.len() == 2 && same[0].2 != same[1].2)
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

/// The first of the vertices joined to `v`; halves the way there.
fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        let above = parent[parent[v as usize] as usize];
        parent[v as usize] = above;
        v = above;
    }
    v
}
