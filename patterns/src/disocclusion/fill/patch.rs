//! Copies of patches of the visible part, for patterns that no model makes.
//!
//! Criminisi, Perez & Toyama 2004 without the isophotes, which ink and paper have not: the
//! pixel at the edge of a hole whose patch is known best takes what is missing in it from the
//! visible patch that agrees best with what is known (Efros & Leung 1999). A sample takes any
//! of the patches that agree nearly as well.
//!
//! The crate for it, `texture-synthesis`, is archived since 2023, holds `image` to a version of
//! 2020, and repeats itself on one thread only.

use super::super::normalize::Normal;
use super::{Fill, Made, samples};
use crate::{Error, Result};
use rayon::prelude::*;
use solvers::random::{Stream, stream, uniform};
use solvers::texture::Descriptor;

/// Side of a patch in wavelengths, and the least and greatest half of it (pixels).
const SIDE: (f64, usize, usize) = (1.2, 3, 12);

/// Most patches that are looked at, evenly spread over the visible part.
const SOURCES: usize = 20_000;

/// Patches whose cost is below this multiple of the best's are as good to a sample.
const NEARLY: f64 = 1.1;

/// Agreement with the truth at the rim, and the depth (wavelengths) over which it falls.
const EXPECTED: (f64, f64) = (0.9, 0.6);

/// Fills the holes of `normal`.
pub(super) fn copy(normal: &Normal, settings: &Fill) -> Result<Made> {
    let [ny, nx] = normal.shape;
    let plain = 0.1 * ny.min(nx) as f64;
    let wavelength = Descriptor::new(&normal.masked()?).map_or(plain, |d| d.wavelength);
    let (side, least, greatest) = SIDE;
    let mut half = ((0.5 * side * wavelength).round() as usize).clamp(least, greatest);
    let mut sources = sources(normal, half);
    while sources.is_empty() && half > 1 {
        half -= 1;
        sources = self::sources(normal, half);
    }
    if sources.is_empty() {
        let reason = "hides so much that no patch of 3 x 3 pixels is left to copy";
        return Err(Error::config("mask", reason));
    }
    let stride = sources.len().div_ceil(SOURCES);
    let sources: Vec<usize> = sources.into_iter().step_by(stride).collect();
    let count = samples(normal, wavelength, settings)? as u64;
    let levels = (0..count)
        .into_par_iter()
        .map(|index| {
            let mut random = stream(settings.seed, "patches", index);
            let ink = synthesize(normal, half, &sources, &mut random);
            ink.into_iter().map(|ink| if ink { -1.0 } else { 1.0 }).collect()
        })
        .collect();
    let (at_rim, depth) = EXPECTED;
    Ok(Made { levels, at_rim, range: depth * wavelength, method: "patch" })
}

/// Middles of the patches of `2 half + 1` pixels that are visible as a whole.
fn sources(normal: &Normal, half: usize) -> Vec<usize> {
    let [ny, nx] = normal.shape;
    if ny.min(nx) <= 2 * half {
        return Vec::new();
    }
    // Hidden pixels above and left of each corner.
    let mut sums = vec![0_usize; (ny + 1) * (nx + 1)];
    for n in 0..ny * nx {
        let (j, i) = (n / nx, n % nx);
        let at = |j: usize, i: usize| sums[j * (nx + 1) + i];
        let own = usize::from(!normal.visible[n]);
        let total = at(j, i + 1) + at(j + 1, i) + own - at(j, i);
        sums[(j + 1) * (nx + 1) + i + 1] = total;
    }
    let whole = |j: usize, i: usize| {
        let at = |j: usize, i: usize| sums[j * (nx + 1) + i];
        let (top, left) = (j - half, i - half);
        let (bottom, right) = (j + half + 1, i + half + 1);
        at(bottom, right) + at(top, left) == at(top, right) + at(bottom, left)
    };
    let rows = half..ny - half;
    rows.flat_map(|j| (half..nx - half).map(move |i| (j, i)))
        .filter(|&(j, i)| whole(j, i))
        .map(|(j, i)| j * nx + i)
        .collect()
}

