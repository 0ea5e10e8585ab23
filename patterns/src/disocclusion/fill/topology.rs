//! A structure that is optimized again.
//!
//! The best matching problem as it is, if its design agrees with what is visible; else with
//! the visible solid and void fixed, so that the optimizer joins up what is hidden.

use super::super::candidate::{Ink, ink_of, simulate};
use super::super::class::Class;
use super::super::normalize::Normal;
use super::super::place::{Frame, Placement};
use super::super::scores::mean_squared_error;
use super::{Fill, Made};
use crate::{Context, Inputs, Result, Status};
use rayon::prelude::*;
use solvers::isosurface::Polyline;
use solvers::random::{stream, uniform};
use solvers::texture::normalized_convolution;
use solvers::{Field, Grid};
use toml::{Table, Value};

/// Share of visible pixels of another colour above which the problem itself is not taken.
const DIFFERS: f64 = 0.03;

/// Samples at neighbouring parameters, and how far they lie away (shares of the ranges).
const NEIGHBOURS: (usize, f64) = (4, 0.04);

/// Distance (elements) from a border of the visible design within which nothing is fixed:
/// there a picture's pixels and the mesh's elements need not agree.
const LOOSE: f64 = 0.8;

/// Fills the holes of `normal`.
pub(super) fn run(
    normal: &Normal,
    class: &Class,
    point: &[f64],
    settings: &Fill,
    inputs: &(dyn Inputs + Sync),
) -> Result<Made> {
    let placement =
        Placement { inverted: settings.inverted, angle: Some(settings.angle), scale: 1.0 };
    let place = |design: &Ink| placement.place(design, normal.shape);
    let own = simulate(class, point, settings.seed, inputs)?;
    let mut first = place(&own);
    let mut error = mean_squared_error(normal, &first);
    if error > DIFFERS
        // Where free elements carry next to nothing, rounding can stop the optimizer: the
        // problem itself then stands.
        && let Ok(Some(joined)) = joined(normal, class, point, settings, own.shape, inputs)
    {
        let picture = place(&joined);
        let better = mean_squared_error(normal, &picture);
        if better < error {
            (first, error) = (picture, better);
        }
    }
    let mut levels = vec![level(&first)];
    let count = settings.samples.unwrap_or(NEIGHBOURS.0) as u64;
    let others = (1..count).into_par_iter().map(|index| {
        let mut random = stream(settings.seed, "neighbours", index);
        let shift =
            |s: &f64| (s + NEIGHBOURS.1 * (2.0 * uniform(&mut random) - 1.0)).clamp(0.0, 1.0);
        let near: Vec<f64> = point.iter().map(shift).collect();
        Ok(level(&place(&simulate(class, &near, settings.seed, inputs)?)))
    });
    levels.extend(others.collect::<Result<Vec<_>>>()?);
    Ok(Made { levels, at_rim: 1.0 - error, range: f64::INFINITY, method: "topology" })
}

/// Smooth level of a picture, negative in the ink.
fn level(picture: &Ink) -> Vec<f64> {
    let colours: Vec<f64> = picture.ink.iter().map(|&ink| if ink { -1.0 } else { 1.0 }).collect();
    let mut level =
        normalized_convolution(picture.shape, &colours, &vec![1.0; colours.len()], 0.7).0;
    level.iter_mut().zip(&colours).for_each(|(v, c)| *v = c * (c * *v).max(0.05));
    level
}

/// Share of solid among the visible pixels of each of the class's elements that lie away from
/// borders; none where too few are visible.
fn solid(normal: &Normal, elements: [usize; 2], settings: &Fill) -> Vec<Option<f64>> {
    let frame = Frame::new(normal.shape, elements, settings.angle);
    let scale = frame.scale();
    let weights: Vec<f64> = normal.visible.iter().map(|&seen| f64::from(u8::from(seen))).collect();
    let ink = normal.ink.iter().map(|&ink| f64::from(u8::from(ink != settings.inverted)));
    let ink: Vec<f64> = ink.collect();
    let near = normalized_convolution(normal.shape, &ink, &weights, LOOSE / scale).0;
    let mut sums = vec![(0.0, 0.0); elements[0] * elements[1]];
    for n in (0..near.len()).filter(|&n| normal.visible[n]) {
        if let Some(e) = frame.find(n) {
            sums[e] = (sums[e].0 + near[n], sums[e].1 + 1.0);
        }
    }
    let full = 0.9 / (scale * scale);
    sums.iter().map(|&(sum, count)| (count >= full).then(|| sum / count)).collect()
}

/// The caller's files, and two pictures of fixed material.
struct WithMaterial<'a> {
    inputs: &'a (dyn Inputs + Sync),
    fields: [(&'static str, Field); 2],
}

impl Inputs for WithMaterial<'_> {
    fn field(&self, key: &str, path: &str) -> Result<Field> {
        match self.fields.iter().find(|(name, _)| *name == path) {
            Some((_, field)) => Ok(field.clone()),
            None => self.inputs.field(key, path),
        }
    }

    fn lines(&self, key: &str, path: &str) -> Result<Vec<Polyline>> {
        self.inputs.lines(key, path)
    }
}

/// The design with the visible solid and void fixed; none where nothing can be fixed.
fn joined(
    normal: &Normal,
    class: &Class,
    point: &[f64],
    settings: &Fill,
    elements: [usize; 2],
    inputs: &(dyn Inputs + Sync),
) -> Result<Option<Ink>> {
    let solid = solid(normal, elements, settings);
    let grid = Grid::new(&elements, 1.0)?;
    let marked = |test: &dyn Fn(f64) -> bool| -> Result<Option<Field>> {
        let dark: Vec<bool> = solid.iter().map(|s| s.is_some_and(test)).collect();
        let values = dark.iter().map(|&dark| if dark { 0.0 } else { 1.0 }).collect();
        let some = dark.contains(&true);
        Ok(if some { Some(Field::from_vec(grid, values)?) } else { None })
    };
    let (Some(full), Some(void)) = (marked(&|s| s > 0.95)?, marked(&|s| s < 0.05)?) else {
        return Ok(None);
    };
    let names = ["visible solid", "visible void"];
    let fields = [(names[0], full), (names[1], void)];
    let mut config = class.configure(point)?;
    let mut regions = Vec::new();
    for (material, name) in ["solid", "void"].into_iter().zip(names) {
        let mut region = Table::new();
        region.insert("material".into(), material.into());
        region.insert("image".into(), name.into());
        regions.push(Value::Table(region));
    }
    let Some(problem) = config.get_mut("problem").and_then(Value::as_table_mut) else {
        return Ok(None);
    };
    match problem.get_mut("passive").and_then(Value::as_array_mut) {
        Some(list) => list.extend(regions),
        None => {
            problem.insert("passive".into(), Value::Array(regions));
        }
    }
    let inputs = WithMaterial { inputs, fields };
    let context = Context { seed: settings.seed, inputs: &inputs, memory: 1 << 30 };
    let mut run = (class.model.start)(&config, &context)?;
    while run.step()? == Status::Running {}
    Ok(run.artifacts().iter().find_map(ink_of))
}
