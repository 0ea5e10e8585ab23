//! A reaction that continues what is visible.
//!
//! Its concentration starts as the kriging mean (or a sample) of the visible texture; the
//! model runs with visible cells held, at their concentration where grey levels tell it, else
//! on their side of the ink's border, until no hidden pixel changes its colour.

use super::super::class::Class;
use super::super::normalize::Normal;
use super::frame::Frame;
use super::reference::Reference;
use super::{Fill, Made, samples};
use crate::reaction_diffusion::held::Held;
use crate::{Inputs, Result};
use rayon::prelude::*;
use solvers::level_set::label_components;
use solvers::texture::{Descriptor, Kriging};
use solvers::{Boundary, Grid};

/// Seed of the run that tells scale and concentrations.
const SEED: u64 = 0;

/// Distance (standard deviations) from the border at which visible pixels are held on their
/// side. Without it 1.5 % of the visible pixels end on the wrong side.
const MARGIN: f64 = 0.25;

/// Reach of the texture's covariance (wavelengths): beyond, correlations of all classes are
/// below their errors.
const REACH: f64 = 4.0;

/// Visible rim (wavelengths) that is looked at around the holes.
const RIM: f64 = 5.0;

/// Steps between two looks at the hidden pixels, looks without change that end a run, and
/// share of hidden pixels whose change still counts as rest.
const LOOK: (u64, u64, f64) = (50, 6, 2e-4);

/// Least steps; most are half of those of the class, which starts from nothing.
const LEAST: u64 = 400;

/// Agreement with the truth at the rim, and the depth (wavelengths) over which it falls.
/// On spots and labyrinths, from the figures of `benches/peers/disocclusion`.
const EXPECTED: (f64, f64) = (0.97, 1.3);

/// Relative difference of the numbers of parts that is left alone, and steps towards a random
/// start: at 0.4 labyrinths have the truth's number of parts on average.
const ALIKE: f64 = 0.1;
const SHARES: [f64; 3] = [0.25, 0.4, 0.55];

/// Fills the holes of `normal`.
pub(super) fn run(
    normal: &Normal,
    class: &Class,
    point: &[f64],
    settings: &Fill,
    inputs: &(dyn Inputs + Sync),
) -> Result<Made> {
    let reference = Reference::new(class, point, SEED, inputs)?;
    let own = Descriptor::new(&normal.masked()?).map(|d| d.wavelength);
    // A pattern without a wavelength is taken as it is.
    let (wavelength, scale) = match (own, reference.wavelength) {
        (Some(own), Some(model)) => (own, model / own),
        (None, Some(model)) => (model, 1.0),
        _ => (0.1 * normal.shape[0].min(normal.shape[1]) as f64, 1.0),
    };
    let frame = Frame::new(normal, RIM * wavelength, scale);
    let mut small = frame.normal(normal);
    if settings.inverted {
        small.ink.iter_mut().zip(&small.visible).for_each(|(ink, seen)| *ink ^= seen);
    }
    let (values, bounds) = held(&reference, &small, &frame, settings);
    let reach = (REACH * wavelength * scale).ceil() as usize;
    let count = samples(normal, wavelength, settings)?;
    let reaction = Reaction { reference: &reference, small: &small, bounds: &bounds, inputs };
    let found = match Kriging::new(frame.shape, &values, &small.visible, reach)? {
        Some(mut kriging) => continuations(&reaction, &mut kriging, settings.seed, count)?,
        None => vec![reaction.settle(&values)?],
    };
    let side = if reference.below == settings.inverted { -1.0 } else { 1.0 };
    let level = |c: Vec<f64>| -> Vec<f64> {
        frame.outward(&c.into_iter().map(|c| side * (c - reference.level)).collect::<Vec<_>>())
    };
    let (at_rim, depth) = EXPECTED;
    Ok(Made {
        levels: found.into_iter().map(level).collect(),
        at_rim,
        range: depth * wavelength,
        method: "reaction-diffusion",
    })
}

/// The concentrations that the reaction makes of the likeliest start, and of `count - 1`
/// random ones.
///
/// Where the rim determines nothing the likeliest start is flat and the pattern grows into it
/// more orderly than of itself: lines too long, a fifth too few. If so, it is moved towards a
/// random start as little as gives the number of parts that the random ones have.
fn continuations(
    reaction: &Reaction<'_>,
    kriging: &mut Kriging,
    seed: u64,
    count: usize,
) -> Result<Vec<Vec<f64>>> {
    let mean = kriging.mean();
    let mut starts = vec![mean.clone()];
    starts.extend((1..count as u64).map(|n| kriging.sample(seed, n)));
    let mut found =
        starts.par_iter().map(|start| reaction.settle(start)).collect::<Result<Vec<_>>>()?;
    if count == 1 {
        return Ok(found);
    }
    let parts = found.iter().map(|c| reaction.parts(c)).collect::<Result<Vec<_>>>()?;
    let wanted = parts[1..].iter().sum::<f64>() / (count - 1) as f64;
    let mut off = (parts[0] - wanted).abs() / wanted;
    let random = kriging.sample(seed, 0);
    for share in SHARES {
        if off <= ALIKE {
            break;
        }
        let start: Vec<f64> = mean.iter().zip(&random).map(|(m, r)| m + share * (r - m)).collect();
        let c = reaction.settle(&start)?;
        let now = (reaction.parts(&c)? - wanted).abs() / wanted;
        if now < off {
            (found[0], off) = (c, now);
        }
    }
    Ok(found)
}

