//! Where a design carries: energy density, von Mises stress, principal stresses.

use super::{analysis::Analysis, build::Problem, problem::Physics, stress::von_mises, view};
use crate::{Artifact, Colors, Image, Stroke};
use solvers::Field;

/// Density from which an element counts as solid.
const SOLID: f64 = 0.5;

/// Part of the solid elements whose values lie within the colour scale: the few beside point
/// loads and corners, where values grow without end, would darken the rest.
const WITHIN: f64 = 0.98;

/// Most crosses along the longer side.
const CROSSES: usize = 32;

/// Bars below this part of the longest are left out: dots would hide the rest.
const LEAST: f64 = 0.08;

/// Load cases that have a picture of their own.
const MOST_CASES: usize = 8;

const TENSION: [u8; 3] = [200, 30, 30];
const COMPRESSION: [u8; 3] = [20, 70, 200];

/// Ink of solid under the crosses, which must stand out.
const PALE: f64 = 0.18;

/// The maps of displacements that `analysis` found for `density`.
pub(super) fn artifacts(
    problem: &Problem,
    physics: Physics,
    analysis: &Analysis,
    density: &Field,
) -> Vec<Artifact> {
    let mut artifacts = vec![energy(problem, physics, analysis, density)];
    if physics == Physics::Heat {
        return artifacts;
    }
    let cases: Vec<Vec<[f64; 6]>> =
        analysis.u.iter().map(|u| stresses(problem, &analysis.stiffness, u)).collect();
    artifacts.push(mises(&cases, density));
    if problem.grid.dim() == 2 {
        for (case, stresses) in cases.iter().enumerate().take(MOST_CASES) {
            let name = match cases.len() {
                1 => "stresses".to_owned(),
                _ => format!("stresses-{}", case + 1),
            };
            artifacts.push(crosses(name, stresses, density));
        }
    }
    artifacts
}

/// Strain energy per volume `E e:e / 2`, or heat `k |grad T|^2`, summed over the cases by weight.
fn energy(problem: &Problem, physics: Physics, analysis: &Analysis, density: &Field) -> Artifact {
    let volume = problem.unit.powi(problem.grid.dim() as i32);
    let (factor, label) = match physics {
        Physics::Elasticity => (0.5 / volume, "energy density (force / length^2)"),
        Physics::Heat => (1.0 / volume, "k |grad T|^2 (heat x temperature / length^d)"),
    };
    let mut sum = vec![0.0; density.as_slice().len()];
    let mut part = sum.clone();
    for ((weight, _), u) in problem.cases.iter().zip(&analysis.u) {
        problem.system.energies(u, u, &mut part);
        let parts = part.iter().zip(&analysis.stiffness);
        sum.iter_mut().zip(parts).for_each(|(s, (w, e))| *s += weight * factor * w * e);
    }
    map("energy", label, sum, density)
}

/// The greatest von Mises stress of the cases.
fn mises(cases: &[Vec<[f64; 6]>], density: &Field) -> Artifact {
    let dim = density.grid().dim();
    let mut greatest = vec![0.0_f64; density.as_slice().len()];
    for stresses in cases {
        let pairs = greatest.iter_mut().zip(stresses);
        pairs.for_each(|(g, s)| *g = g.max(von_mises(dim, s).0));
    }
    map("mises", "von Mises stress (force / length^2)", greatest, density)
}

/// Stresses at the elements' middles (force/length^2), with the stiffness that each has.
fn stresses(problem: &Problem, stiffness: &[f64], u: &[f64]) -> Vec<[f64; 6]> {
    let element = problem.system.element();
    let n = element.unknowns();
    // Strains are displacements per edge; the matrix of a cube has the edge in it once more.
    let scale = problem.unit.powi(1 - element.dim() as i32);
    let mut local = [0.0; 24];
    let at = |(e, stiffness): (usize, &f64)| {
        problem.system.gather(e, u, &mut local[..n]);
        element.stress(&local[..n]).map(|s| s * stiffness * scale)
    };
    stiffness.iter().enumerate().map(at).collect()
}

