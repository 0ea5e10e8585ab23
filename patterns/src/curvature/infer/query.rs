//! The given shape as a phase field, and its curvature diagram.

use super::config::{Config, Inside};
use super::cuts::inner;
use crate::curvature::energy::{Edges, Energy, EnergyConfig};
use crate::curvature::{Coefficients, Diagram, view};
use crate::{Context, Error, Result};
use solvers::blur::{Blur, BlurEdges};
use solvers::isosurface::{self, Caps};
use solvers::mesh::TriangleMesh;
use solvers::{Boundary, Field, Grid, level_set, transport::PointCloud};

/// Voxels across a mesh, at most.
const LARGEST: f64 = 400.0;

/// A field whose gradient is this near to that of a phase is taken as one.
const PHASE: f64 = 0.5;

/// Voxels around the cuts of a surface in which the distance from it, that a phase is made of, is
/// not that from the whole surface.
const CUT: f64 = 3.0;

/// The least part of a surface that stands for all of it.
const LEAST: f64 = 0.1;

/// What there is to know of the given shape.
pub(super) struct Query {
    /// The phase, near 1 inside and near -1 outside.
    pub(super) phase: Field,
    pub(super) diagram: Diagram,
    pub(super) cloud: PointCloud<2>,
    /// Mean of the phase.
    pub(super) mass: f64,
    /// Area of the surface over the volume of the box (1/length).
    pub(super) area: f64,
    /// How the file was read.
    pub(super) note: String,
}

impl Query {
    /// Reads the shape.
    ///
    /// # Errors
    /// If it cannot be read, is not of three axes, is larger than memory or has no surface.
    pub(super) fn read(config: &Config, context: &Context<'_>) -> Result<Self> {
        let refuse = |reason: String| Error::Input { key: "shape".into(), reason };
        let h = config.spacing();
        let read = match context.inputs.mesh("shape", &config.shape)? {
            Some(mesh) => {
                let cells = voxels(&mesh, h, context).map_err(refuse)?;
                let note = "a mesh".to_owned();
                Read { phase: profile(cells, 0.5, config)?, note, margin: CUT }
            }
            None => {
                let given = context.inputs.field("shape", &config.shape)?;
                if given.grid().dim() != 3 || given.grid().shape().iter().any(|&n| n < 8) {
                    let reason = format!(
                        "`{}` has the shape {:?}; wanted are three axes of at least 8 voxels",
                        config.shape,
                        given.grid().axes()
                    );
                    return Err(refuse(reason));
                }
                crate::check_memory("shape", given.grid(), 100, context)?;
                let grid = Grid::new(&given.grid().shape(), h)?;
                volume(Field::from_vec(grid, given.as_slice().to_vec())?, config)?
            }
        };
        Self::of(read, config)
    }

    fn of(read: Read, config: &Config) -> Result<Self> {
        let Read { phase, mut note, margin } = read;
        let grid = phase.grid();
        let sphere = Coefficients { a20: 1.0, a11: 0.0, a02: 1.0, b10: 0.0, b01: 0.0, c: 0.0 };
        let mut energy =
            EnergyConfig::new(grid.shape(), grid.spacing(), config.growth.epsilon, sphere);
        energy.edges = Edges::Replicate;
        let energy = Energy::<f64>::new(energy)?;
        let mesh = view::surface(phase.clone(), 0.0, Caps::Open).mesh;
        let mut inner = inner(&mesh, grid, margin);
        let part = inner.area() / mesh.area();
        if part < LEAST {
            inner = mesh.clone();
            note += "; all of its surface is near the faces of its box, which bend it";
        } else {
            note += &format!("; {:.0} % of its surface is off the faces of its box", 100.0 * part);
        }
        let diagram = Diagram::of(&energy, phase.as_slice(), &inner)?;
        let Some(cloud) = diagram.cloud(0)? else {
            let reason = format!("`{}` has no surface at that level", config.shape);
            return Err(Error::Input { key: "shape".into(), reason });
        };
        let n = phase.as_slice().len() as f64;
        let mass = solvers::field::sum(phase.as_slice(), |u| u) / n;
        let area = mesh.area() / (n * grid.spacing().powi(3));
        Ok(Self { phase, diagram, cloud, mass: mass.clamp(-0.99, 0.99), area, note })
    }
}

