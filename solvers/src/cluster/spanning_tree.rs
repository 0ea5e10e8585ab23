//! The minimum spanning tree of the mutual reachability distance.

use ndarray::ArrayView2;

/// An edge between two points, and its length.
pub(super) type Edge = (usize, usize, f64);

/// Edges of the minimum spanning tree of `max(core(i), core(j), d(i, j))`, short ones
/// first, where `core` is the distance to the `neighbours`-th other point (Prim's method).
pub(super) fn mutual_reachability_tree(
    distances: ArrayView2<'_, f64>,
    neighbours: usize,
) -> Vec<Edge> {
    let n = distances.nrows();
    let core: Vec<f64> = distances
        .rows()
        .into_iter()
        .enumerate()
        .map(|(i, row)| {
            let mut others: Vec<f64> =
                row.iter().enumerate().filter(|&(j, _)| j != i).map(|(_, &d)| d).collect();
            match neighbours {
                0 => 0.0,
                _ => *others.select_nth_unstable_by(neighbours - 1, f64::total_cmp).1,
            }
        })
        .collect();
    // Of each point outside the tree the nearest point inside.
    // Many edges at a point are as long as its core distance: the truly nearer goes first.
    let mut nearest = vec![([f64::INFINITY; 2], 0); n];
    let mut outside: Vec<usize> = (1..n).collect();
    let mut edges = Vec::with_capacity(n.saturating_sub(1));
    let mut newest = 0;
    while !outside.is_empty() {
        let mut best = 0;
        for (place, &j) in outside.iter().enumerate() {
            let distance = distances[[newest, j]];
            let reach = [distance.max(core[newest]).max(core[j]), distance];
            if reach < nearest[j].0 {
                nearest[j] = (reach, newest);
            }
            if nearest[j].0 < nearest[outside[best]].0 {
                best = place;
            }
        }
        newest = outside.remove(best);
        let (reach, inside) = nearest[newest];
        edges.push((inside, newest, reach));
    }
    edges.sort_by(|a, b| a.2[0].total_cmp(&b.2[0]).then(a.2[1].total_cmp(&b.2[1])));
    edges.into_iter().map(|(i, j, [reach, _])| (i, j, reach)).collect()
}
