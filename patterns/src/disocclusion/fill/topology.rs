//! A structure that is optimized again.
//!
//! The best matching problem as it is, if its design agrees with what is visible; else with
//! the visible solid and void fixed, so that the optimizer joins up what is hidden.

use super::super::candidate::{Ink, simulate};
use super::super::class::Class;
use super::super::normalize::Normal;
use super::{Fill, Made};
use crate::{Artifact, Colors, Context, Image, Inputs, Result, Status};
use rayon::prelude::*;
use solvers::isosurface::Polyline;
use solvers::random::{stream, uniform};
use solvers::texture::normalized_convolution;
use solvers::{Field, Grid};
use toml::{Table, Value};

/// Visible agreement from which the problem itself is taken.
const AGREES: f64 = 0.97;

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
    let own = simulate(class, point, settings.seed, inputs)?;
    let view = View::new(normal.shape, own.shape, settings.angle);
    let mut first = view.picture(&own, settings.inverted);
    let mut agreement = agreement(normal, &first);
    let mut levels = Vec::new();
    if agreement < AGREES
        // Where free elements carry next to nothing, rounding can stop the optimizer: the
        // problem itself then stands.
        && let Ok(Some(joined)) = joined(normal, class, point, settings, &view, inputs)
    {
        let picture = view.picture(&joined, settings.inverted);
        let better = self::agreement(normal, &picture);
        if better > agreement {
            (first, agreement) = (picture, better);
        }
    }
    levels.push(level(normal.shape, &first));
    let count = settings.samples.unwrap_or(NEIGHBOURS.0) as u64;
    let others = (1..count).into_par_iter().map(|index| {
        let mut random = stream(settings.seed, "neighbours", index);
        let shift =
            |s: &f64| (s + NEIGHBOURS.1 * (2.0 * uniform(&mut random) - 1.0)).clamp(0.0, 1.0);
        let near: Vec<f64> = point.iter().map(shift).collect();
        let ink = simulate(class, &near, settings.seed, inputs)?;
        Ok(level(normal.shape, &view.picture(&ink, settings.inverted)))
    });
    levels.extend(others.collect::<Result<Vec<_>>>()?);
    Ok(Made { levels, at_rim: agreement, range: f64::INFINITY, method: "topology" })
}

/// Smooth level of a picture, negative in the ink.
fn level(shape: [usize; 2], ink: &[bool]) -> Vec<f64> {
    let colours: Vec<f64> = ink.iter().map(|&ink| if ink { -1.0 } else { 1.0 }).collect();
    let mut level = normalized_convolution(shape, &colours, &vec![1.0; ink.len()], 0.7).0;
    level.iter_mut().zip(&colours).for_each(|(v, c)| *v = c * (c * *v).max(0.05));
    level
}

/// Share of the visible pixels of the same colour.
fn agreement(normal: &Normal, picture: &[bool]) -> f64 {
    let seen = (0..picture.len()).filter(|&n| normal.visible[n]);
    let (same, all) =
        seen.fold((0, 0), |(s, a), n| (s + usize::from(picture[n] == normal.ink[n]), a + 1));
    f64::from(same as u32) / f64::from(all.max(1) as u32)
}

/// How elements and pixels go together: the class's frame turned about the picture's middle.
struct View {
    picture: [usize; 2],
    elements: [usize; 2],
    /// Elements per pixel along the picture's row, turned.
    sin: f64,
    cos: f64,
}

impl View {
    fn new(picture: [usize; 2], elements: [usize; 2], angle: f64) -> Self {
        let ratio = |a: f64, b: f64| (a.ln() - b.ln()).abs();
        let (wide, high) = (picture[1] as f64, picture[0] as f64);
        let aspect = elements[1] as f64 / elements[0] as f64;
        // A picture on its side is a quarter turn of the class's frame.
        let width =
            if ratio(wide / high, aspect) <= ratio(high / wide, aspect) { wide } else { high };
        let scale = elements[1] as f64 / width;
        let (sin, cos) = (libm::sin(angle) * scale, libm::cos(angle) * scale);
        Self { picture, elements, sin, cos }
    }

    /// The element at a pixel of the picture; none outside the frame.
    fn element(&self, n: usize) -> Option<usize> {
        let [ny, nx] = self.picture;
        let [rows, columns] = self.elements;
        let y = (n / nx) as f64 + 0.5 - 0.5 * ny as f64;
        let x = (n % nx) as f64 + 0.5 - 0.5 * nx as f64;
        let u = self.cos * x + self.sin * y + 0.5 * columns as f64;
        let v = self.cos * y - self.sin * x + 0.5 * rows as f64;
        let inside = u >= 0.0 && v >= 0.0 && u < columns as f64 && v < rows as f64;
        inside.then(|| v as usize * columns + u as usize)
    }

    /// The design in the picture; outside its frame there is no material.
    fn picture(&self, design: &Ink, inverted: bool) -> Vec<bool> {
        let at = |n| self.element(n).is_some_and(|e| design.ink[e]) != inverted;
        (0..self.picture[0] * self.picture[1]).map(at).collect()
    }

    /// Share of solid among the visible pixels of each element that lie away from borders.
    fn solid(&self, normal: &Normal, inverted: bool) -> Vec<Option<f64>> {
        let scale = self.sin.hypot(self.cos);
        let weights: Vec<f64> =
            normal.visible.iter().map(|&seen| f64::from(u8::from(seen))).collect();
        let ink: Vec<f64> =
            normal.ink.iter().map(|&ink| f64::from(u8::from(ink != inverted))).collect();
        let near = normalized_convolution(normal.shape, &ink, &weights, LOOSE / scale).0;
        let mut sums = vec![(0.0, 0.0); self.elements[0] * self.elements[1]];
        for n in (0..near.len()).filter(|&n| normal.visible[n]) {
            if let Some(e) = self.element(n) {
                sums[e] = (sums[e].0 + near[n], sums[e].1 + 1.0);
            }
        }
        let full = 0.9 / (scale * scale);
        sums.iter().map(|&(sum, count)| (count >= full).then(|| sum / count)).collect()
    }
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
    view: &View,
    inputs: &(dyn Inputs + Sync),
) -> Result<Option<Ink>> {
    let solid = view.solid(normal, settings.inverted);
    let grid = Grid::new(&view.elements, 1.0)?;
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
    Ok(run.artifacts().iter().find_map(|artifact| match artifact {
        Artifact::Image(image) | Artifact::Drawing { image, .. } => design(image),
        _ => None,
    }))
}

/// Elements in which there is more solid than void.
fn design(image: &Image) -> Option<Ink> {
    let [_, ny, nx] = image.field.grid().shape();
    let ink = image.field.as_slice().iter().map(|&v| v < 0.5).collect();
    (image.colors == Colors::Ink).then_some(Ink { shape: [ny, nx], ink })
}
