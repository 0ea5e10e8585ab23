//! Analytic shapes: signed distances that need no grid, and their combinations.

mod curves;
mod polygon;

use crate::{Error, Field, Grid, Result};
use serde::{Deserialize, Serialize};

/// A position or vector `[x]`, `[x, y]` or `[x, y, z]` (length); absent components are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct Point(pub [f64; 3]);

impl TryFrom<Vec<f64>> for Point {
    type Error = String;

    fn try_from(v: Vec<f64>) -> std::result::Result<Self, String> {
        if v.is_empty() || v.len() > 3 {
            return Err(format!("a point has 1 to 3 components, found {}", v.len()));
        }
        Ok(Self(std::array::from_fn(|m| v.get(m).copied().unwrap_or(0.0))))
    }
}

impl From<Point> for Vec<f64> {
    fn from(p: Point) -> Self {
        let last = p.0.iter().rposition(|&c| c != 0.0).unwrap_or(0);
        p.0[..=last.max(1)].to_vec()
    }
}

/// A shape, negative inside. All lengths in the grid's unit, angles in degrees.
///
/// Every primitive is an exact signed distance; so are `complement`, `moved`, and
/// the outside of a `union`. The inside of a union and both sides of the other
/// combinations have the right contour and a slope of at most 1; redistance the
/// field where the exact distance matters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Shape {
    /// A disk, in space a ball.
    #[serde(alias = "sphere")]
    Circle {
        /// Its middle.
        center: Point,
        /// Its radius, above 0.
        radius: f64,
    },
    /// A solid ellipse (two semi-axes; in space a cylinder along z) or ellipsoid (three).
    #[serde(alias = "ellipsoid")]
    Ellipse {
        /// Its middle.
        center: Point,
        /// Semi-axes along x, y and perhaps z, each above 0.
        radii: Vec<f64>,
    },
    /// A rectangle (two sizes; in space a prism along z) or box (three).
    #[serde(alias = "rectangle")]
    Box {
        /// Its middle.
        center: Point,
        /// Full side lengths along x, y and perhaps z, each above 0.
        size: Vec<f64>,
        /// Radius of the edges, at most half the smallest side.
        #[serde(default)]
        rounding: f64,
    },
    /// A star with straight sides, a point of it straight along +x.
    Star {
        /// Its middle.
        center: Point,
        /// Number of points, at least 2.
        points: usize,
        /// Distance of the points from the middle.
        outer: f64,
        /// Distance of the inner corners from the middle.
        inner: f64,
    },
    /// The smooth star r(theta) = radius (1 + amplitude cos(lobes theta)).
    Flower {
        /// Its middle.
        center: Point,
        /// Mean radius, above 0.
        radius: f64,
        /// Relative amplitude, in [0, 1).
        amplitude: f64,
        /// Number of lobes, at least 1.
        lobes: usize,
    },
    /// Everything behind a line or plane.
    #[serde(alias = "half-space")]
    HalfPlane {
        /// A point on the border.
        point: Point,
        /// Outward direction, of any length but 0.
        normal: Point,
    },
    /// All points within `radius` of a segment.
    Capsule {
        /// One end of the segment.
        from: Point,
        /// The other end.
        to: Point,
        /// Distance from the segment, above 0.
        radius: f64,
    },
    /// A ring around the z axis; in the plane an annulus.
    #[serde(alias = "annulus")]
    Torus {
        /// Its middle.
        center: Point,
        /// Radius of the middle line, above 0.
        major: f64,
        /// Radius of the tube, above 0.
        minor: f64,
    },
    /// A disk with a slot from below (Zalesak 1979).
    Zalesak {
        /// Middle of the disk.
        center: Point,
        /// Radius of the disk, above 0.
        radius: f64,
        /// Width of the slot, in (0, 2 radius).
        slot_width: f64,
        /// Length of the slot from the lowest point of the disk, in (0, 2 radius).
        slot_length: f64,
    },
    /// A polygon, convex or not; inside by the even-odd rule.
    Polygon {
        /// Its corners, at least 3, in either sense.
        points: Vec<[f64; 2]>,
    },
    /// A shape scaled, turned and then shifted.
    Moved {
        /// What is moved.
        shape: std::boxed::Box<Shape>,
        /// Shift.
        #[serde(default)]
        shift: Point,
        /// Turn (degrees, counter-clockwise seen from the tip of `axis`).
        #[serde(default)]
        turn: f64,
        /// Axis of the turn through the origin.
        #[serde(default = "z_axis")]
        axis: Point,
        /// Factor, above 0.
        #[serde(default = "one")]
        scale: f64,
    },
    /// Where any of the shapes is.
    Union {
        /// At least one.
        shapes: Vec<Shape>,
    },
    /// Where all of the shapes are.
    Intersection {
        /// At least one.
        shapes: Vec<Shape>,
    },
    /// The first shape without the others.
    Difference {
        /// What remains.
        from: std::boxed::Box<Shape>,
        /// What is cut away.
        minus: Vec<Shape>,
    },
    /// A union whose creases are filled: the quadratic blend over `radius`.
    SmoothUnion {
        /// At least one.
        shapes: Vec<Shape>,
        /// Distance over which shapes melt together, above 0.
        radius: f64,
    },
    /// Everything outside a shape.
    Complement {
        /// What is left out.
        shape: std::boxed::Box<Shape>,
    },
}

