//! What an inference shows.

use super::proof::Found;
use super::query::Query;
use super::search::Search;
use crate::curvature::atlas::NAMES;
use crate::curvature::view;
use crate::{Artifact, Axis, Mark, Plot, Series};
use solvers::isosurface::Caps;
use solvers::{Field, transport::PointCloud};

/// Triangles of the given shape's diagram in the picture.
const DOTS: usize = 3000;

pub(super) fn artifacts(
    query: &Query,
    nearest: &[([f64; 6], f64)],
    search: Option<&Search>,
    found: Option<&Found>,
) -> Vec<Artifact> {
    let near: Vec<([f64; 6], &[f64])> =
        nearest.iter().map(|(p, distance)| (*p, std::slice::from_ref(distance))).collect();
    let near = table("nearest", &["distance (1/length)"], &near);
    let mut artifacts = vec![shape("given", &query.phase, Caps::Closed), near];
    if let Some(search) = search.filter(|search| !search.told.is_empty()) {
        artifacts.push(candidates(search));
        artifacts.push(progress(nearest, &search.least(), found));
    }
    if let Some(found) = found {
        artifacts.push(shape("found", &found.shape.phase, Caps::PeriodicClosed));
        artifacts.push(diagrams(query, &found.shape.diagram));
    }
    artifacts
}

fn shape(name: &str, phase: &Field, caps: Caps) -> Artifact {
    let grid = phase.grid();
    let [nz, ny, nx] = grid.shape().map(|n| n as f64 * grid.spacing());
    let surface = view::surface(phase.clone(), 0.0, caps);
    Artifact::Surface(view::shape(name, surface, [nx, ny, nz]))
}

/// Parameters, and what else there is to them.
fn table(name: &str, others: &[&str], rows: &[([f64; 6], &[f64])]) -> Artifact {
    let parameter = |k: usize| rows.iter().map(|row| row.0[k]).collect();
    let other = |k: usize| rows.iter().map(|row| row.1[k]).collect();
    let own = NAMES.iter().enumerate().map(|(k, name)| ((*name).to_owned(), parameter(k)));
    let others = others.iter().enumerate().map(|(k, name)| ((*name).to_owned(), other(k)));
    Artifact::Table { name: name.into(), columns: own.chain(others).collect() }
}

/// All that was tried, the nearest first.
fn candidates(search: &Search) -> Artifact {
    let mut all: Vec<([f64; 6], [f64; 2])> = (search.candidates.iter())
        .map(|c| (c.parameters, [c.distance, c.generation as f64]))
        .collect();
    all.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    let rows: Vec<([f64; 6], &[f64])> = all.iter().map(|(p, rest)| (*p, &rest[..])).collect();
    table("candidates", &["distance (1/length)", "generation"], &rows)
}

/// Distance against generations, the starts being generation 0, with that of the nearest shape of
/// the atlas.
fn progress(nearest: &[([f64; 6], f64)], least: &[f64], found: Option<&Found>) -> Artifact {
    let points = |values: &mut dyn Iterator<Item = f64>| -> Vec<[f64; 2]> {
        let numbered = values.enumerate().map(|(n, value)| [n as f64, value]);
        numbered.filter(|point| point[1].is_finite()).collect()
    };
    let mut so_far = f64::NAN;
    let best = points(&mut least.iter().map(|value| {
        so_far = so_far.min(*value);
        so_far
    }));
    let each = points(&mut least.iter().copied());
    let ends = [0.0, (least.len() - 1).max(1) as f64];
    let level = |label: &str, y: f64| Series {
        label: label.into(),
        points: ends.map(|x| [x, y]).to_vec(),
        mark: Mark::Dashed,
    };
    let mut series = vec![
        Series { label: "best so far".into(), points: best, mark: Mark::Line },
        Series { label: "best of the generation".into(), points: each, mark: Mark::Dots },
    ];
    if let Some((_, distance)) = nearest.first() {
        series.push(level("nearest of the atlas", *distance));
    }
    if let Some(found) = found {
        series.push(level("between two noises", found.floor));
    }
    Artifact::Plot(Plot {
        name: "search".into(),
        title: "distance of the curvature diagrams".into(),
        x: Axis::linear("generation"),
        y: Axis::linear("Sinkhorn distance (1/length)"),
        series,
    })
}

/// The two diagrams in one picture.
fn diagrams(query: &Query, found: &PointCloud<2>) -> Artifact {
    let given = query.diagram.0.subsample(DOTS, 0).values;
    let step = found.len().div_ceil(DOTS).max(1);
    let other = (0..found.len()).step_by(step).map(|n| found.point(n));
    let inside = |k: &[f64; 2]| k.iter().all(|k| (view::RANGE[0]..=view::RANGE[1]).contains(k));
    let axis = |label: &str| Axis { label: label.into(), log: false, range: Some(view::RANGE) };
    let dots = |label: &str, points: Vec<[f64; 2]>| Series {
        label: label.into(),
        points: points.into_iter().filter(inside).collect(),
        mark: Mark::Dots,
    };
    Artifact::Plot(Plot {
        name: "diagrams".into(),
        title: "curvature diagrams".into(),
        x: axis("kappa 1 (1/length)"),
        y: axis("kappa 2 (1/length)"),
        series: vec![dots("found", other.collect()), dots("given", given)],
    })
}
