//! Elimination orders for grids.

/// Boxes of at most this many nodes are not cut further: smaller leaves save less than
/// 5 % of the fill and make the dense blocks, and so the factorization, slower.
const LEAF: usize = 8;

/// Elimination order of the nodes of a grid by nested dissection: the i-th node
/// eliminated is `order[i]`.
///
/// Each box is cut across its longest axis by a plane one node thick, both halves
/// come first and the plane last (George 1973). `shape` is `[nz, ny, nx]`, row-major,
/// without or with absent axes. Made for stencils that reach one node; right, but with
/// more fill, for longer ones. On a `periodic` grid the first plane of each axis, which
/// alone joins the two ends, is eliminated after everything else.
///
/// For `k` unknowns per node expand it: `k * node`, ..., `k * node + k - 1`.
pub fn nested_dissection(shape: &[usize], periodic: bool) -> Vec<usize> {
    let mut order = Vec::with_capacity(shape.iter().product());
    let first = |n: usize| usize::from(periodic && n > 2);
    let mut part: Vec<(usize, usize)> = shape.iter().map(|&n| (first(n), n)).collect();
    dissect(shape, &part, &mut order);
    for axis in (0..shape.len()).filter(|&axis| part[axis].0 > 0).collect::<Vec<_>>() {
        part[axis] = (0, 1);
        dissect(shape, &part, &mut order);
        part[axis] = (0, shape[axis]);
    }
    order
}

fn dissect(shape: &[usize], part: &[(usize, usize)], order: &mut Vec<usize>) {
    let size = |&(first, end): &(usize, usize)| end - first;
    let longest = (0..part.len()).max_by_key(|&axis| size(&part[axis]));
    let (Some(axis), count) = (longest, part.iter().map(size).product::<usize>()) else {
        return;
    };
    if count <= LEAF || size(&part[axis]) < 3 {
        return push_all(shape, part, 0, order);
    }
    let (first, end) = part[axis];
    let cut = first.midpoint(end);
    let mut piece = part.to_vec();
    for span in [(first, cut), (cut + 1, end)] {
        piece[axis] = span;
        dissect(shape, &piece, order);
    }
    piece[axis] = (cut, cut + 1);
    dissect(shape, &piece, order);
}

/// Appends the nodes of a box; `prefix` is the flat index of the axes done so far.
fn push_all(shape: &[usize], part: &[(usize, usize)], prefix: usize, order: &mut Vec<usize>) {
    match (shape, part) {
        ([n, shape @ ..], [(first, end), part @ ..]) => {
            for i in *first..*end {
                push_all(shape, part, prefix * n + i, order);
            }
        }
        _ => order.push(prefix),
    }
}

#[cfg(test)]
mod tests {
    use super::nested_dissection;

    #[test]
    fn every_node_once() {
        for shape in [vec![1], vec![100], vec![13, 40], vec![1, 7, 9], vec![9, 11, 6]] {
            for periodic in [false, true] {
                let mut order = nested_dissection(&shape, periodic);
                order.sort_unstable();
                assert!(order.into_iter().eq(0..shape.iter().product()), "{shape:?}");
            }
        }
    }
}