fn map(name: &str, label: &str, values: Vec<f64>, density: &Field) -> Artifact {
    let most = most(values.iter().copied(), density);
    let mut field = density.clone();
    field.as_mut_slice().copy_from_slice(&values);
    Artifact::Image(Image {
        name: name.into(),
        field,
        label: label.into(),
        colors: Colors::Sequential,
        range: (most > 0.0).then_some([0.0, most]),
        contour: (density.grid().dim() == 2).then(|| view::phi(density)),
        rows: None,
    })
}

/// The value below which the given part of the solid elements lies; 0 if nothing is solid.
fn most(values: impl Iterator<Item = f64>, density: &Field) -> f64 {
    let solid = values.zip(density.as_slice()).filter(|(_, rho)| **rho > SOLID);
    let mut values: Vec<f64> = solid.map(|(value, _)| value).collect();
    values.sort_by(f64::total_cmp);
    let last = (WITHIN * values.len() as f64) as usize;
    values.get(last.min(values.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

/// Principal stresses `s1 >= s2` and the direction of the first.
fn principal(stress: &[f64; 6]) -> ([f64; 2], [f64; 2]) {
    let [xx, yy, xy, ..] = *stress;
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = libm::hypot(half, xy);
    let angle = 0.5 * libm::atan2(xy, half);
    ([mean + radius, mean - radius], [libm::cos(angle), libm::sin(angle)])
}

/// Crosses along the principal directions in solid, as long as the stresses are large.
fn crosses(name: String, stresses: &[[f64; 6]], density: &Field) -> Artifact {
    let [_, ny, nx] = density.grid().shape();
    let step = nx.max(ny).div_ceil(CROSSES);
    // The middles of blocks of `step` elements, in the middle of the box.
    let places = |n: usize| ((n % step / 2 + step / 2)..n).step_by(step);
    let size = |s: &[f64; 6]| {
        let ([a, b], _) = principal(s);
        a.abs().max(b.abs())
    };
    let most = most(stresses.iter().map(size), density);
    let mut strokes = Vec::new();
    for j in places(ny) {
        for i in places(nx) {
            let e = j * nx + i;
            if density.as_slice()[e] <= SOLID || most <= 0.0 {
                continue;
            }
            let middle = [i as f64 + 0.5, j as f64 + 0.5];
            let (values, [c, s]) = principal(&stresses[e]);
            // The shorter on top of the longer.
            let mut bars = [(values[0], [c, s]), (values[1], [-s, c])];
            bars.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
            for (value, along) in bars.into_iter().filter(|(v, _)| v.abs() > LEAST * most) {
                let half = 0.48 * step as f64 * (value.abs() / most).min(1.0);
                let end = |sign: f64| [0, 1].map(|n: usize| middle[n] + sign * half * along[n]);
                let color = if value > 0.0 { TENSION } else { COMPRESSION };
                strokes.push(Stroke { ends: [end(-1.0), end(1.0)], color });
            }
        }
    }
    let mut pale = density.clone();
    pale.as_mut_slice().iter_mut().for_each(|rho| *rho *= PALE);
    let mut image = view::ink(pale);
    image.name = name;
    Artifact::Drawing { image, strokes }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniaxial tension at an angle, and pure shear: their principal stresses are known.
    #[test]
    fn principal_stresses_of_known_states() {
        let (c, s) = (0.8, 0.6);
        let ([first, second], along) =
            principal(&[5.0 * c * c, 5.0 * s * s, 5.0 * c * s, 0.0, 0.0, 0.0]);
        assert!((first - 5.0).abs() < 1e-12 && second.abs() < 1e-12, "{first} {second}");
        assert!((along[0] - c).abs() < 1e-12 && (along[1] - s).abs() < 1e-12, "{along:?}");
        let (values, along) = principal(&[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
        assert!((values[0] - 2.0).abs() < 1e-12 && (values[1] + 2.0).abs() < 1e-12);
        assert!((along[0] - along[1]).abs() < 1e-12, "{along:?}");
    }
}