/// What a file holds.
struct Read {
    phase: Field,
    note: String,
    /// Voxels around the cuts of the surface that are not to be measured.
    margin: f64,
}

/// A mesh in the box around it: the part of each voxel that is inside.
fn voxels(
    mesh: &TriangleMesh,
    h: f64,
    context: &Context<'_>,
) -> std::result::Result<Field, String> {
    let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for v in &mesh.vertices {
        for m in 0..3 {
            corners[0][m] = corners[0][m].min(v[m]);
            corners[1][m] = corners[1][m].max(v[m]);
        }
    }
    let size = [0, 1, 2].map(|m| ((corners[1][m] - corners[0][m]) / h).round());
    if !size.iter().all(|n| (8.0..=LARGEST).contains(n)) {
        return Err(format!(
            "the mesh is {:.3} x {:.3} x {:.3} voxels of width {h}; wanted are 8 to {LARGEST} along \
             each axis: give --spacing, or scale the mesh",
            size[0], size[1], size[2]
        ));
    }
    let [nx, ny, nz] = size.map(|n| n as usize);
    let grid = Grid::new(&[nz, ny, nx], h).map_err(|error| error.to_string())?;
    crate::check_memory("shape", grid, 100, context).map_err(|error| error.to_string())?;
    let origin = corners[0].map(|low| low + 0.5 * h);
    mesh.occupancy(grid, origin).map_err(|error| error.to_string())
}

/// A volume as a phase, and what it was taken for.
fn volume(mut given: Field, config: &Config) -> Result<Read> {
    if let Some(label) = config.label {
        given.as_mut_slice().iter_mut().for_each(|v| *v = f64::from(u8::from(*v == label)));
        let count = given.as_slice().iter().filter(|&&v| v == 1.0).count();
        if count == 0 || count == given.as_slice().len() {
            let which = if count == 0 { "no" } else { "every" };
            let reason = format!("{which} voxel of `{}` has the value {label}", config.shape);
            return Err(Error::config("label", reason));
        }
    }
    let (low, high) = given.range();
    let middle = if low < 0.0 && high > 0.0 { 0.0 } else { 0.5 * (low + high) };
    let level = config.level.unwrap_or(middle);
    if low >= high {
        let reason = format!("every voxel of `{}` has the value {low}", config.shape);
        return Err(Error::Input { key: "shape".into(), reason });
    }
    if !(low < level && level < high) {
        return Err(Error::range("level", level, &format!("({low}, {high}), the volume's values")));
    }
    let sign = if config.inside == Inside::Above { 1.0 } else { -1.0 };
    let whole = low > -1.5 && high < 1.5 && level == 0.0;
    if whole && is_phase(&given, config.growth.epsilon)? {
        given.as_mut_slice().iter_mut().for_each(|v| *v *= sign);
        let note = "a phase field, taken as it is".into();
        return Ok(Read { phase: given, note, margin: 0.0 });
    }
    let two = given.as_slice().iter().all(|&v| v == low || v == high);
    let note = match two && config.smooth > 0.0 {
        true => format!("a volume of two values, blurred by {} voxels", config.smooth),
        false => format!("a volume with its surface at {level}"),
    };
    let mut level = level;
    let mut margin = CUT;
    if two && config.smooth > 0.0 {
        // The blur sees no farther than that.
        margin += 2.0 * config.smooth;
        let inside = given.as_slice().iter().filter(|&&v| v > level).count();
        given = blurred(&given, config.smooth)?;
        level = same_volume(&given, inside);
    }
    given.as_mut_slice().iter_mut().for_each(|v| *v = sign * (*v - level));
    Ok(Read { phase: profile(given, 0.0, config)?, note, margin })
}

