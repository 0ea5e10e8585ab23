//! Building the tree.

use super::super::TriangleMesh;
use super::{Bvh, Child, LEAF, Leaf, NOTHING, Node, WIDTH};

/// Bins along the longest side of the box of middles.
const BINS: usize = 16;
/// More triangles than this are built on two threads.
const PARALLEL: usize = 4096;
/// Deeper nodes are split in halves, which bounds the depth; see `trace::STACK`.
pub(super) const UNEVEN: usize = 10;

/// A box: ends along x, y, z.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn add(&mut self, other: &Self) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    /// Half of the surface.
    fn area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| (self.high[axis] - self.low[axis]).max(0.0));
        x * y + y * z + z * x
    }
}

/// A triangle while the tree is built.
#[derive(Clone, Copy, Debug)]
struct Item {
    triangle: u32,
    bounds: Bounds,
}

impl Item {
    /// Twice the middle of the box.
    fn middle(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

/// A part of the tree before it is laid out.
enum Tree {
    Leaf(Vec<u32>),
    Node(Vec<(Bounds, Tree)>),
}

pub(super) fn build(mesh: &TriangleMesh) -> Bvh {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize].map(|c| c as f32));
    let mut items: Vec<Item> = Vec::with_capacity(mesh.triangles.len());
    for (triangle, n) in mesh.triangles.iter().zip(0..) {
        let points = corners(triangle);
        if points.as_flattened().iter().all(|c| c.is_finite()) {
            let mut bounds = Bounds::EMPTY;
            points.iter().for_each(|&p| bounds.add(&Bounds { low: p, high: p }));
            items.push(Item { triangle: n, bounds });
        }
    }
    let mut bvh = Bvh { nodes: Vec::new(), leaves: Vec::new(), root: NOTHING, depth: 0 };
    if !items.is_empty() {
        let tree = grow(&mut items, 0);
        bvh.root = lay_out(tree, 0, &mut bvh, &|n| corners(&mesh.triangles[n as usize]));
    }
    bvh
}

/// The tree of some triangles: the child with the largest surface is split until there are
/// eight.
fn grow(items: &mut [Item], depth: usize) -> Tree {
    if items.len() <= WIDTH {
        return Tree::Leaf(items.iter().map(|i| i.triangle).collect());
    }
    let around = |items: &[Item]| {
        let mut bounds = Bounds::EMPTY;
        items.iter().for_each(|i| bounds.add(&i.bounds));
        bounds
    };
    let mut parts: Vec<(Bounds, &mut [Item])> = vec![(around(items), items)];
    while parts.len() < WIDTH {
        let splittable = parts.iter().enumerate().filter(|(_, (_, part))| part.len() > WIDTH);
        let widest = splittable.max_by(|(_, a), (_, b)| a.0.area().total_cmp(&b.0.area()));
        let Some(n) = widest.map(|(n, _)| n) else { break };
        let (_, part) = parts.swap_remove(n);
        let at = if depth < UNEVEN { split(part) } else { part.len() / 2 };
        let (left, right) = part.split_at_mut(at);
        parts.push((around(left), left));
        parts.push((around(right), right));
    }
    Tree::Node(grow_all(parts, depth + 1))
}

fn grow_all(mut parts: Vec<(Bounds, &mut [Item])>, depth: usize) -> Vec<(Bounds, Tree)> {
    let total: usize = parts.iter().map(|(_, part)| part.len()).sum();
    if total > PARALLEL && parts.len() > 1 {
        let right = parts.split_off(parts.len() / 2);
        let (mut left, right) = rayon::join(|| grow_all(parts, depth), || grow_all(right, depth));
        left.extend(right);
        return left;
    }
    parts.into_iter().map(|(bounds, part)| (bounds, grow(part, depth))).collect()
}

/// Orders the triangles in two parts of least expected cost; returns where the second begins.
fn split(items: &mut [Item]) -> usize {
    let mut middles = Bounds::EMPTY;
    for item in items.iter() {
        let p = [0, 1, 2].map(|axis| item.middle(axis));
        middles.add(&Bounds { low: p, high: p });
    }
    let side = |axis: usize| middles.high[axis] - middles.low[axis];
    let axis = (0..3).max_by(|&a, &b| side(a).total_cmp(&side(b))).unwrap_or(0);
    let scale = BINS as f32 / side(axis);
    let half = items.len() / 2;
    if !scale.is_finite() {
        return half;
    }
    let bin = |i: &Item| ((i.middle(axis) - middles.low[axis]) * scale).min(BINS as f32 - 1.0);
    let bin = |i: &Item| bin(i) as usize;
    let mut bins = [(Bounds::EMPTY, 0); BINS];
    for item in items.iter() {
        let (bounds, count) = &mut bins[bin(item)];
        bounds.add(&item.bounds);
        *count += 1;
    }
    // Cost of all bins from n on.
    let mut after = [0.0; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for n in (0..BINS).rev() {
        bounds.add(&bins[n].0);
        count += bins[n].1;
        after[n] = bounds.area() * leaves(count);
    }
    (bounds, count) = (Bounds::EMPTY, 0);
    let mut best = (f32::INFINITY, 0);
    for n in 1..BINS {
        bounds.add(&bins[n - 1].0);
        count += bins[n - 1].1;
        let cost = bounds.area() * leaves(count) + after[n];
        if count > 0 && count < items.len() && cost < best.0 {
            best = (cost, n);
        }
    }
    let (left, right): (Vec<Item>, Vec<Item>) = items.iter().partition(|i| bin(i) < best.1);
    if left.is_empty() || right.is_empty() {
        return half;
    }
    items[..left.len()].copy_from_slice(&left);
    items[left.len()..].copy_from_slice(&right);
    left.len()
}

/// Leaves that `count` triangles fill.
fn leaves(count: usize) -> f32 {
    count.div_ceil(WIDTH) as f32
}

/// Moves a tree into the arrays, depth first.
fn lay_out(
    tree: Tree,
    depth: usize,
    bvh: &mut Bvh,
    corners: &impl Fn(u32) -> [[f32; 3]; 3],
) -> Child {
    bvh.depth = bvh.depth.max(depth);
    match tree {
        Tree::Leaf(triangles) => {
            let mut leaf =
                Leaf { corners: [[[f32::NAN; WIDTH]; 3]; 3], triangles: [u32::MAX; WIDTH] };
            for (lane, &n) in triangles.iter().enumerate() {
                leaf.triangles[lane] = n;
                for (corner, point) in corners(n).iter().enumerate() {
                    (0..3).for_each(|axis| leaf.corners[corner][axis][lane] = point[axis]);
                }
            }
            bvh.leaves.push(leaf);
            LEAF | (bvh.leaves.len() as u32 - 1)
        }
        Tree::Node(parts) => {
            let at = bvh.nodes.len();
            // Ends in the wrong order: no ray is between them.
            bvh.nodes.push(Node {
                low: [[f32::INFINITY; WIDTH]; 3],
                high: [[f32::NEG_INFINITY; WIDTH]; 3],
                children: [NOTHING; WIDTH],
            });
            for (lane, (bounds, part)) in parts.into_iter().enumerate() {
                let child = lay_out(part, depth + 1, bvh, corners);
                let node = &mut bvh.nodes[at];
                node.children[lane] = child;
                for axis in 0..3 {
                    node.low[axis][lane] = bounds.low[axis];
                    node.high[axis][lane] = bounds.high[axis];
                }
            }
            at as u32
        }
    }
}