fn z_axis() -> Point {
    Point([0.0, 0.0, 1.0])
}

fn one() -> f64 {
    1.0
}

impl Shape {
    /// Samples the shape on `grid`.
    ///
    /// # Errors
    /// As [`Shape::validate`].
    pub fn field(&self, grid: Grid) -> Result<Field> {
        self.validate()?;
        Ok(Field::from_fn(grid, |p| self.distance(p)))
    }

    /// Signed distance at `p = [x, y, z]`, negative inside; see [`Shape`] for where it is exact.
    pub fn distance(&self, p: [f64; 3]) -> f64 {
        match self {
            Self::Circle { center, radius } => norm(minus(p, center.0)) - radius,
            Self::Ellipse { center, radii } => curves::ellipsoid(minus(p, center.0), radii),
            Self::Box { center, size, rounding } => cuboid(minus(p, center.0), size, *rounding),
            Self::Star { center, points, outer, inner } => {
                polygon::star(minus(p, center.0), *points, *outer, *inner)
            }
            Self::Flower { center, radius, amplitude, lobes } => {
                curves::flower(minus(p, center.0), *radius, *amplitude, *lobes)
            }
            Self::HalfPlane { point, normal } => dot(minus(p, point.0), normal.0) / norm(normal.0),
            Self::Capsule { from, to, radius } => polygon::to_segment(p, from.0, to.0) - radius,
            Self::Torus { center, major, minor } => {
                let [x, y, z] = minus(p, center.0);
                (x.hypot(y) - major).hypot(z) - minor
            }
            Self::Zalesak { center, radius, slot_width, slot_length } => {
                curves::zalesak(minus(p, center.0), *radius, *slot_width, *slot_length)
            }
            Self::Polygon { points } => {
                polygon::distance([p[0], p[1]], points.len(), |m| points[m])
            }
            Self::Moved { shape, shift, turn, axis, scale } => {
                let q = rotate(minus(p, shift.0), axis.0, -turn.to_radians());
                scale * shape.distance(q.map(|c| c / scale))
            }
            Self::Union { shapes } => fold(shapes, p, f64::min),
            Self::Intersection { shapes } => fold(shapes, p, f64::max),
            Self::Difference { from, minus } => {
                minus.iter().fold(from.distance(p), |d, s| d.max(-s.distance(p)))
            }
            Self::SmoothUnion { shapes, radius } => fold(shapes, p, |a, b| {
                let overlap = (radius - (a - b).abs()).max(0.0);
                a.min(b) - overlap * overlap / (4.0 * radius)
            }),
            Self::Complement { shape } => -shape.distance(p),
        }
    }

