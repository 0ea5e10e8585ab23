//! Following a ray through the tree.

use super::{Bvh, Hit, LEAF, Lanes, Leaf, NOTHING, Node, Ray, WIDTH};

/// Children that wait, at most: seven a level, of which there are [`super::build::UNEVEN`] and
/// the 11 of 2^31 triangles split in halves. A short stack is quicker to set up.
const STACK: usize = 160;
const SHORT: usize = 64;
/// Boxes are met by rays that miss them by this much of their distance: three roundings.
const SLACK: f32 = 4.0 * f32::EPSILON;

/// [`Bvh::closest`] with the vector instructions of the machine.
pub(super) struct Closest<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) ray: &'a Ray,
}

/// [`Bvh::occluded`] with the vector instructions of the machine.
pub(super) struct Any<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) ray: &'a Ray,
}

/// What is done with the leaves on the way; everything is inlined into [`pulp`]'s dispatch.
trait Visit {
    /// Looks at a leaf: how far to look from now on, `None` to stop.
    fn leaf(&mut self, leaf: &Leaf, ray: &Ray) -> Option<f32>;
}

struct First {
    reach: f32,
    hit: Option<Hit>,
}

impl Visit for First {
    #[inline(always)]
    fn leaf(&mut self, leaf: &Leaf, ray: &Ray) -> Option<f32> {
        let (distances, areas) = meet(leaf, ray);
        for lane in 0..WIDTH {
            let (t, n) = (distances[lane], leaf.triangles[lane]);
            let tie = t == self.reach && self.hit.is_some_and(|hit| n < hit.triangle);
            if t < self.reach || tie {
                let [u, v, w] = [areas[0][lane], areas[1][lane], areas[2][lane]];
                let sum = u + v + w;
                let weights = if sum == 0.0 { [1.0 / 3.0; 3] } else { [u / sum, v / sum, w / sum] };
                self.hit = Some(Hit { distance: t, triangle: n, weights });
                self.reach = t;
            }
        }
        Some(self.reach)
    }
}

struct Found(bool);

impl Visit for Found {
    #[inline(always)]
    fn leaf(&mut self, leaf: &Leaf, ray: &Ray) -> Option<f32> {
        let (distances, _) = meet(leaf, ray);
        let mut found = false;
        for t in distances {
            found |= t < ray.reach;
        }
        self.0 = found;
        if found { None } else { Some(ray.reach) }
    }
}

impl pulp::NullaryFnOnce for Closest<'_> {
    type Output = Option<Hit>;

    #[inline(always)]
    fn call(self) -> Option<Hit> {
        let mut first = First { reach: self.ray.reach, hit: None };
        walk(self.bvh, self.ray, &mut first);
        first.hit
    }
}

impl pulp::NullaryFnOnce for Any<'_> {
    type Output = bool;

    #[inline(always)]
    fn call(self) -> bool {
        let mut found = Found(false);
        walk(self.bvh, self.ray, &mut found);
        found.0
    }
}

/// Shows `visit` the leaves whose boxes the ray meets, nearest children first.
#[inline(always)]
fn walk(bvh: &Bvh, ray: &Ray, visit: &mut impl Visit) {
    if 7 * bvh.depth < SHORT {
        follow::<SHORT>(bvh, ray, visit)
    } else {
        follow::<STACK>(bvh, ray, visit)
    }
}

