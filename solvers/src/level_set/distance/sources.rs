//! Signed distances of masks, images and polylines.

use super::{Element, Pieces, Redistance, RedistanceOptions, redistance};
use crate::isosurface::Polyline;
use crate::{Boundary, Error, Field, Grid, Result};

/// Signed distance of a mask, true inside; the contour passes halfway between differing nodes.
///
/// # Errors
/// If `mask` has not one entry for each node of `grid` (row-major).
pub fn from_mask(mask: &[bool], grid: Grid, boundary: Boundary) -> Result<Field> {
    let values = mask.iter().map(|&inside| if inside { -0.5 } else { 0.5 }).collect();
    let mut phi = Field::from_vec(grid, values)?;
    redistance(&mut phi, boundary)?;
    Ok(phi)
}

/// Signed distance to the level line of a grey image, `image < level` inside.
///
/// The line is placed between nodes by cubic interpolation of the grey values.
/// For bright regions negate the result.
///
/// # Errors
/// If the image or the level is not finite.
pub fn from_image(image: &Field, level: f64, boundary: Boundary) -> Result<Field> {
    let mut phi = image.clone();
    phi.as_mut_slice().iter_mut().for_each(|v| *v -= level);
    redistance(&mut phi, boundary)?;
    Ok(phi)
}

/// Signed distance to closed polylines in the plane, inside by the even-odd rule.
///
/// Sides are cut into pieces of half a cell at most. Up to two cells away the
/// distance is exact; beyond, where several parts of the lines are about equally far,
/// one a little farther may be measured. The distances do not wrap.
///
/// # Errors
/// If the grid has not two axes, a line is open, has fewer than three points, a
/// point that is not finite, or a point off the grid (half a cell around the nodes).
pub fn from_polylines(lines: &[Polyline], grid: Grid) -> Result<Field> {
    if grid.dim() != 2 {
        return Err(Error::out_of_range("number of axes", grid.dim() as f64, "[2, 2]"));
    }
    let mut work = Redistance::new(grid, RedistanceOptions::default())?;
    let h = grid.spacing();
    work.pieces.clear();
    for (number, line) in lines.iter().enumerate() {
        check(line, number, grid)?;
        for (p, q) in sides(line) {
            add_side(&mut work.pieces, grid, p.map(|c| c / h), q.map(|c| c / h));
        }
    }
    let mut phi = Field::constant(grid, 1.0);
    fill_inside(&mut phi, lines);
    work.measure(phi.as_mut_slice());
    Ok(phi)
}

fn sides(line: &Polyline) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    let n = line.points.len();
    (0..n).map(move |m| (line.points[m], line.points[(m + 1) % n]))
}

fn check(line: &Polyline, number: usize, grid: Grid) -> Result<()> {
    if !line.closed || line.points.len() < 3 {
        return Err(Error::Invalid(format!(
            "polyline {number} is {} with {} points; a signed distance needs closed lines of at least 3",
            if line.closed { "closed" } else { "open" },
            line.points.len()
        )));
    }
    let [_, ny, nx] = grid.shape();
    let h = grid.spacing();
    let inside = |c: f64, n: usize| (-0.5..=n as f64 - 0.5).contains(&(c / h));
    match line.points.iter().find(|[x, y]| !(inside(*x, nx) && inside(*y, ny))) {
        None => Ok(()),
        Some([x, y]) => Err(Error::Invalid(format!(
            "polyline {number} has a point at ({x}, {y}), off the grid of {nx} x {ny} nodes {h} apart"
        ))),
    }
}

/// Cuts a side into pieces of half a cell at most, each known to the nodes around it.
fn add_side(pieces: &mut Pieces, grid: Grid, p: [f64; 2], q: [f64; 2]) {
    let along = [q[0] - p[0], q[1] - p[1]];
    let length = along[0].hypot(along[1]);
    if length == 0.0 {
        return;
    }
    let [_, ny, nx] = grid.shape();
    let count = (2.0 * length).ceil();
    for m in 0..count as usize {
        let s = (m as f64 + 0.5) / count;
        let point = [p[0] + s * along[0], p[1] + s * along[1], 0.0];
        let normal = [along[1] / length, -along[0] / length, 0.0];
        let extent = 0.5 * length / count;
        let node = |c: f64, n: usize| {
            let low = (c.floor().max(0.0) as usize).min(n - 1);
            [low, (low + 1).min(n - 1)]
        };
        let (i, j) = (node(point[0], nx), node(point[1], ny));
        let around = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(b, a)| [0, j[b] as u32, i[a] as u32]);
        let element = Element { normal, extent, ..Element::point(point) }.overlapping(0.75);
        // Bends for grids of a single row or column, which count as space.
        pieces.push(element, &around, Some([0.0; 6]));
    }
}

/// Makes nodes inside an odd number of lines negative: crossings of each row, toggled from the left.
fn fill_inside(phi: &mut Field, lines: &[Polyline]) {
    let h = phi.grid().spacing();
    let [_, ny, nx] = phi.grid().shape();
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); ny];
    for (p, q) in lines.iter().flat_map(sides) {
        let (low, high) = if p[1] < q[1] { (p, q) } else { (q, p) };
        let first = (low[1] / h).ceil().max(0.0) as usize;
        for (j, row) in crossings.iter_mut().enumerate().skip(first) {
            let y = j as f64 * h;
            if y >= high[1] {
                break;
            }
            if y >= low[1] {
                row.push(low[0] + (y - low[1]) / (high[1] - low[1]) * (high[0] - low[0]));
            }
        }
    }
    for (row, values) in crossings.iter_mut().zip(phi.as_mut_slice().chunks_mut(nx)) {
        row.sort_by(f64::total_cmp);
        let mut passed = 0;
        for (i, value) in values.iter_mut().enumerate() {
            while passed < row.len() && row[passed] < i as f64 * h {
                passed += 1;
            }
            if passed % 2 == 1 {
                *value = -*value;
            }
        }
    }
}
