//! Shapes by name, their places, and their combinations.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use solvers::{
    Field, Grid,
    level_set::{Point, Shape},
};

/// A shape by name, by name at a place, or in full.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected the name of a shape, { name = NAME } with any of x, y, z, size and turn, \
                 or { kind = KIND } with all numbers of that kind"
)]
pub enum ShapeConfig {
    /// `circle`, `star`, ... in the middle of the grid.
    Name(String),
    /// The same at another place, of another size.
    Placed(Placed),
    /// Every number given, in cells.
    Full(Shape),
}

/// A shape by name at a place.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Placed {
    /// `circle`, `star`, ...
    pub name: String,
    /// Its middle (cells); absent: that of the grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// Its middle (cells); absent: that of the grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// Its middle (cells); absent: that of the grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Radius or half side (cells), above 0; absent: 30 % of the grid's least side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<f64>,
    /// Turn (degrees from x towards y).
    #[serde(default)]
    pub turn: f64,
}

impl ShapeConfig {
    /// The shape with all its numbers; `key` is the configuration's key, for messages.
    ///
    /// # Errors
    /// If there is no shape of the name, or a number is out of range.
    pub(super) fn shape(&self, key: &str, grid: Grid) -> Result<Shape> {
        let shape = match self {
            Self::Name(name) => named_shape(key, name, grid)?,
            Self::Placed(placed) => placed.shape(key, grid)?,
            Self::Full(shape) => shape.clone(),
        };
        shape.validate().map_err(|error| Error::config(key, error.to_string()))?;
        Ok(shape)
    }
}

impl Placed {
    fn shape(&self, key: &str, grid: Grid) -> Result<Shape> {
        let center = grid.center();
        let [x, y, z] = center;
        let middle = [self.x.unwrap_or(x), self.y.unwrap_or(y), self.z.unwrap_or(z)];
        let size = self.size.unwrap_or(named_radius(grid));
        if !(size > 0.0 && size.is_finite()) {
            return Err(Error::range(&format!("{key}.size"), size, "(0, inf)"));
        }
        let moved = |shape: Shape, shift: [f64; 3], turn: f64, scale: f64| Shape::Moved {
            shape: Box::new(shape),
            shift: Point(shift),
            turn,
            axis: Point([0.0, 0.0, 1.0]),
            scale,
        };
        let at_origin = moved(named_shape(key, &self.name, grid)?, center.map(|c| -c), 0.0, 1.0);
        Ok(moved(at_origin, middle, self.turn, size / named_radius(grid)))
    }
}

/// How shapes are combined with a front.
#[derive(Clone, Copy, Debug)]
pub(super) enum Combination {
    Union,
    Intersect,
    Subtract,
}

/// Combines `phi` with shapes, one after the other: the border is right, redistance the rest.
///
/// # Errors
/// As [`ShapeConfig::shape`].
pub(super) fn combine(phi: &mut Field, shapes: &[ShapeConfig], how: Combination) -> Result<()> {
    let key = match how {
        Combination::Union => "union",
        Combination::Intersect => "intersect",
        Combination::Subtract => "subtract",
    };
    let grid = phi.grid();
    for (n, shape) in shapes.iter().enumerate() {
        let key = format!("{key}.{n}");
        let other = shape.shape(&key, grid)?.field(grid)?;
        for (phi, d) in phi.as_mut_slice().iter_mut().zip(other.as_slice()) {
            *phi = match how {
                Combination::Union => phi.min(*d),
                Combination::Intersect => phi.max(*d),
                Combination::Subtract => phi.max(-d),
            };
        }
    }
    Ok(())
}

/// Size of the shapes that need no numbers: they fill 60 % of the grid's least side.
fn named_radius(grid: Grid) -> f64 {
    let least = grid.axes().iter().copied().min().unwrap_or(1);
    0.3 * least as f64 * grid.spacing()
}

/// Names of the shapes that need no numbers.
const NAMES: &[&str] =
    &["circle", "ellipse", "square", "star", "flower", "annulus", "zalesak", "dumbbell"];

/// A shape of that name in the middle of the grid, filling about 60 % of its least side.
fn named_shape(key: &str, name: &str, grid: Grid) -> Result<Shape> {
    let axes: Vec<f64> = grid.axes().iter().rev().map(|&n| n as f64 * grid.spacing()).collect();
    let radius = named_radius(grid);
    let [x, y, z] = grid.center();
    let center = Point([x, y, z]);
    let at = |dx: f64| Point([x + dx * radius, y, z]);
    Ok(match name {
        "circle" | "sphere" => Shape::Circle { center, radius },
        "ellipse" | "ellipsoid" => {
            let radii = [1.0, 0.6, 0.6].map(|f| f * radius)[..axes.len()].to_vec();
            Shape::Ellipse { center, radii }
        }
        "square" | "box" => {
            Shape::Box { center, size: vec![2.0 * radius; axes.len()], rounding: 0.0 }
        }
        "star" => Shape::Star { center, points: 5, outer: 1.3 * radius, inner: 0.6 * radius },
        "flower" => Shape::Flower { center, radius, amplitude: 0.3, lobes: 6 },
        "annulus" | "torus" => Shape::Torus { center, major: radius, minor: 0.4 * radius },
        "zalesak" => Shape::Zalesak {
            // The proportions of Zalesak 1979 on a domain of 100: radius 15 at (50, 75), slot 5 by 25.
            center: Point([x, y + axes[1] / 4.0, z]),
            radius: radius / 2.0,
            slot_width: radius / 6.0,
            slot_length: radius / 1.2,
        },
        "dumbbell" => Shape::Union {
            shapes: vec![
                Shape::Circle { center: at(-0.7), radius: 0.5 * radius },
                Shape::Circle { center: at(0.7), radius: 0.5 * radius },
                Shape::Capsule { from: at(-0.7), to: at(0.7), radius: 0.15 * radius },
            ],
        },
        _ => {
            let reason = format!("no shape `{name}`; known shapes: {}", NAMES.join(", "));
            return Err(Error::config(key, reason));
        }
    })
}
