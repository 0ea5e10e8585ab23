//! Structures that can move without strain, found before anything is solved.

use super::build::Problem;
use crate::{Artifact, Error, Result, Stroke};
use solvers::Field;
use solvers::fem::{RigidMode, System, free_modes};

/// Work of a load on a free motion below this fraction of (force x largest motion) is rounding.
const NO_WORK: f64 = 1e-9;

/// Refuses a mechanism that a load drives; otherwise pins what nothing drives, so that
/// the matrix can be factorized, and says so. The compliance does not depend on where.
pub(super) fn hold(problem: &mut Problem) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let modes = free_modes(&problem.system);
    let mut loads: Vec<&[f64]> = problem.cases.iter().map(|(_, force)| force.as_slice()).collect();
    let weight = weight(problem);
    loads.extend(weight.as_deref());
    loads.extend(problem.output.as_deref());
    for force in loads {
        if let Some(mode) = driven(&problem.system, &modes, force) {
            return Err(Error::Mechanism {
                key: "problem.support".into(),
                reason: refusal(problem, &mode),
                picture: Box::new(picture(problem, &mode)),
            });
        }
    }
    // Each pin removes one mode.
    for _ in 0..modes.len() {
        let free = free_modes(&problem.system);
        let Some(mode) = free.first() else { break };
        notes.push(format!(
            "the part is free to {}; no load does work on that, so it was held there",
            describe(&problem.system, mode)
        ));
        let unknown = most_moved(&problem.system, mode);
        problem.system = problem.system.clone().with_fixed(unknown);
    }
    Ok(notes)
}

/// Nodal forces of a solid body, if it has weight.
fn weight(problem: &Problem) -> Option<Vec<f64>> {
    problem.body_force.map(|_| {
        let mut force = vec![0.0; problem.system.unknowns()];
        super::analysis::add_body_force(problem, |_| 1.0, &mut force);
        force
    })
}

/// The combination of free motions on which `force` works, if there is one.
fn driven(system: &System, modes: &[RigidMode], force: &[f64]) -> Option<RigidMode> {
    let total: f64 = force.iter().map(|f| f.abs()).sum();
    let works: Vec<f64> = modes.iter().map(|mode| mode.work(system, force)).collect();
    if works.iter().all(|work| work.abs() <= NO_WORK * total) {
        return None;
    }
    let mut mode = RigidMode { translation: [0.0; 3], rotation: [0.0; 3], ..modes[0] };
    for (part, work) in modes.iter().zip(&works) {
        for axis in 0..3 {
            mode.translation[axis] += work * part.translation[axis];
            mode.rotation[axis] += work * part.rotation[axis];
        }
    }
    Some(mode)
}

/// What the free motion is and what would stop it.
fn refusal(problem: &Problem, mode: &RigidMode) -> String {
    let system = &problem.system;
    let components = system.element().components();
    if components == 1 {
        return "no temperature is held: heat that flows in cannot flow out; add a sink".into();
    }
    // Best of the nodes that have a support already, or else of all.
    let supported = |unknown: usize| {
        let first = unknown / components * components;
        system.fixed()[first..first + components].contains(&true)
    };
    let moved = |unknown: &usize| mode.at(system, *unknown).abs();
    let free = || (0..system.unknowns()).filter(|&u| !system.fixed()[u]);
    let greatest = free().map(|u| moved(&u)).fold(0.0, f64::max);
    let best = free()
        .filter(|&u| supported(u))
        .max_by(|a, b| moved(a).total_cmp(&moved(b)))
        .filter(|u| moved(u) > 0.1 * greatest)
        .unwrap_or_else(|| most_moved(system, mode));
    format!(
        "the part is a mechanism: it can {}; support {} at one more node, e.g. {}",
        describe(system, mode),
        ["x", "y", "z"][best % components],
        name_node(system, best / components),
    )
}

/// The box, the same a little moved, supports and loads.
fn picture(problem: &Problem, mode: &RigidMode) -> Artifact {
    let [_, ny, nx] = problem.grid.shape().map(|n| n as f64);
    let corners = [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]];
    let move_of = |[x, y]: [f64; 2]| mode.displacement([x, y, mode.center[2]]);
    let size = |[x, y, _]: [f64; 3]| x.hypot(y);
    let greatest = corners.map(|c| size(move_of(c))).into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let scale = 0.15 * nx.max(ny) / greatest;
    let moved = corners.map(|c| {
        let [dx, dy, _] = move_of(c);
        [c[0] + scale * dx, c[1] + scale * dy]
    });
    let mut strokes = super::marks::strokes(problem);
    for n in 0..4 {
        strokes.push(Stroke { ends: [moved[n], moved[(n + 1) % 4]], color: [200, 30, 30] });
    }
    let mut image = super::view::ink(Field::constant(problem.grid, 0.1));
    image.name = "mechanism".into();
    Artifact::Drawing { image, strokes }
}

/// "rotate about node (61, 21)", "move along x".
fn describe(system: &System, mode: &RigidMode) -> String {
    if system.element().components() == 1 {
        return "change its temperature as a whole".into();
    }
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let radius = mode.center.into_iter().fold(1.0, f64::max);
    let (shift, turn) = (size(mode.translation), size(mode.rotation) * radius);
    if turn < 1e-6 * shift {
        return match along(mode.translation, shift) {
            Some(axis) => format!("move along {axis}"),
            None => {
                let [x, y, z] = mode.translation.map(|v| v / shift);
                format!("move along ({x:.2}, {y:.2}, {z:.2})")
            }
        };
    }
    if let Some([x, y]) = mode.pivot().filter(|_| system.lattice().dim() == 2) {
        let (column, row) = (x + 1.0, y + 1.0);
        let on_node = (column - column.round()).abs() + (row - row.round()).abs() < 1e-6;
        return if on_node {
            format!("rotate about node ({}, {})", column.round(), row.round())
        } else {
            format!("rotate about the point at column {column:.2}, row {row:.2}")
        };
    }
    match along(mode.rotation, size(mode.rotation)) {
        Some(axis) => format!("rotate about an axis along {axis}"),
        None => "rotate".into(),
    }
}

/// The axis that a vector of that length lies along.
fn along(vector: [f64; 3], length: f64) -> Option<&'static str> {
    (0..3)
        .find(|&axis| vector[axis].abs() > (1.0 - 1e-9) * length)
        .map(|axis| ["x", "y", "z"][axis])
}

/// The free unknown that moves most.
fn most_moved(system: &System, mode: &RigidMode) -> usize {
    let moved = |unknown: usize| mode.at(system, unknown).abs();
    let free = (0..system.unknowns()).filter(|&u| !system.fixed()[u]);
    free.max_by(|&a, &b| moved(a).total_cmp(&moved(b)).then(b.cmp(&a))).unwrap_or(0)
}

/// A node by its numbers from 1.
fn name_node(system: &System, node: usize) -> String {
    let at = system.lattice().position(node).map(|n| n + 1);
    let numbers: Vec<String> = at[..system.lattice().dim()].iter().map(usize::to_string).collect();
    format!("({})", numbers.join(", "))
}