#[inline(always)]
fn follow<const ROOM: usize>(bvh: &Bvh, ray: &Ray, visit: &mut impl Visit) {
    // A direction without a component along an axis: its infinite inverse makes NaN on a
    // face of a box, which `f32::max` ignores.
    let [dx, dy, dz] = ray.direction;
    let inverse = [1.0 / dx, 1.0 / dy, 1.0 / dz];
    let mut reach = ray.reach;
    let mut stack = [(bvh.root, 0.0_f32); ROOM];
    let mut waiting = usize::from(bvh.root != NOTHING);
    while waiting > 0 {
        waiting -= 1;
        let (child, distance) = stack[waiting];
        if distance > reach {
            continue;
        }
        if child & LEAF != 0 {
            match visit.leaf(&bvh.leaves[(child & !LEAF) as usize], ray) {
                Some(farthest) => reach = farthest,
                None => return,
            }
            continue;
        }
        let node = &bvh.nodes[child as usize];
        let entries = entries(node, ray, inverse, reach);
        let first = waiting;
        for (&child, entry) in node.children.iter().zip(entries) {
            if entry == f32::INFINITY {
                continue;
            }
            // The nearest on top.
            let mut at = waiting;
            while at > first && stack[at - 1].1 < entry {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = (child, entry);
            waiting += 1;
        }
    }
}

/// How far away the ray enters each child's box; infinity if it misses it.
#[inline(always)]
fn entries(node: &Node, ray: &Ray, inverse: [f32; 3], reach: f32) -> Lanes {
    let mut near = [0.0_f32; WIDTH];
    let mut far = [reach; WIDTH];
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], inverse[axis]);
        let (front, back) =
            if d >= 0.0 { (&node.low, &node.high) } else { (&node.high, &node.low) };
        for lane in 0..WIDTH {
            let (a, b) = ((front[axis][lane] - o) * d, (back[axis][lane] - o) * d);
            near[lane] = if a > near[lane] { a } else { near[lane] };
            far[lane] = if b < far[lane] { b } else { far[lane] };
        }
    }
    for lane in 0..WIDTH {
        let met = near[lane] <= far[lane] * (1.0 + SLACK);
        near[lane] = if met { near[lane] } else { f32::INFINITY };
    }
    near
}

/// Distances of a leaf's triangles along the ray, infinity if it misses them, and twice the
/// signed areas opposite to their corners, seen along the ray.
///
/// Each edge is weighed by `(q - p) x (q + p) . d` with corners relative to the origin, which
/// is exactly the opposite seen from the neighbour: rays do not slip through edges (Embree's
/// form of Pluecker coordinates).
#[inline(always)]
fn meet(leaf: &Leaf, ray: &Ray) -> (Lanes, [Lanes; 3]) {
    let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin, ray.direction);
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = &leaf.corners;
    let mut areas = [[0.0; WIDTH]; 3];
    let mut distances = [f32::INFINITY; WIDTH];
    for n in 0..WIDTH {
        let (ax, ay, az) = (ax[n] - ox, ay[n] - oy, az[n] - oz);
        let (bx, by, bz) = (bx[n] - ox, by[n] - oy, bz[n] - oz);
        let (cx, cy, cz) = (cx[n] - ox, cy[n] - oy, cz[n] - oz);
        // Edges opposite to the corners, and sums of their ends.
        let (ux, uy, uz) = (cx - bx, cy - by, cz - bz);
        let (vx, vy, vz) = (ax - cx, ay - cy, az - cz);
        let (wx, wy, wz) = (bx - ax, by - ay, bz - az);
        let (ex, ey, ez) = (cx + bx, cy + by, cz + bz);
        let (fx, fy, fz) = (ax + cx, ay + cy, az + cz);
        let (gx, gy, gz) = (bx + ax, by + ay, bz + az);
        let u = dx * (ey * uz - ez * uy) + dy * (ez * ux - ex * uz) + dz * (ex * uy - ey * ux);
        let v = dx * (fy * vz - fz * vy) + dy * (fz * vx - fx * vz) + dz * (fx * vy - fy * vx);
        let w = dx * (gy * wz - gz * wy) + dy * (gz * wx - gx * wz) + dz * (gx * wy - gy * wx);
        // The normal.
        let (nx, ny, nz) = (wy * uz - wz * uy, wz * ux - wx * uz, wx * uy - wy * ux);
        let along = nx * dx + ny * dy + nz * dz;
        let t = (nx * ax + ny * ay + nz * az) / along;
        let least = if u < v { u } else { v };
        let least = if least < w { least } else { w };
        let most = if u > v { u } else { v };
        let most = if most > w { most } else { w };
        // Not finite: an edge seen end on, or no triangle.
        let met = ((least >= 0.0) | (most <= 0.0)) & (t > 0.0) & (t < f32::INFINITY);
        distances[n] = if met { t } else { f32::INFINITY };
        areas[0][n] = u;
        areas[1][n] = v;
        areas[2][n] = w;
    }
    (distances, areas)
}
