//! What a run shows: the laboratory turns each into the files that people open.

use solvers::{
    Field,
    isosurface::{self, Polyline},
    mesh::TriangleMesh,
};

/// A named scalar.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// Name, `snake_case`.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Unit, `"1"` if none.
    pub unit: &'static str,
}

impl Metric {
    /// A metric.
    pub fn new(name: &str, value: f64, unit: &'static str) -> Self {
        Self { name: name.into(), value, unit }
    }
}

/// A named result; the laboratory picks the file formats.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Artifact {
    /// A scalar field: PNG (slice through the middle in 3D), NPY and VTI.
    Image(Image),
    /// A picture in ink with lines on top, in a margin of paper: PNG.
    Drawing {
        /// The picture.
        image: Image,
        /// The lines, in cells from the upper left corner of the first cell.
        strokes: Vec<Stroke>,
    },
    /// Lines in the plane: SVG and CSV.
    Contour {
        /// File stem.
        name: String,
        /// The lines (cells), from the picture's upper left corner.
        lines: Vec<Polyline>,
        /// Width and height of the picture, in the same unit.
        size: [f64; 2],
    },
    /// A surface: PNG, PLY, STL, OBJ and GLB.
    Mesh {
        /// File stem.
        name: String,
        /// The triangles.
        mesh: TriangleMesh,
    },
    /// A surface with colours and marks: the same, and a film around it if wanted.
    Surface(Surface),
    /// Curves in axes: SVG, PNG and CSV.
    Plot(Plot),
    /// Columns of numbers: CSV.
    Table {
        /// File stem.
        name: String,
        /// Heading and values of each column, all of one length.
        columns: Vec<(String, Vec<f64>)>,
    },
}

impl Artifact {
    /// The closed border of `phi < 0` in the plane, in the picture's coordinates: nodes are the
    /// middles of cells, so that the picture begins half a cell before them.
    pub(crate) fn contour(name: &str, phi: &Field) -> Self {
        let mut lines = isosurface::closed_contours(phi, 0.0);
        lines.iter_mut().flat_map(|l| &mut l.points).flatten().for_each(|v| *v += 0.5);
        let [_, ny, nx] = phi.grid().shape();
        Self::Contour { name: name.into(), lines, size: [nx as f64, ny as f64] }
    }
}

/// A scalar field and how to look at it.
#[derive(Clone, Debug)]
pub struct Image {
    /// File stem.
    pub name: String,
    /// The values.
    pub field: Field,
    /// What the values are, with their unit: `b (concentration)`.
    pub label: String,
    /// How numbers become colours.
    pub colors: Colors,
    /// Values at the two ends of the colormap; `None`: least and greatest.
    pub range: Option<[f64; 2]>,
    /// A level-set function on the same grid whose zero contour is drawn on top.
    pub contour: Option<Field>,
    /// What the rows are, if they are not places: label of the vertical axis with its unit,
    /// and its step from one row to the next.
    pub rows: Option<(&'static str, f64)>,
}

/// A surface and how to look at it. y grows downwards and z away from the viewer, as in the
/// pictures of fields.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// File stem.
    pub name: String,
    /// The triangles.
    pub mesh: TriangleMesh,
    /// Whether each triangle is a cut through the material, drawn dark; empty: none is.
    pub caps: Vec<bool>,
    /// A quantity on the surface, in false colours.
    pub values: Option<SurfaceValues>,
    /// Other bodies in the picture, such as arrows, with their colours (red, green, blue).
    pub marks: Vec<(TriangleMesh, [u8; 3])>,
    /// Lower and upper corner of a box whose edges are drawn.
    pub frame: Option<[[f64; 3]; 2]>,
    /// Pictures of a film that goes around the surface; 0 for none.
    pub turntable: usize,
}

/// A quantity at the vertices of a [`Surface`].
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceValues {
    /// One number for each vertex.
    pub values: Vec<f64>,
    /// What they are, with their unit: `mean curvature (1 / cell)`.
    pub label: String,
    /// How numbers become colours.
    pub colors: Colors,
    /// Values at the two ends of the colormap; `None`: least and greatest.
    pub range: Option<[f64; 2]>,
}

/// A straight line of a [`Artifact::Drawing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its ends `[x, y]` (cells).
    pub ends: [[f64; 2]; 2],
    /// Red, green, blue.
    pub color: [u8; 3],
}

/// Families of perceptually uniform colormaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Colors {
    /// From little to much.
    Sequential,
    /// Two sides of zero.
    Diverging,
    /// Black to white, without axes or scale: ink on paper.
    Ink,
}

/// Curves in axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// File stem.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// The curves; a legend is drawn for two or more.
    pub series: Vec<Series>,
}

/// An axis of a [`Plot`].
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit: `wavelength (cells)`.
    pub label: String,
    /// Logarithmic scale.
    pub log: bool,
    /// Fixed limits; `None`: those of the data.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis with limits from the data.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), log: false, range: None }
    }

    /// A logarithmic axis with limits from the data.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), log: true, range: None }
    }
}

/// A curve of a [`Plot`].
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend.
    pub label: String,
    /// `[x, y]`, in the axes' units.
    pub points: Vec<[f64; 2]>,
    /// How the points are drawn.
    pub mark: Mark,
}

/// How the points of a [`Series`] are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mark {
    /// Joined by a line.
    Line,
    /// Joined by a dashed line.
    Dashed,
    /// A dot each.
    Dots,
    /// A vertical line at each x, over the whole height.
    Vertical,
}
