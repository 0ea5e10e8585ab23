//! Stochastic descent: edges pull their ends together, random points push apart.

use super::Umap;
use super::fuzzy::Edge;
use crate::random::{normal, stream};
use rand::Rng as _;

/// Points pushed away for each edge that pulls.
const NEGATIVES: f64 = 5.0;

/// Greatest move along an axis, before the step size.
const CLIP: f64 = 4.0;

/// Extent of the start.
const EXTENT: f64 = 10.0;

/// When an edge is next drawn, and how often (in epochs).
struct Turn {
    i: usize,
    j: usize,
    every: f64,
    next: f64,
    next_negative: f64,
}

/// Positions after `umap.epochs` passes of falling step size from `positions`; `[a, b]` is the curve.
pub(super) fn optimize(
    mut positions: Vec<[f64; 2]>,
    edges: &[Edge],
    [a, b]: [f64; 2],
    umap: Umap,
) -> Vec<[f64; 2]> {
    prepare(&mut positions, umap.seed);
    let n = positions.len() as u64;
    let mut random = stream(umap.seed, "umap negative samples", 0);
    let mut turns = turns(edges, umap.epochs);
    for epoch in 0..umap.epochs {
        let now = epoch as f64;
        let alpha = 1.0 - now / umap.epochs as f64;
        for turn in turns.iter_mut().filter(|turn| turn.next <= now) {
            let (i, j) = (turn.i, turn.j);
            let away = minus(positions[i], positions[j]);
            let square = away[0] * away[0] + away[1] * away[1];
            if square > 0.0 {
                let power = libm::pow(square, b);
                let pull = -2.0 * a * b * power / (square * (a * power + 1.0));
                for d in 0..2 {
                    let step = alpha * (pull * away[d]).clamp(-CLIP, CLIP);
                    positions[i][d] += step;
                    positions[j][d] -= step;
                }
            }
            turn.next += turn.every;
            let every = turn.every / NEGATIVES;
            let count = ((now - turn.next_negative) / every) as usize;
            for _ in 0..count {
                let k = (random.next_u64() % n) as usize;
                let away = minus(positions[i], positions[k]);
                let square = away[0] * away[0] + away[1] * away[1];
                // Also where k is i.
                if square == 0.0 {
                    continue;
                }
                let push = 2.0 * b / ((1e-3 + square) * (a * libm::pow(square, b) + 1.0));
                for d in 0..2 {
                    positions[i][d] += alpha * (push * away[d]).clamp(-CLIP, CLIP);
                }
            }
            turn.next_negative += count as f64 * every;
        }
    }
    positions
}

/// Edges by how often they are drawn; those too weak to be drawn once are left out.
fn turns(edges: &[Edge], epochs: usize) -> Vec<Turn> {
    let top = edges.iter().fold(0.0, |m: f64, e| m.max(e.2));
    let strong = edges.iter().filter(|e| e.2 >= top / epochs as f64);
    strong
        .map(|&(i, j, p)| {
            let every = top / p;
            let next_negative = every / NEGATIVES;
            Turn { i: i as usize, j: j as usize, every, next: every, next_negative }
        })
        .collect()
}

/// Scales the start to its extent, and parts points that coincide.
fn prepare(positions: &mut [[f64; 2]], seed: u64) {
    let extent = positions.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    let scale = if extent > 0.0 { 0.5 * EXTENT / extent } else { 1.0 };
    let mut random = stream(seed, "umap start", 0);
    for v in positions.iter_mut().flatten() {
        *v = *v * scale + 1e-4 * normal(&mut random);
    }
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}
