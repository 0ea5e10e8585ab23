//! From the configuration to the energy.

use super::config::{Along, Axis, Boundary, Config};
use super::energy::{Edges, EnergyConfig, Orientation, Spatial};
use super::{Coefficients, start};
use crate::{Context, Error, Result};

/// The coefficients that are not varied along an axis.
pub(super) fn coefficients(config: &Config) -> Result<Coefficients> {
    match (config.coefficients, config.squares, &config.along) {
        (Some(a), _, _) => Ok(a.into()),
        (None, Some(squares), _) => Ok(squares.into()),
        (None, None, Some(along)) => Ok(along.stops[0].coefficients.into()),
        (None, None, None) => Err(Error::config("coefficients", "there are none")),
    }
}

/// The energy that the configuration writes out.
pub(super) fn energy(config: &Config, context: &Context<'_>) -> Result<EnergyConfig> {
    let coefficients = coefficients(config)?;
    let mut energy =
        EnergyConfig::new(config.shape(), config.spacing, config.epsilon, coefficients);
    energy.edges = match config.boundary {
        Boundary::Periodic => Edges::Periodic,
        Boundary::Replicated => Edges::Replicate,
        Boundary::Free => Edges::Free,
    };
    if let Some(along) = &config.along {
        energy.coefficients = [0, 1, 2, 3, 4, 5].map(|c| {
            Spatial::Map(spread(along, config.shape(), |stop| along.stops[stop].coefficients[c]))
        });
    }
    if let Some(orientation) = &config.orientation {
        let theta = match (&orientation.direction, &orientation.field) {
            (Some([x, y, z]), _) => {
                let length = (x * x + y * y + z * z).sqrt();
                [z, y, x].map(|d| Spatial::Uniform(d / length))
            }
            (None, Some(files)) => {
                let read = |file: &String| {
                    start::field("orientation.field", file, config, context)
                        .map(|field| Spatial::Map(field.as_slice().to_vec()))
                };
                let [x, y, z] = [read(&files[0])?, read(&files[1])?, read(&files[2])?];
                [z, y, x]
            }
            (None, None) => [0.0; 3].map(Spatial::Uniform),
        };
        energy.orientation = Some(Orientation { mu: Spatial::Uniform(orientation.weight), theta });
    }
    Ok(energy)
}

/// The mass at each voxel, if it varies.
pub(super) fn mass(config: &Config) -> Spatial {
    match &config.along {
        None => Spatial::Uniform(config.mass),
        Some(along) => Spatial::Map(spread(along, config.shape(), |stop| along.stops[stop].mass)),
    }
}

/// Linear interpolation of the stops' values at the voxels' middles, periodically.
fn spread(along: &Along, shape: [usize; 3], value: impl Fn(usize) -> f64) -> Vec<f64> {
    let axis = match along.axis {
        Axis::Z => 0,
        Axis::Y => 1,
        Axis::X => 2,
    };
    let n = shape[axis];
    let line: Vec<f64> = (0..n)
        .map(|i| {
            let at = (i as f64 + 0.5) / n as f64;
            let stops = &along.stops;
            let right = stops.iter().position(|stop| stop.at > at).unwrap_or(0);
            let left = (right + stops.len() - 1) % stops.len();
            let width = (stops[right].at - stops[left].at).rem_euclid(1.0);
            let t = (at - stops[left].at).rem_euclid(1.0) / if width > 0.0 { width } else { 1.0 };
            value(left) + (value(right) - value(left)) * t
        })
        .collect();
    let [nz, ny, nx] = shape;
    let voxel = |n: usize| line[[n / (ny * nx), n / nx % ny, n % nx][axis]];
    (0..nz * ny * nx).map(voxel).collect()
}

#[cfg(test)]
mod tests {
    use super::super::config::Stop;
    use super::*;

    #[test]
    fn stops_are_interpolated_around_the_period() {
        let stop = |at: f64, mass: f64| Stop { at, coefficients: [mass; 6], mass };
        let along =
            Along { axis: Axis::X, stops: vec![stop(0.25, 0.0), stop(0.5, 1.0), stop(0.75, 4.0)] };
        let line = spread(&along, [1, 2, 8], |n| along.stops[n].mass);
        let wanted = [1.5, 0.5, 0.25, 0.75, 1.75, 3.25, 3.5, 2.5];
        for (found, wanted) in line.iter().zip(wanted.iter().chain(&wanted)) {
            assert!((found - wanted).abs() < 1e-12, "{line:?}");
        }
    }
}