    /// Refuses impossible sizes, in this shape and all its parts.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] or [`Error::Invalid`] with the name and value of the quantity.
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Circle { center, radius } => {
                finite("circle.center", &center.0)?;
                positive("circle.radius", *radius)
            }
            Self::Ellipse { center, radii } => {
                finite("ellipse.center", &center.0)?;
                sizes("ellipse.radii", radii)
            }
            Self::Box { center, size, rounding } => {
                finite("box.center", &center.0)?;
                sizes("box.size", size)?;
                let most = 0.5 * size.iter().copied().fold(f64::INFINITY, f64::min);
                within(
                    "box.rounding",
                    *rounding,
                    (0.0..=most).contains(rounding),
                    &format!("[0, {most}]"),
                )
            }
            Self::Star { center, points, outer, inner } => {
                finite("star.center", &center.0)?;
                within("star.points", *points as f64, *points >= 2, "[2, inf)")?;
                positive("star.outer", *outer)?;
                positive("star.inner", *inner)
            }
            Self::Flower { center, radius, amplitude, lobes } => {
                finite("flower.center", &center.0)?;
                positive("flower.radius", *radius)?;
                within("flower.amplitude", *amplitude, (0.0..1.0).contains(amplitude), "[0, 1)")?;
                within("flower.lobes", *lobes as f64, (1..=1000).contains(lobes), "[1, 1000]")
            }
            Self::HalfPlane { point, normal } => {
                finite("half-plane.point", &point.0)?;
                positive("half-plane.normal length", norm(normal.0))
            }
            Self::Capsule { from, to, radius } => {
                finite("capsule.from", &from.0)?;
                finite("capsule.to", &to.0)?;
                positive("capsule.radius", *radius)
            }
            Self::Torus { center, major, minor } => {
                finite("torus.center", &center.0)?;
                positive("torus.major", *major)?;
                positive("torus.minor", *minor)
            }
            Self::Zalesak { center, radius, slot_width, slot_length } => {
                finite("zalesak.center", &center.0)?;
                positive("zalesak.radius", *radius)?;
                let range = format!("(0, {})", 2.0 * radius);
                let fits = |v: f64| v > 0.0 && v < 2.0 * radius;
                within("zalesak.slot_width", *slot_width, fits(*slot_width), &range)?;
                within("zalesak.slot_length", *slot_length, fits(*slot_length), &range)
            }
            Self::Polygon { points } => {
                at_least("polygon.points", points.len(), 3)?;
                points.iter().try_for_each(|p| finite("polygon.points", p))
            }
            Self::Moved { shape, shift, turn, axis, scale } => {
                finite("moved.shift", &shift.0)?;
                finite("moved.turn", &[*turn])?;
                positive("moved.axis length", norm(axis.0))?;
                positive("moved.scale", *scale)?;
                shape.validate()
            }
            Self::Union { shapes } | Self::Intersection { shapes } => all(shapes),
            Self::SmoothUnion { shapes, radius } => {
                positive("smooth-union.radius", *radius)?;
                all(shapes)
            }
            Self::Difference { from, minus } => {
                from.validate()?;
                minus.iter().try_for_each(Self::validate)
            }
            Self::Complement { shape } => shape.validate(),
        }
    }
}

fn within(name: &str, value: f64, fits: bool, range: &str) -> Result<()> {
    if fits { Ok(()) } else { Err(Error::out_of_range(name, value, range)) }
}

fn positive(name: &str, value: f64) -> Result<()> {
    within(name, value, value > 0.0 && value.is_finite(), "(0, inf)")
}

fn finite(name: &str, values: &[f64]) -> Result<()> {
    let bad = values.iter().find(|v| !v.is_finite());
    bad.map_or(Ok(()), |&v| Err(Error::out_of_range(name, v, "(-inf, inf)")))
}

fn sizes(name: &str, values: &[f64]) -> Result<()> {
    if !(1..=3).contains(&values.len()) {
        return Err(Error::Invalid(format!(
            "{name} has {} entries, expected 1 to 3",
            values.len()
        )));
    }
    values.iter().try_for_each(|&v| positive(name, v))
}

fn at_least(name: &str, count: usize, least: usize) -> Result<()> {
    if count >= least {
        return Ok(());
    }
    Err(Error::Invalid(format!("{name} has {count} entries, expected at least {least}")))
}

fn all(shapes: &[Shape]) -> Result<()> {
    at_least("shapes", shapes.len(), 1)?;
    shapes.iter().try_for_each(Shape::validate)
}

fn fold(shapes: &[Shape], p: [f64; 3], f: impl Fn(f64, f64) -> f64) -> f64 {
    shapes.iter().map(|s| s.distance(p)).reduce(f).unwrap_or(f64::INFINITY)
}

/// Box of full sides `size` around the origin; sides that are not given are endless.
fn cuboid(p: [f64; 3], size: &[f64], rounding: f64) -> f64 {
    let (mut outside, mut inside) = (0.0, f64::NEG_INFINITY);
    for (c, side) in p.iter().zip(size) {
        let q = c.abs() - 0.5 * side + rounding;
        outside += q.max(0.0) * q.max(0.0);
        inside = inside.max(q);
    }
    f64::sqrt(outside) + inside.min(0.0) - rounding
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Rodrigues' rotation of `p` about `axis` by `angle` (radians).
fn rotate(p: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    if angle == 0.0 {
        return p;
    }
    let k = axis.map(|c| c / norm(axis));
    let (sin, cos) = angle.sin_cos();
    let cross = [k[1] * p[2] - k[2] * p[1], k[2] * p[0] - k[0] * p[2], k[0] * p[1] - k[1] * p[0]];
    let along = dot(k, p) * (1.0 - cos);
    std::array::from_fn(|m| p[m] * cos + cross[m] * sin + k[m] * along)
}
