//! Loads as arrows and supports as triangles on a picture.

use super::build::Problem;
use crate::Stroke;

/// Colours of loads, one per case in turn, and of supports.
const LOADS: [[u8; 3]; 3] = [[200, 30, 30], [210, 120, 0], [150, 0, 150]];
const SUPPORT: [u8; 3] = [20, 90, 180];

/// Marks of the same kind are at least this part of the longer side apart.
const APART: f64 = 0.04;

/// Length of an arrow and side of a triangle, as parts of the longer side.
const ARROW: f64 = 0.12;
const TRIANGLE: f64 = 0.025;

/// The lines of all marks, in elements; in space those of all planes, seen along z.
pub(super) fn strokes(problem: &Problem) -> Vec<Stroke> {
    let lattice = problem.system.lattice();
    let [_, ny, nx] = problem.grid.shape();
    let side = nx.max(ny) as f64;
    let mut strokes = Vec::new();
    let components = problem.system.element().components();
    let nodes = 0..lattice.node_count();
    let place = |node: usize| {
        let [x, y, _] = lattice.position(node).map(|n| n as f64);
        [x, y]
    };
    for axis in 0..components.min(2) {
        let held = nodes.clone().filter(|n| problem.system.fixed()[n * components + axis]);
        for at in thin(held.map(place), side) {
            triangle(&mut strokes, at, (axis, components == 1), side * TRIANGLE);
        }
    }
    for (case, (_, force)) in problem.cases.iter().enumerate() {
        let vector = |node: usize| {
            let along =
                |axis: usize| if axis < components { force[node * components + axis] } else { 0.0 };
            [along(0), along(1)]
        };
        let loaded: Vec<usize> = nodes.clone().filter(|&n| vector(n) != [0.0; 2]).collect();
        let shown = thin(loaded.iter().map(|&n| place(n)), side);
        // Sources of heat all over a plate are no arrows.
        if components == 1 {
            continue;
        }
        for (&node, at) in
            loaded.iter().map(|n| (n, place(*n))).filter(|(_, at)| shown.contains(at))
        {
            arrow(&mut strokes, at, vector(node), side * ARROW, LOADS[case % LOADS.len()]);
        }
    }
    strokes
}

/// Points that keep their distance.
fn thin(points: impl Iterator<Item = [f64; 2]>, side: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for [x, y] in points {
        if kept.iter().all(|[a, b]| (a - x).hypot(b - y) >= APART * side) {
            kept.push([x, y]);
        }
    }
    kept
}

/// A triangle whose tip touches the node, from the side that it holds.
fn triangle(strokes: &mut Vec<Stroke>, [x, y]: [f64; 2], (axis, all): (usize, bool), size: f64) {
    let corners = if axis == 0 && !all {
        [[x, y], [x - size, y - 0.6 * size], [x - size, y + 0.6 * size]]
    } else {
        [[x, y], [x - 0.6 * size, y + size], [x + 0.6 * size, y + size]]
    };
    for n in 0..3 {
        strokes.push(Stroke { ends: [corners[n], corners[(n + 1) % 3]], color: SUPPORT });
    }
}

/// An arrow that starts at the node.
fn arrow(
    strokes: &mut Vec<Stroke>,
    [x, y]: [f64; 2],
    force: [f64; 2],
    length: f64,
    color: [u8; 3],
) {
    let size = force[0].hypot(force[1]);
    let [dx, dy] = force.map(|f| f / size * length);
    let tip = [x + dx, y + dy];
    strokes.push(Stroke { ends: [[x, y], tip], color });
    for side in [-0.12, 0.12] {
        let barb = [tip[0] - 0.25 * dx - side * dy, tip[1] - 0.25 * dy + side * dx];
        strokes.push(Stroke { ends: [tip, barb], color });
    }
}
