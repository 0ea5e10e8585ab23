//! Where a flow starts.

use super::config::{Config, Start};
use crate::{Context, Error, Result};
use solvers::{Field, Grid, level_set};

/// The phase at the start of a flow from a shape or a file; `None` for noise.
pub(super) fn phase(config: &Config, context: &Context<'_>) -> Result<Option<Vec<f64>>> {
    let [nz, ny, nx] = config.shape();
    let middle = [nx, ny, nz].map(|n| 0.5 * (n as f64 - 1.0) * config.spacing);
    let ball = |radius: f64| {
        move |p: [f64; 3]| {
            let d = [0, 1, 2].map(|m| p[m] - middle[m]);
            d.iter().map(|d| d * d).sum::<f64>().sqrt() - radius
        }
    };
    match &config.start {
        Start::Noise => Ok(None),
        Start::Sphere { radius } => {
            positive("start.radius", *radius)?;
            profile(config, ball(*radius)).map(Some)
        }
        Start::HoledBoxes { count, half_width, half_hole } => {
            positive("start.half_width", *half_width)?;
            positive("start.half_hole", *half_hole)?;
            if !(1..=100).contains(count) {
                return Err(Error::range("start.count", *count as f64, "[1, 100]"));
            }
            if half_hole >= half_width {
                let range = format!("(0, {half_width})");
                return Err(Error::range("start.half_hole", *half_hole, &range));
            }
            profile(config, holed_boxes(*count, *half_width, *half_hole, middle)).map(Some)
        }
        Start::File { path } => {
            let field = field("start.path", path, config, context)?;
            if let Some(bad) = field.as_slice().iter().find(|u| !u.is_finite()) {
                return Err(Error::range("start.path", *bad, "(-inf, inf)"));
            }
            Ok(Some(field.as_slice().to_vec()))
        }
    }
}

/// An array of the size of the box.
pub(super) fn field(
    key: &str,
    path: &str,
    config: &Config,
    context: &Context<'_>,
) -> Result<Field> {
    let field = context.inputs.field(key, path)?;
    let (found, wanted) = (field.grid().shape(), config.shape());
    if found == wanted {
        return Ok(field);
    }
    Err(Error::Input {
        key: key.into(),
        reason: format!("`{path}` has {found:?} voxels, the box {wanted:?}"),
    })
}

/// Boxes in a row along x, each with a square hole along z, as a function that is negative inside.
fn holed_boxes(
    count: usize,
    half_width: f64,
    half_hole: f64,
    middle: [f64; 3],
) -> impl Fn([f64; 3]) -> f64 {
    move |p| {
        let [x, y, z] = [0, 1, 2].map(|m| p[m] - middle[m]);
        // Along x, from the middle of the nearest box.
        let last = count as f64 - 1.0;
        let nearest = (x / (2.0 * half_width) + 0.5 * last).round().clamp(0.0, last);
        let from_box = x - (nearest - 0.5 * last) * 2.0 * half_width;
        let solid = (x.abs() - count as f64 * half_width)
            .max(y.abs() - half_width)
            .max(z.abs() - 0.5 * half_width);
        let hole = (from_box.abs() - half_hole).max(y.abs() - half_hole);
        solid.max(-hole)
    }
}

/// `tanh(-d / (sqrt 2 epsilon))` of the distance d from the zeros of `shape`.
fn profile(config: &Config, shape: impl Fn([f64; 3]) -> f64 + Sync) -> Result<Vec<f64>> {
    let grid = Grid::new(&config.shape(), config.spacing)?;
    let mut phi = Field::from_fn(grid, shape);
    level_set::redistance(&mut phi, solvers::Boundary::Neumann)?;
    let width = std::f64::consts::SQRT_2 * config.epsilon;
    Ok(phi.as_slice().iter().map(|d| libm::tanh(-d / width)).collect())
}

fn positive(key: &str, value: f64) -> Result<()> {
    let good = value > 0.0 && value.is_finite();
    if good { Ok(()) } else { Err(Error::range(key, value, "(0, inf)")) }
}