/// A pixel of a patch: its distance from the middle in the picture's order, its colour, and
/// its weight.
struct Known {
    offset: isize,
    ink: bool,
    weight: f32,
}

fn synthesize(normal: &Normal, half: usize, sources: &[usize], random: &mut Stream) -> Vec<bool> {
    let [ny, nx] = normal.shape;
    let mut ink = normal.ink.clone();
    let mut known = normal.visible.clone();
    let mut trust: Vec<f32> = known.iter().map(|&known| f32::from(u8::from(known))).collect();
    let around = |n: usize, far: usize| {
        let (j, i) = (n / nx, n % nx);
        let rows = j.saturating_sub(far)..(j + far + 1).min(ny);
        rows.flat_map(move |v| {
            (i.saturating_sub(far)..(i + far + 1).min(nx)).map(move |u| v * nx + u)
        })
    };
    let inside = |n: usize| around(n, half);
    let area = ((2 * half + 1) * (2 * half + 1)) as f32;
    let confidence = |trust: &[f32], n: usize| inside(n).map(|m| trust[m]).sum::<f32>() / area;
    let mut priority = vec![f32::NEG_INFINITY; ny * nx];
    for n in (0..ny * nx).filter(|&n| !known[n]) {
        priority[n] = confidence(&trust, n);
    }
    loop {
        // The first of the best: an order that does not depend on threads.
        let open = (0..ny * nx).filter(|&n| !known[n]);
        let Some(n) = open.reduce(|a, b| if priority[b] > priority[a] { b } else { a }) else {
            return ink;
        };
        let (j, i) = ((n / nx) as isize, (n % nx) as isize);
        let spread = 0.5 * half as f32;
        let mut patch: Vec<Known> = inside(n)
            .filter(|&m| known[m])
            .map(|m| {
                let (dy, dx) = ((m / nx) as isize - j, (m % nx) as isize - i);
                let far = (dy * dy + dx * dx) as f32 / (2.0 * spread * spread);
                let weight = trust[m] * libm::expf(-0.5 * far);
                Known { offset: dy * nx as isize + dx, ink: ink[m], weight }
            })
            .collect();
        // What counts most first, so that bad patches are left early.
        patch.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let source = best(normal, sources, &patch, random);
        // Only the middle of the patch is taken: its edge would be seen.
        let taken = half.div_ceil(2) as isize;
        let value = priority[n];
        let new: Vec<usize> = inside(n)
            .filter(|&m| {
                let (dy, dx) = ((m / nx) as isize - j, (m % nx) as isize - i);
                !known[m] && dy.abs() <= taken && dx.abs() <= taken
            })
            .collect();
        for &m in &new {
            let from = source as isize + m as isize - n as isize;
            ink[m] = normal.ink[from as usize];
        }
        for &m in &new {
            (known[m], trust[m]) = (true, value);
        }
        for near in around(n, half + taken as usize).filter(|&near| !known[near]) {
            priority[near] = confidence(&trust, near);
        }
    }
}

/// Middle of the visible patch of least cost, or any that is nearly as good.
fn best(normal: &Normal, sources: &[usize], patch: &[Known], random: &mut Stream) -> usize {
    let mut least = f32::INFINITY;
    let mut costs: Vec<(f32, usize)> = Vec::with_capacity(64);
    for &source in sources {
        let limit = least * NEARLY as f32;
        let mut cost = 0.0;
        for known in patch {
            let same = normal.ink[(source as isize + known.offset) as usize] == known.ink;
            cost += if same { 0.0 } else { known.weight };
            if cost > limit {
                break;
            }
        }
        if cost <= limit {
            least = least.min(cost);
            costs.push((cost, source));
        }
    }
    let limit = least * NEARLY as f32;
    costs.retain(|(cost, _)| *cost <= limit);
    costs[((uniform(random) * costs.len() as f64) as usize).min(costs.len() - 1)].1
}
