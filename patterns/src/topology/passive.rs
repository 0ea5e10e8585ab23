//! Regions of fixed material.

use super::problem::{Material, Passive};
use crate::{Context, Error, Result};
use solvers::Grid;

/// Fixed material of each element; later regions win.
pub(super) fn find(
    regions: &[Passive],
    grid: Grid,
    context: &Context<'_>,
) -> Result<Vec<Option<Material>>> {
    let mut passive = vec![None; grid.len()];
    for (n, region) in regions.iter().enumerate() {
        let key = format!("problem.passive.{n}");
        let inside = members(region, &key, grid, context)?;
        if !inside.contains(&true) {
            let reason = "no element's middle lies in it: it is outside the domain or too small";
            return Err(Error::config(&key, reason));
        }
        let marked = passive.iter_mut().zip(inside).filter(|(_, inside)| *inside);
        marked.for_each(|(material, _)| *material = Some(region.material));
    }
    if !passive.contains(&None) {
        return Err(Error::config("problem.passive", "nothing is left to design"));
    }
    Ok(passive)
}

/// Mirrors the fixed material across the axes x, y, z of `mirror`, as the design is.
pub(super) fn mirror(
    passive: &mut [Option<Material>],
    grid: Grid,
    mirror: [bool; 3],
) -> Result<()> {
    let [nz, ny, nx] = grid.shape();
    for axis in (0..3).filter(|&axis| mirror[axis]) {
        for e in 0..passive.len() {
            let mut at = [e % nx, e / nx % ny, e / (nx * ny)];
            at[axis] = [nx, ny, nz][axis] - 1 - at[axis];
            let other = grid.index(at[2], at[1], at[0]);
            match (passive[e], passive[other]) {
                (Some(own), Some(image)) if own != image => {
                    let name = ["x", "y", "z"][axis];
                    let reason =
                        format!("solid and void are mirror images of each other across {name}");
                    return Err(Error::config("problem.passive", reason));
                }
                (None, image) => passive[e] = image,
                _ => {}
            }
        }
    }
    if !passive.contains(&None) {
        return Err(Error::config("problem.passive", "nothing is left to design"));
    }
    Ok(())
}

fn members(region: &Passive, key: &str, grid: Grid, context: &Context<'_>) -> Result<Vec<bool>> {
    let dim = grid.dim();
    let by_middle = |test: &dyn Fn([f64; 3]) -> bool| {
        (0..grid.len()).map(|e| test(grid.position(e).map(|x| x + 0.5))).collect()
    };
    let bad = |name: &str, reason: String| Err(Error::config(&format!("{key}.{name}"), reason));
    match (&region.area, &region.circle, &region.polygon, &region.image) {
        (Some([a, b]), None, None, None) => {
            if a.len() != dim || b.len() != dim {
                return bad("box", format!("its corners should have {dim} numbers"));
            }
            Ok(by_middle(&|x| (0..dim).all(|n| x[n] > a[n].min(b[n]) && x[n] < a[n].max(b[n]))))
        }
        (None, Some(numbers), None, None) => match numbers.split_last() {
            Some((&radius, center)) if center.len() == dim && radius > 0.0 => Ok(by_middle(&|x| {
                let square = center.iter().zip(x).map(|(c, x)| (x - c) * (x - c));
                square.sum::<f64>() < radius * radius
            })),
            _ => bad(
                "circle",
                format!("{numbers:?} should be {dim} coordinates and a radius above 0"),
            ),
        },
        (None, None, Some(corners), None) => {
            if corners.len() < 3 {
                return bad("polygon", format!("{} corners, at least 3 are needed", corners.len()));
            }
            Ok(by_middle(&|[x, y, _]| contains(corners, x, y)))
        }
        (None, None, None, Some(path)) => {
            let image = context.inputs.field(&format!("{key}.image"), path)?;
            image
                .check_shape(path, grid)
                .map_err(|error| Error::config(&format!("{key}.image"), error.to_string()))?;
            Ok(image.as_slice().iter().map(|&grey| grey < 0.5).collect())
        }
        _ => Err(Error::config(key, "give exactly one of `box`, `circle`, `polygon` and `image`")),
    }
}

/// Even-odd rule.
fn contains(corners: &[[f64; 2]], x: f64, y: f64) -> bool {
    let previous = corners.iter().cycle().skip(corners.len() - 1);
    let crossed = corners.iter().zip(previous).filter(|(a, b)| {
        (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]
    });
    crossed.count() % 2 == 1
}
