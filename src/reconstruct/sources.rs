//! The picture, its mask and the truth: from files, or made and hidden by the program.

use super::Config;
use crate::{database, inputs::FileInputs, request::Request};
use anyhow::{Result, bail};
use patterns::{
    Error, Inputs as _, NoInputs,
    disocclusion::{
        Occluder, at_mean,
        degrade::{HARMS, Harm, harm},
        detect, normalize, reduced, simulate,
    },
};
use serde::{Deserialize, Serialize};
use solvers::Field;
use std::path::{Path, PathBuf};

/// Least number of rows and columns: less holds no statistics.
const LEAST: usize = 16;

/// Longer sides are worked on at a whole fraction of their size.
const LARGEST: usize = 1024;

/// Most pixels to an element of an example.
const MAGNIFIED: usize = 64;

/// A picture that the program makes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Example {
    /// The class that makes it.
    pub class: String,
    /// Seed of the pattern and of what is done to it.
    pub seed: u64,
    /// What is done to it: box, small-boxes, dots, speckle, blur, invert or rotate.
    pub harm: String,
    /// Part that is hidden, in [0, 1).
    pub share: f64,
    /// Whether the mask is kept back, so that it has to be found.
    #[serde(default)]
    pub find: bool,
    /// Pixels to an element, for classes without chance, in [1, 64].
    #[serde(default = "three")]
    pub magnify: usize,
}

fn three() -> usize {
    3
}

/// A picture with what is known of it.
pub struct Source {
    /// Grey levels, as read.
    pub picture: Field,
    /// What is visible of it.
    pub visible: Vec<bool>,
    /// Ink of the whole picture.
    pub truth: Option<Vec<bool>>,
    /// Grey levels of the whole picture, if they were read.
    pub truth_levels: Option<Field>,
    /// How the mask was found, if it was not given.
    pub detected: Option<Vec<(Occluder, usize)>>,
    /// The picture is worked on at 1 / `factor` of its size.
    pub factor: usize,
    /// The picture and mask at that size.
    pub work: Field,
    /// The mask at that size.
    pub work_visible: Vec<bool>,
}

impl Source {
    /// Splits the truth at the mean of its grey levels, as the picture was.
    pub(super) fn split_truth_at_mean(&mut self) {
        let Some(levels) = &self.truth_levels else { return };
        let all = vec![true; levels.as_slice().len()];
        let split = normalize(levels, &all).ok().and_then(|normal| at_mean(levels, &normal));
        if let Some(split) = split {
            self.truth = Some(split.ink);
        }
    }

    /// Rows and columns.
    pub fn shape(&self) -> [usize; 2] {
        plane(&self.picture)
    }

    /// Part of the pixels that is hidden.
    pub fn hidden(&self) -> f64 {
        let hidden = self.visible.iter().filter(|seen| !**seen).count();
        hidden as f64 / self.visible.len() as f64
    }
}

fn plane(field: &Field) -> [usize; 2] {
    let [_, ny, nx] = field.grid().shape();
    [ny, nx]
}

/// The path of a file or folder as the request's folders have it.
pub(super) fn find(request: &Request, path: &str) -> PathBuf {
    let candidates = request.base.iter().map(|folder| folder.join(path));
    candidates.clone().find(|c| c.exists()).unwrap_or_else(|| Path::new(path).to_path_buf())
}

/// Reads or makes the picture, and finds out what is hidden.
pub(super) fn load(config: &Config, request: &Request, inputs: &FileInputs) -> Result<Source> {
    let located = |error| request.locate(error);
    let mut levels = None;
    let (picture, given, truth) = match (&config.picture, &config.example) {
        (Some(path), None) => {
            let picture = inputs.field("picture", path).map_err(located)?;
            check_size(&picture).map_err(located)?;
            let given = mask(config, &picture, inputs).map_err(located)?;
            let truth = config.truth.as_ref().map(|path| truth(path, &picture, inputs));
            let (truth, read) = truth.transpose().map_err(located)?.unzip();
            levels = read;
            (picture, given, truth)
        }
        (None, Some(example)) => make(example, config, request)?,
        (None, None) => bail!(located(Error::config("picture", "missing"))),
        (Some(_), Some(_)) => {
            bail!(located(Error::config("example", "a picture is given already")))
        }
    };
    let (visible, detected) = match given {
        Some(visible) => (visible, None),
        None => {
            let detection = detect(&picture).map_err(located)?;
            (detection.visible, Some(detection.found))
        }
    };
    check_mask(&visible, detected.is_some()).map_err(located)?;
    let [ny, nx] = plane(&picture);
    let factor = ny.max(nx).div_ceil(LARGEST);
    let (work, work_visible) = reduced(&picture, &visible, factor)?;
    let truth_levels = levels;
    Ok(Source { picture, visible, truth, truth_levels, detected, factor, work, work_visible })
}

fn check_size(picture: &Field) -> Result<(), Error> {
    let dim = picture.grid().dim();
    if dim != 2 {
        return Err(Error::config("picture", format!("has {dim} axes, 2 are wanted")));
    }
    let [ny, nx] = plane(picture);
    if ny.min(nx) < LEAST {
        let reason = format!("{nx} x {ny} pixels, at least {LEAST} x {LEAST} are wanted");
        return Err(Error::config("picture", reason));
    }
    Ok(())
}

