//! What an atlas looks like.

use super::config::{Config, NAMES};
use super::draws::{Draws, Member};
use super::run::Drawn;
use crate::curvature::{grow::MEASURES, view};
use crate::{Artifact, Map, MapPoint, Surface};
use solvers::{Field, Grid, isosurface::Caps};

/// The table of shapes; with a map, the map and all numbers too.
pub(super) fn artifacts(draws: &Draws, map: Option<&Drawn>, config: &Config) -> Vec<Artifact> {
    let members = &draws.members;
    let mut artifacts = vec![table(members, map)];
    let Some(map) = map else { return artifacts };
    let rows = members.iter().enumerate();
    let cells: Vec<[f64; 4]> =
        rows.flat_map(|(n, m)| m.cells().map(move |[x, y, w]| [n as f64, x, y, w])).collect();
    let shapes: Vec<[f64; 12]> = members.iter().map(numbers).collect();
    artifacts.extend(array("shapes", shapes.as_flattened(), 12));
    artifacts.extend(array("diagrams", cells.as_flattened(), 4));
    artifacts.extend(array(
        "distances",
        &map.distances.iter().copied().collect::<Vec<_>>(),
        members.len(),
    ));
    artifacts.push(picture(draws, map, config));
    artifacts
}

/// Parameters and measures.
fn numbers(member: &Member) -> [f64; 12] {
    std::array::from_fn(|n| if n < 6 { member.parameters[n] } else { member.measures[n - 6] })
}

fn array(name: &str, values: &[f64], columns: usize) -> Option<Artifact> {
    let grid = Grid::new(&[values.len() / columns, columns], 1.0).ok()?;
    let field = Field::from_vec(grid, values.to_vec()).ok()?;
    Some(Artifact::Array { name: name.into(), field })
}

fn table(members: &[Member], map: Option<&Drawn>) -> Artifact {
    let column = |name: &str, value: &dyn Fn(usize) -> f64| {
        (name.to_owned(), (0..members.len()).map(value).collect::<Vec<f64>>())
    };
    let mut columns =
        vec![column("shape", &|n| n as f64), column("draw", &|n| members[n].draw as f64)];
    for (k, name) in NAMES.iter().chain(&MEASURES).enumerate() {
        columns.push(column(name, &|n| numbers(&members[n])[k]));
    }
    if let Some(map) = map {
        columns.push(column("map_x", &|n| map.positions[n][0]));
        columns.push(column("map_y", &|n| map.positions[n][1]));
        let cluster = |n: usize| map.clusters.labels[n].map_or(-1.0, |label| label as f64);
        columns.push(column("cluster", &cluster));
    }
    Artifact::Table { name: "shapes".into(), columns }
}

fn picture(draws: &Draws, map: &Drawn, config: &Config) -> Artifact {
    let caption = |member: &Member| {
        let parameters = NAMES.iter().zip(member.parameters);
        let text: Vec<String> = parameters.map(|(name, v)| format!("{name} = {v:.4}")).collect();
        format!("draw {}: a20 = 1, {}", member.draw, text.join(", "))
    };
    let shown = spread(&map.positions, config.map.pictures);
    let points = draws.members.iter().enumerate().map(|(n, member)| MapPoint {
        position: map.positions[n],
        group: map.clusters.labels[n],
        caption: caption(member),
        surface: shown.contains(&n).then(|| thumbnail(draws, member)).flatten(),
    });
    Artifact::Map(Map {
        name: "atlas".into(),
        title: format!("{} curvature textures by their curvature diagrams", draws.members.len()),
        axes: ["map x (1)".into(), "map y (1)".into()],
        points: points.collect(),
    })
}

fn thumbnail(draws: &Draws, member: &Member) -> Option<Surface> {
    let phase = draws.phase(member).ok()?;
    let grid = phase.grid();
    let [nz, ny, nx] = grid.shape().map(|n| n as f64 * grid.spacing());
    let surface = view::surface(phase, 0.0, Caps::PeriodicClosed);
    Some(view::shape("shape", surface, [nx, ny, nz]))
}

/// `count` points far from each other: each next one is the farthest from all before it.
fn spread(positions: &[[f64; 2]], count: usize) -> Vec<usize> {
    let n = positions.len();
    let apart = |a: usize, b: usize| {
        libm::hypot(positions[a][0] - positions[b][0], positions[a][1] - positions[b][1])
    };
    let mut chosen: Vec<usize> = Vec::new();
    let mut nearest = vec![f64::INFINITY; n];
    // From the shape in the middle of all.
    let far = |a: &usize| (0..n).map(|b| apart(*a, b)).sum::<f64>();
    let mut next = (0..n).min_by(|a, b| far(a).total_cmp(&far(b)));
    while let Some(point) = next.filter(|_| chosen.len() < count.min(n)) {
        chosen.push(point);
        nearest.iter_mut().enumerate().for_each(|(k, d)| *d = d.min(apart(k, point)));
        next = (0..n).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a)));
    }
    chosen
}
