//! What a texture looks like.

use super::Diagram;
use crate::{Artifact, Axis, Colors, Image, Mark, Plot, Series, Surface};
use solvers::{
    Field, Grid,
    isosurface::{self, Caps},
};

/// Curvatures beyond these are left out of the picture, as in the paper (1/length).
pub(super) const RANGE: [f64; 2] = [-100.0, 100.0];

/// Triangles in the picture of a diagram.
const DOTS: usize = 6000;

/// Triangles in its table: the surface of a box of 256^3 voxels has ten times as many.
const ROWS: usize = 2_000_000;

/// The first part of the history, which would hide the rest, is cut off above.
const SETTLED: usize = 20;

/// Surface `u = level`, outward from `u > level` (lengths), with its caps marked.
pub(super) fn surface(phase: Field, level: f64, caps: Caps) -> isosurface::Surface {
    let mut phi = phase;
    phi.as_mut_slice().iter_mut().for_each(|u| *u = level - *u);
    // Boxes of three axes always have a surface, if only an empty one.
    isosurface::surface(&phi, 0.0, caps).unwrap_or_default()
}

/// The shape in its box: beige, dark where the box cuts it.
pub(super) fn shape(name: &str, surface: isosurface::Surface, size: [f64; 3]) -> Surface {
    Surface {
        name: name.into(),
        mesh: surface.mesh,
        caps: surface.caps,
        frame: Some([[0.0; 3], size]),
        ..Surface::default()
    }
}

/// The phase: a slice, and all numbers.
pub(super) fn phase(phase: Field) -> Artifact {
    Artifact::Image(Image {
        name: "phase".into(),
        field: phase,
        label: "phase u (1)".into(),
        colors: Colors::Diverging,
        range: Some([-1.0, 1.0]),
        contour: None,
        rows: None,
    })
}

/// The middle plane along z, the inside in ink.
pub(super) fn slice(phase: &Field, level: f64) -> Image {
    let [nz, ny, nx] = phase.grid().shape();
    let plane = ny * nx;
    let values = phase.as_slice()[nz / 2 * plane..][..plane].iter().map(|u| level - u).collect();
    let field = Grid::new(&[ny, nx], phase.grid().spacing())
        .and_then(|grid| Field::from_vec(grid, values))
        .unwrap_or_else(|_| phase.clone());
    Image {
        name: "slice".into(),
        contour: Some(field.clone()),
        field,
        label: "inside".into(),
        colors: Colors::Ink,
        range: Some([-1.0, 1.0]),
        rows: None,
    }
}

/// Energy against evaluations, scaled by what follows the first of them (figure 3).
pub(super) fn history(history: &[[f64; 2]]) -> Artifact {
    let energies = history.iter().map(|pair| pair[0]);
    let late = energies.clone().skip(history.len() / SETTLED);
    let (low, high) = late.fold((f64::MAX, f64::MIN), |(low, high), e| (low.min(e), high.max(e)));
    let margin = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    let inside = |e: f64| (low - margin..=high + margin).contains(&e);
    let points = energies.enumerate().filter(|(_, e)| inside(*e)).map(|(n, e)| [n as f64, e]);
    Artifact::Plot(Plot {
        name: "energy".into(),
        title: "energy against evaluations".into(),
        x: Axis::linear("evaluation"),
        y: Axis::linear("energy F (1)"),
        series: vec![Series { label: "energy".into(), points: points.collect(), mark: Mark::Line }],
    })
}

/// The curvature diagram as a picture, and its triangles as a table: at most [`ROWS`] of them,
/// drawn by chance, their areas scaled so that the sum stays the surface's.
pub(super) fn diagram(diagram: Diagram) -> Vec<Artifact> {
    let shown = diagram.0.subsample(DOTS, 0);
    let area = diagram.area();
    let table = if diagram.0.values.len() > ROWS {
        let mut part = diagram.0.subsample(ROWS, 0);
        part.weights.iter_mut().for_each(|share| *share *= area);
        part
    } else {
        diagram.0
    };
    let column = |c: usize| table.values.iter().map(|k| k[c]).collect();
    let inside = |k: &&[f64; 2]| k.iter().all(|k| (RANGE[0]..=RANGE[1]).contains(k));
    let axis = |label: &str| Axis { label: label.into(), log: false, range: Some(RANGE) };
    vec![
        Artifact::Plot(Plot {
            name: "diagram".into(),
            title: "curvature diagram".into(),
            x: axis("kappa 1 (1/length)"),
            y: axis("kappa 2 (1/length)"),
            series: vec![
                Series {
                    label: "surface, by area".into(),
                    points: shown.values.iter().filter(inside).copied().collect(),
                    mark: Mark::Dots,
                },
                Series {
                    label: "kappa 1 = kappa 2".into(),
                    points: vec![[RANGE[0]; 2], [RANGE[1]; 2]],
                    mark: Mark::Line,
                },
            ],
        }),
        Artifact::Table {
            name: "curvatures".into(),
            columns: vec![
                ("kappa_1 (1/length)".into(), column(0)),
                ("kappa_2 (1/length)".into(), column(1)),
                ("area (length^2)".into(), table.weights.clone()),
            ],
        },
    ]
}