fn check_mask(visible: &[bool], detected: bool) -> Result<(), Error> {
    if !visible.contains(&true) {
        return Err(Error::config("mask", "hides the whole picture"));
    }
    if visible.contains(&false) {
        return Ok(());
    }
    Err(Error::config(
        "mask",
        match detected {
            true => {
                "nothing hidden was found: no region of one grey level, of random dots, no noise; \
                 --mask, --mask-box or --mask-circle tell what is hidden"
            }
            false => "hides nothing",
        },
    ))
}

/// The mask that the configuration gives.
fn mask(config: &Config, picture: &Field, inputs: &FileInputs) -> Result<Option<Vec<bool>>, Error> {
    let [ny, nx] = plane(picture);
    if let Some(path) = &config.mask {
        let mask = inputs.field("mask", path)?;
        same_size("mask", &mask, picture)?;
        return Ok(Some(mask.as_slice().iter().map(|&v| v <= 0.5).collect()));
    }
    if let Some([left, top, width, height]) = config.mask_box {
        let outside = left.saturating_add(width) > nx || top.saturating_add(height) > ny;
        if outside || width == 0 || height == 0 {
            let reason = format!(
                "column {left}, row {top}, {width} x {height} is no box in {nx} x {ny} pixels"
            );
            return Err(Error::config("mask_box", reason));
        }
        let hidden = |n: usize| {
            (left..left + width).contains(&(n % nx)) && (top..top + height).contains(&(n / nx))
        };
        return Ok(Some((0..ny * nx).map(|n| !hidden(n)).collect()));
    }
    if let Some([x, y, radius]) = config.mask_circle {
        if !(x.is_finite() && y.is_finite() && radius > 0.0 && radius.is_finite()) {
            return Err(Error::range("mask_circle", radius, "(0, inf) of the radius"));
        }
        let far = |n: usize| ((n % nx) as f64 + 0.5 - x).hypot((n / nx) as f64 + 0.5 - y) > radius;
        return Ok(Some((0..ny * nx).map(far).collect()));
    }
    Ok(None)
}

/// Ink and grey levels of the whole picture.
fn truth(path: &str, picture: &Field, inputs: &FileInputs) -> Result<(Vec<bool>, Field), Error> {
    let whole = inputs.field("truth", path)?;
    same_size("truth", &whole, picture)?;
    let all = vec![true; whole.as_slice().len()];
    let normal = normalize(&whole, &all).map_err(|error| match error {
        Error::Config { reason, .. } => Error::config("truth", reason),
        other => other,
    })?;
    Ok((normal.ink, whole))
}

fn same_size(key: &str, field: &Field, picture: &Field) -> Result<(), Error> {
    let (found, wanted) = (field.grid(), picture.grid());
    if found.axes() == wanted.axes() {
        return Ok(());
    }
    let text =
        |axes: &[usize]| axes.iter().rev().map(usize::to_string).collect::<Vec<_>>().join(" x ");
    let reason = format!("{} pixels, the picture has {}", text(found.axes()), text(wanted.axes()));
    Err(Error::config(key, reason))
}

type Made = (Field, Option<Vec<bool>>, Option<Vec<bool>>);

/// Runs a class in the middle of its ranges, without chance at its entry's own configuration, and
/// hides a part.
fn make(example: &Example, config: &Config, request: &Request) -> Result<Made> {
    let folder = config.database.as_ref().map(|folder| find(request, folder));
    let (classes, _) = database::load(folder.as_deref())?;
    if !(1..=MAGNIFIED).contains(&example.magnify) {
        let (value, range) = (example.magnify as f64, format!("[1, {MAGNIFIED}]"));
        return Err(request.locate(Error::range("example.magnify", value, &range)));
    }
    let Some(class) = classes.find(&example.class) else {
        bail!("example.class: no class `{}`; `patterns database list` has them", example.class);
    };
    let Some(kind) = HARMS.into_iter().find(|harm| harm_name(*harm) == example.harm) else {
        let known = HARMS.map(harm_name).join(", ");
        bail!("example.harm: no `{}`; known: {known}", example.harm);
    };
    let point = match class.free_seeds {
        true => vec![0.5; class.ranges.len()],
        false => class.usual(),
    };
    let mut pattern = simulate(class, &point, example.seed, &NoInputs)?;
    if !class.free_seeds {
        pattern = pattern.magnify(example.magnify);
    }
    let harmed = harm(&pattern, kind, example.share, example.seed)?;
    let given = (!example.find).then_some(harmed.visible);
    let truth = match kind {
        Harm::Invert => harmed.truth.iter().map(|ink| !ink).collect(),
        _ => harmed.truth,
    };
    Ok((harmed.picture, given, Some(truth)))
}

/// Name of a harm in files.
pub(super) fn harm_name(harm: Harm) -> &'static str {
    match harm {
        Harm::Box => "box",
        Harm::SmallBoxes => "small-boxes",
        Harm::Dots => "dots",
        Harm::Speckle => "speckle",
        Harm::Blur => "blur",
        Harm::Invert => "invert",
        Harm::Rotate => "rotate",
    }
}