/// Whether values change as those of a phase of that width do.
fn is_phase(given: &Field, epsilon: f64) -> Result<bool> {
    let grid = given.grid();
    let plain = Coefficients { a20: 1.0, a11: 0.0, a02: 1.0, b10: 0.0, b01: 0.0, c: 0.0 };
    let mut config = EnergyConfig::new(grid.shape(), grid.spacing(), epsilon, plain);
    config.edges = Edges::Replicate;
    Ok(Energy::<f64>::new(config)?.discrepancy(given.as_slice()) < PHASE)
}

/// The level above which as many voxels lie: a blur alone would make thin tubes thinner.
fn same_volume(blurred: &Field, inside: usize) -> f64 {
    let mut values = blurred.as_slice().to_vec();
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    let last = inside.clamp(1, values.len() - 1);
    0.5 * (values[last - 1] + values[last])
}

fn blurred(given: &Field, sigma: f64) -> Result<Field> {
    let mut blur = Blur::<f64>::new(given.grid().shape(), sigma, BlurEdges::Replicate)?;
    let (mut between, mut out) = (given.as_slice().to_vec(), given.as_slice().to_vec());
    blur.apply(given.as_slice(), &mut between, &mut out);
    Ok(Field::from_vec(given.grid(), out)?)
}

/// `tanh(d / (sqrt 2 epsilon))` of the distance d from the surface at `level`, positive above.
fn profile(values: Field, level: f64, config: &Config) -> Result<Field> {
    let mut phi = values;
    phi.as_mut_slice().iter_mut().for_each(|v| *v = level - *v);
    if isosurface::surface(&phi, 0.0, Caps::Open)?.mesh.triangles.is_empty() {
        let reason = format!("`{}` has no surface at that level", config.shape);
        return Err(Error::Input { key: "shape".into(), reason });
    }
    level_set::redistance(&mut phi, Boundary::Neumann)?;
    let width = std::f64::consts::SQRT_2 * config.growth.epsilon;
    phi.as_mut_slice().iter_mut().for_each(|d| *d = libm::tanh(-*d / width));
    Ok(phi)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cylinder that leaves the box at a slant, as a phase and in two values: 1 / radius and 0
    /// all along, which the voxels at the faces do not show.
    #[test]
    fn a_cut_shape_is_measured_away_from_the_cuts() {
        let (grid, radius) = (Grid::new(&[40; 3], 0.01).unwrap(), 0.08);
        let axis = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];
        let config = Config { shape: "given".into(), ..Config::default() };
        let inside = Field::from_fn(grid, |p| {
            let from = p.map(|x| x - 0.2);
            let along: f64 = from.iter().zip(axis).map(|(x, a)| x * a).sum();
            let square: f64 = from.iter().map(|x| x * x).sum::<f64>() - along * along;
            radius - square.max(0.0).sqrt()
        });
        let width = std::f64::consts::SQRT_2 * config.growth.epsilon;
        let of = |value: &dyn Fn(f64) -> f64| {
            let values = inside.as_slice().iter().map(|&d| value(d)).collect();
            let read = volume(Field::from_vec(grid, values).unwrap(), &config).unwrap();
            Query::of(read, &config).unwrap()
        };
        let two = of(&|d| f64::from(u8::from(d > 0.0)));
        for (query, bound) in [(of(&|d| libm::tanh(d / width)), 0.03), (two, 0.2)] {
            let pairs = query.diagram.0.values.iter().zip(&query.diagram.0.weights);
            let square = |k: &[f64; 2]| (k[0] - 1.0 / radius).powi(2) + k[1].powi(2);
            let off =
                (pairs.map(|(k, w)| square(k) * w).sum::<f64>() / query.diagram.area()).sqrt();
            assert!(off < bound / radius, "{}: {off}", query.note);
            // The area is that of the whole surface.
            let whole = query.area * 64e-3;
            assert!(query.diagram.area() < 0.95 * whole, "{} {whole}", query.diagram.area());
        }
    }
}
