//! Pictures of surfaces: ray traced, with soft shadows and ambient occlusion.
//!
//! Everything is fixed: the same shape gives the same bytes for any number of threads. Light
//! is taken at one point of each pixel, with samples that differ between neighbours and are
//! averaged over 4 x 4 of them where the surface goes on (interleaved sampling, Keller and
//! Heidrich 2001); edges are drawn from 16 points a pixel.
//!
//! The picture's axes: x right, y away from the viewer, z up; [`Up`] tells how the model's
//! axes become these.

mod camera;
mod geometry;
mod light;
mod sampling;
pub mod shapes;
mod trace;
mod vector;

use crate::output::colormap::Rgb;
use solvers::mesh::TriangleMesh;

pub use geometry::Stage;
pub(crate) use geometry::linear;

/// Surface of a part, seen from outside: the beige of the curvatubes paper.
pub const BEIGE: Rgb = [232, 214, 182];
/// The inside of a part, where it is cut.
pub const DARK: Rgb = [92, 62, 50];
/// Thin lines.
pub const LINE: Rgb = [120, 118, 114];
/// The background.
pub const PAPER: Rgb = [252, 251, 249];

/// A mesh and its colours.
#[derive(Clone, Debug)]
pub struct Part {
    /// The triangles; corners at equal places are taken as one.
    pub mesh: TriangleMesh,
    /// Colours of the outside.
    pub paint: Paint,
    /// Colour of the inside.
    pub inside: Rgb,
}

impl Part {
    /// A part of one colour, dark inside.
    pub fn new(mesh: TriangleMesh, color: Rgb) -> Self {
        Self { mesh, paint: Paint::Plain(color), inside: DARK }
    }
}

/// Colours of the outside of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Paint {
    /// One colour.
    Plain(Rgb),
    /// One colour for each triangle.
    Triangles(Vec<Rgb>),
    /// One colour for each vertex, mixed in between.
    Vertices(Vec<Rgb>),
}

/// Which way of the model is up in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// y grows downwards and z away from the viewer, as in the pictures of fields.
    #[default]
    MinusY,
    /// y grows upwards, z towards the viewer.
    Y,
    /// z grows upwards, y away from the viewer.
    Z,
}

/// From where a shape is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// How far right of the front the viewer stands (degrees).
    pub azimuth: f64,
    /// How far above (degrees, -90 to 90).
    pub elevation: f64,
    /// How depth is seen.
    pub projection: Projection,
    /// Which way is up.
    pub up: Up,
}

impl Default for View {
    fn default() -> Self {
        Self {
            azimuth: 30.0,
            elevation: 25.0,
            projection: Projection::Perspective { degrees: 24.0 },
            up: Up::default(),
        }
    }
}

/// How depth is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// What is farther is smaller; angle across the smaller side of the picture (degrees).
    Perspective {
        /// In (0, 120].
        degrees: f64,
    },
    /// Parallels stay parallel.
    Orthographic,
}

/// Where light comes from, and how much; a white surface that receives 1 is white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighting {
    /// Light of the key lamp on a surface that faces it.
    pub key: f64,
    /// How far right of the viewer and above the ground the lamp is (degrees).
    pub direction: [f64; 2],
    /// Angular radius of the lamp (degrees): how soft shadows are.
    pub radius: f64,
    /// Light of the open sky on a surface that faces upwards; half as much from below.
    pub sky: f64,
    /// Light of a lamp beside the viewer, without shadow.
    pub fill: f64,
    /// Whether there is a ground that receives shadows.
    pub ground: bool,
}

impl Default for Lighting {
    fn default() -> Self {
        Self { key: 0.62, direction: [-48.0, 52.0], radius: 7.0, sky: 0.5, fill: 0.1, ground: true }
    }
}

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels along x and y.
    pub size: [usize; 2],
    /// sRGB, row 0 at the top.
    pub pixels: Vec<Rgb>,
}

/// Draws parts in a picture of `size` pixels.
pub fn render(parts: &[Part], view: &View, light: &Lighting, size: [usize; 2]) -> Picture {
    Stage::new(parts, view.up).draw(view, light, size)
}
