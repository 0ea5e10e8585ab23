//! Changes to parameters and concentrations at the start.

use super::config::{self, Change, Config, Region};
use super::setup::Chemistry;
use crate::{Error, Result};
use solvers::diffusion::explicit::Parameter;
use solvers::random::{stream, uniform};
use solvers::{Field, Grid};

/// Applies the perturbations, in order; noise has a random stream of its own per entry.
pub(super) fn perturb(
    config: &Config,
    chemistry: &Chemistry,
    seed: u64,
    grid: Grid,
    parameters: &mut [Parameter],
    initial: &mut [Field],
) -> Result<()> {
    for (index, change) in config.perturbation.iter().enumerate() {
        let target = change.target.as_str();
        let parameter = chemistry.parameters.iter().position(|(name, _)| name == target);
        let species = chemistry.species.iter().position(|name| name == target);
        let field = match (parameter, species) {
            (Some(p), _) => {
                if let Parameter::Uniform(value) = parameters[p] {
                    parameters[p] = Parameter::Map(Field::constant(grid, value));
                }
                match &mut parameters[p] {
                    Parameter::Map(field) => field,
                    Parameter::Uniform(_) => continue,
                }
            }
            (None, Some(s)) => &mut initial[s],
            (None, None) => {
                let names = [chemistry.parameter_names(), chemistry.species_names()].concat();
                let reason = format!("no `{target}` here; known: {}", names.join(", "));
                return Err(Error::config(&format!("perturbation.{index}.target"), reason));
            }
        };
        let nodes = region(change, seed, grid);
        let mut noise = stream(seed, "perturbation", index as u64);
        for (value, _) in field.as_mut_slice().iter_mut().zip(&nodes).filter(|(_, inside)| **inside)
        {
            match change.kind {
                Change::Noise => *value += change.amplitude * (2.0 * uniform(&mut noise) - 1.0),
                Change::Add => *value += change.amplitude,
                Change::Set => *value = change.amplitude,
            }
        }
    }
    Ok(())
}

/// Which nodes a perturbation touches. Squares stand at the same places for every
/// perturbation of the same width and count.
fn region(change: &config::Perturbation, seed: u64, grid: Grid) -> Vec<bool> {
    let shape = grid.shape();
    let middle = |m: usize, n: usize| {
        let first = n.saturating_sub(change.width) / 2;
        n == 1 || (first..first + change.width).contains(&m)
    };
    let at = |inside: &dyn Fn([usize; 3]) -> bool| {
        (0..grid.len()).map(|n| inside(grid.node(n))).collect()
    };
    match change.region {
        Region::All => vec![true; grid.len()],
        Region::Even => at(&|node| node.iter().all(|m| m.is_multiple_of(2))),
        Region::CenterLine => at(&|[_, _, i]| middle(i, shape[2])),
        Region::Block => at(&|node| (0..3).all(|axis| middle(node[axis], shape[axis]))),
        Region::Edge => at(&|[_, _, i]| i < change.width),
        Region::Squares => {
            let mut places = stream(seed, "squares", 0);
            let mut inside = vec![false; grid.len()];
            for _ in 0..change.count {
                let corner = shape.map(|n| (uniform(&mut places) * n as f64) as usize);
                for n in 0..change.width.pow(grid.dim() as u32) {
                    let w = change.width;
                    let offset = [n / w / w, n / w % w, n % w];
                    let node = [0, 1, 2].map(|axis| (corner[axis] + offset[axis]) % shape[axis]);
                    inside[grid.index(node[0], node[1], node[2])] = true;
                }
            }
            inside
        }
    }
}
