//! Closed lines of a file as a level-set function.

use crate::{Context, Error, Result};
use solvers::{Field, Grid, level_set::distance};

/// The signed distance (cells) to the closed lines of `path`, inside by the even-odd rule.
///
/// The file's points are in cells from the picture's upper left corner, as those of
/// `contour.csv`: nodes are the middles of cells. `key` is the configuration's key.
///
/// # Errors
/// [`Error::Input`] if the file cannot be read, [`Error::Config`] if the grid has not two axes
/// or a point is off the picture.
pub(crate) fn phi(key: &str, path: &str, grid: Grid, context: &Context<'_>) -> Result<Field> {
    if grid.dim() != 2 {
        let reason = format!("lines bound a region of 2 axes, the grid has {}", grid.dim());
        return Err(Error::config(key, reason));
    }
    let mut lines = context.inputs.lines(key, path)?;
    let [_, ny, nx] = grid.shape();
    let on = |[x, y]: [f64; 2]| (0.0..=nx as f64).contains(&x) && (0.0..=ny as f64).contains(&y);
    if let Some([x, y]) = lines.iter().flat_map(|l| &l.points).copied().find(|&p| !on(p)) {
        let reason = format!("`{path}` has a point at ({x}, {y}), off the {nx} x {ny} cells");
        return Err(Error::config(key, reason));
    }
    lines.iter_mut().flat_map(|line| &mut line.points).flatten().for_each(|v| *v -= 0.5);
    distance::from_polylines(&lines, grid).map_err(|error| Error::config(key, error.to_string()))
}
