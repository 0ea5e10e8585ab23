//! Where the curve starts.

use super::config::Curve;
use crate::{Context, Error, Result, contour};
use solvers::level_set::{Point, Shape};
use solvers::{Field, Grid, random};

/// phi of the curve at the start: from lines, by name, or negative in the dark half of a picture.
pub(super) fn phi(curve: &Curve, grid: Grid, context: &Context<'_>) -> Result<Field> {
    if let Some(path) = &curve.contour {
        return contour::phi("curve.contour", path, grid, context);
    }
    let axes: Vec<f64> = grid.axes().iter().map(|&n| n as f64).collect();
    let least = axes.iter().copied().fold(f64::INFINITY, f64::min);
    let center = Point(grid.center());
    match curve.start.as_str() {
        // Radius 30 on the paper's 80 x 80 cells.
        "circle" => Ok(Shape::Circle { center, radius: 0.375 * least }.field(grid)?),
        "border" => Ok(Field::from_fn(grid, |p| {
            let to_border = |axis: usize| {
                let n = grid.shape()[2 - axis] as f64;
                if n == 1.0 { f64::INFINITY } else { p[axis].min(n - 1.0 - p[axis]) }
            };
            // Inside is all but the outermost cells.
            1.5 - (0..3).map(to_border).fold(f64::INFINITY, f64::min)
        })),
        "seeds" => {
            let mut places = random::stream(context.seed, "curve seeds", 0);
            let shapes = (0..16)
                .map(|_| {
                    let at = [0, 1, 2].map(|axis| {
                        random::uniform(&mut places) * (grid.shape()[2 - axis] - 1) as f64
                    });
                    let center = Point(at);
                    Shape::Circle { center, radius: (0.04 * least).max(1.5) }
                })
                .collect();
            Ok(Shape::Union { shapes }.field(grid)?)
        }
        path => {
            let key = "curve.start";
            let mut image = context.inputs.field(key, path)?;
            image
                .check_shape(&format!("`{path}`"), grid)
                .map_err(|error| Error::config(key, error.to_string()))?;
            image.as_mut_slice().iter_mut().for_each(|v| *v -= 0.5);
            Ok(image)
        }
    }
}