/// Concentrations of visible cells, and the bounds within which all cells are held.
fn held(
    reference: &Reference,
    small: &Normal,
    frame: &Frame,
    settings: &Fill,
) -> (Vec<f64>, Vec<[f64; 2]>) {
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    if let Some(grey) = &settings.grey {
        let values = ranked(reference, small, &frame.grey(grey), settings.inverted);
        let bounds = values.iter().zip(&small.visible);
        let bounds = bounds.map(|(&c, &seen)| if seen { [c, c] } else { free }).collect();
        return (values, bounds);
    }
    let [paper, ink] = reference.means;
    let values = small.ink.iter().map(|&dark| if dark { ink } else { paper }).collect();
    let margin = MARGIN * reference.deviation;
    let low = [f64::NEG_INFINITY, reference.level - margin];
    let high = [reference.level + margin, f64::INFINITY];
    let bounds = small.ink.iter().zip(&small.visible).map(|(&dark, &seen)| match seen {
        false => free,
        true if dark == reference.below => low,
        true => high,
    });
    (values, bounds.collect())
}

/// Concentrations of the same rank among the class's as the grey levels have among the
/// visible ones.
fn ranked(reference: &Reference, small: &Normal, grey: &[f64], inverted: bool) -> Vec<f64> {
    let mut order: Vec<usize> = (0..grey.len()).filter(|&n| small.visible[n]).collect();
    order.sort_by(|&a, &b| grey[a].total_cmp(&grey[b]));
    let mut values = vec![reference.level; grey.len()];
    let count = order.len() as f64;
    let rising = reference.below != inverted;
    let mut first = 0;
    while first < order.len() {
        let equal = order[first..].iter().take_while(|&&n| grey[n] == grey[order[first]]).count();
        let rank = (first as f64 + 0.5 * equal as f64) / count;
        let c = reference.quantile(if rising { rank } else { 1.0 - rank });
        order[first..first + equal].iter().for_each(|&n| values[n] = c);
        first += equal;
    }
    values
}

/// The model with what is held.
struct Reaction<'a> {
    reference: &'a Reference,
    small: &'a Normal,
    bounds: &'a [[f64; 2]],
    inputs: &'a (dyn Inputs + Sync),
}

impl Reaction<'_> {
    /// Runs the model from `start` until no hidden cell changes; the ink's concentration.
    fn settle(&self, start: &[f64]) -> Result<Vec<f64>> {
        let Self { reference, small, .. } = *self;
        let mut run = Held::new(&reference.config, small.shape, self.inputs)?;
        let (least, greatest) = (reference.quantile(0.0), reference.quantile(1.0));
        let start: Vec<f64> = start.iter().map(|c| c.clamp(least, greatest)).collect();
        for s in 0..reference.count() {
            let values: Vec<f64> = start.iter().map(|&c| reference.mean(s, c)).collect();
            run.set(s, &values);
        }
        let hidden: Vec<usize> = (0..start.len()).filter(|&n| !small.visible[n]).collect();
        let colours =
            |c: &[f64]| -> Vec<bool> { hidden.iter().map(|&n| c[n] < reference.level).collect() };
        let (every, looks, share) = LOOK;
        let most = (run.iterations() / 2).max(LEAST);
        let (mut before, mut quiet, mut done) = (colours(&start), 0, 0);
        while done < most && (quiet < looks || done < LEAST) {
            run.advance(every, self.bounds)?;
            done += every;
            let now = colours(run.concentration());
            let changed = now.iter().zip(&before).filter(|(a, b)| a != b).count();
            quiet = if changed as f64 <= share * hidden.len() as f64 { quiet + 1 } else { 0 };
            before = now;
        }
        Ok(run.concentration().to_vec())
    }

    /// Number of connected parts of either colour among the hidden cells.
    fn parts(&self, c: &[f64]) -> Result<f64> {
        let grid = Grid::new(&self.small.shape, 1.0)?;
        let mut count = 0;
        for below in [false, true] {
            let pairs = c.iter().zip(&self.small.visible);
            let mask: Vec<bool> =
                pairs.map(|(c, seen)| !seen && (*c < self.reference.level) == below).collect();
            count += label_components(&mask, grid, Boundary::Neumann)?.sizes.len();
        }
        Ok(count as f64)
    }
}
