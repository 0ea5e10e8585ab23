//! How often classes are identified: patterns of unseen seeds, harmed in every way.

use super::degrade::{HARMS, Harm, harm};
use super::{Class, Identifier, Ink, normalize, simulate};
use crate::{NoInputs, Result};
use rayon::prelude::*;
use toml::Value;

/// Pictures of classes without chance are this much wider than their grid of elements.
const ENLARGED: usize = 3;

/// One picture of the evaluation.
#[derive(Clone, Debug)]
pub struct Case {
    /// The class that made it.
    pub class: usize,
    /// What was done to it.
    pub harm: Harm,
    /// Part of it that is hidden.
    pub share: f64,
    /// The class that was found; none if the picture has one colour.
    pub found: Option<usize>,
    /// Whether that is the class that made it, or one of its family.
    pub right: bool,
    /// Whether the answer was that none of the classes made it.
    pub none: bool,
    /// Probability given to the class that was found.
    pub confidence: f64,
    /// Relative error of each number among the parameters, if the class was found.
    pub errors: Vec<f64>,
}

/// The cases of pattern `index` of a class: point and run come from `seed`, which is not the
/// calibration's; a quarter and a half are hidden, in each of the ways of [`HARMS`].
///
/// # Errors
/// What a model refuses or meets on its way.
pub fn cases(identifier: &Identifier, class: usize, seed: u64, index: u64) -> Result<Vec<Case>> {
    let entry = &identifier.database().classes[class];
    let point = entry.point(seed, index);
    let mut pattern = simulate(entry, &point, seed * 1000 + index, &NoInputs)?;
    if !entry.free_seeds {
        pattern = enlarge(&pattern);
    }
    let ways: Vec<(Harm, f64)> = HARMS.iter().flat_map(|&h| [(h, 0.25), (h, 0.5)]).collect();
    ways.into_par_iter()
        .map(|(kind, share)| {
            let harmed = harm(&pattern, kind, share, seed * 1000 + index)?;
            let mut case = Case {
                class,
                harm: kind,
                share,
                found: None,
                right: false,
                none: true,
                confidence: 0.0,
                errors: Vec::new(),
            };
            let Ok(normal) = normalize(&harmed.picture, &harmed.visible) else { return Ok(case) };
            let answer = identifier.identify(&normal, &NoInputs)?;
            if let Some(first) = answer.ranking.first() {
                case.found = Some(first.class);
                case.right = identifier.database().classes[first.class].family == entry.family;
                case.none = answer.none;
                case.confidence = first.confidence;
                if first.class == class {
                    case.errors = errors(entry, &point, &first.point);
                }
            }
            Ok(case)
        })
        .collect()
}

fn enlarge(small: &Ink) -> Ink {
    let [ny, nx] = small.shape;
    let width = nx * ENLARGED;
    let at = |n: usize| small.ink[n / width / ENLARGED * nx + n % width / ENLARGED];
    let ink = (0..ny * ENLARGED * width).map(at).collect();
    Ink { shape: [ny * ENLARGED, width], ink }
}

/// |found - true| / |true| of every parameter that is a number.
fn errors(class: &Class, truth: &[f64], found: &[f64]) -> Vec<f64> {
    let number = |value: &Value| match value {
        Value::Float(v) => Some(*v),
        Value::Integer(v) => Some(*v as f64),
        _ => None,
    };
    let pairs = class.values(truth).into_iter().zip(class.values(found));
    pairs
        .filter_map(|(a, b)| Some((number(&a)?, number(&b)?)))
        .map(|(a, b)| ((b - a) / a).abs())
        .collect()
}
