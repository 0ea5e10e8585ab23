//! Statistics of patterns that the classes made, kept so that nothing has to be run to rank them.
//!
//! Never a pattern: a sample is the point in the class's ranges and the statistics of
//! [`solvers::texture::Descriptor`] of what is left of the pattern after some harm.

use super::{
    candidate::simulate,
    class::Class,
    classify::Sample,
    degrade::{Harm, harm},
    normalize::normalize,
};
use crate::{Error, Inputs, Result};
use solvers::texture::Descriptor;

/// Patterns of each class.
pub const PATTERNS: u64 = 36;

/// Seed of the points and of the runs; evaluations use others.
const SEED: u64 = 1;

/// What is kept of each pattern: every kind of harm that changes statistics.
const HARMS: [(Harm, [f64; 2]); 5] = [
    (Harm::Box, [0.25, 0.25]),
    (Harm::SmallBoxes, [0.5, 0.5]),
    (Harm::Speckle, [0.25, 0.5]),
    (Harm::Blur, [0.5, 0.25]),
    (Harm::Rotate, [0.25, 0.5]),
];

/// First bytes of the file.
const MAGIC: &[u8; 8] = b"PATCAL1\n";

/// Statistics are kept as multiples of this, shares of a range as multiples of its square.
const UNIT: f64 = 5e-4;

/// A point of a class's ranges and the statistics of a picture from there.
type Known = (Vec<f64>, Vec<f64>);

/// The samples of classes by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Name of each class and its samples: the point and the statistics.
    pub classes: Vec<(String, Vec<Known>)>,
}

/// The calibration that the program carries.
///
/// # Errors
/// [`Error::Config`] if the file is damaged.
pub fn built_in() -> Result<Calibration> {
    Calibration::from_bytes(include_bytes!("../../database/calibration.bin"))
}

/// The samples of the pattern `index` of `class`: fewer than five if harm leaves one colour.
///
/// # Errors
/// What the model refuses or meets on its way.
pub fn samples(
    class: &Class,
    index: u64,
    inputs: &dyn Inputs,
) -> Result<Vec<(Vec<f64>, Vec<f64>)>> {
    let point = class.point(SEED, index);
    let pattern = simulate(class, &point, SEED * 1000 + index, inputs)?;
    let mut found = Vec::new();
    for (kind, shares) in HARMS {
        let harmed = harm(&pattern, kind, shares[(index % 2) as usize], index * 7 + SEED)?;
        let Ok(normal) = normalize(&harmed.picture, &harmed.visible) else { continue };
        let Some(descriptor) = Descriptor::new(&normal.masked()?) else { continue };
        found.push((
            point.iter().map(|&v| rounded(v, UNIT * UNIT)).collect(),
            descriptor.values.iter().map(|&v| rounded(v, UNIT)).collect(),
        ));
    }
    Ok(found)
}

/// To the nearest multiple of `unit` that the file can hold.
fn rounded(value: f64, unit: f64) -> f64 {
    let most = if unit == UNIT { f64::from(i16::MAX) } else { f64::from(i32::MAX) };
    (value / unit).round().clamp(-most, most) * unit
}

impl Calibration {
    /// Samples for a classifier of `classes`; classes that are not calibrated are left out.
    pub fn select(&self, classes: &[&Class]) -> Vec<Sample> {
        let mut samples = Vec::new();
        for (class, wanted) in classes.iter().enumerate() {
            let found = self.classes.iter().filter(|(name, _)| *name == wanted.name);
            samples.extend(found.flat_map(|(_, list)| list).map(|(point, values)| Sample {
                class,
                point: point.clone(),
                values: values.clone(),
            }));
        }
        samples
    }

    /// As a file: for each class its name, the number of samples, of ranges and of
    /// statistics, then points as 32-bit and statistics as 16-bit whole numbers, little endian.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for (name, samples) in &self.classes {
            let (ranges, length) =
                samples.first().map_or((0, 0), |(point, values)| (point.len(), values.len()));
            for count in [name.len(), samples.len(), ranges, length] {
                bytes.extend((count as u32).to_le_bytes());
            }
            bytes.extend(name.bytes());
            for (point, values) in samples {
                let shares = point.iter().map(|v| (v / (UNIT * UNIT)).round() as i32);
                bytes.extend(shares.flat_map(i32::to_le_bytes));
                let statistics = values.iter().map(|v| (v / UNIT).round() as i16);
                bytes.extend(statistics.flat_map(i16::to_le_bytes));
            }
        }
        bytes
    }

    /// Reads what [`Calibration::to_bytes`] wrote.
    ///
    /// # Errors
    /// [`Error::Config`] for `calibration` if the content is another or ends too early.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let damaged = || Error::config("calibration", "no calibration, or a damaged one");
        let mut rest = bytes.strip_prefix(MAGIC).ok_or_else(damaged)?;
        let mut calibration = Self::default();
        while !rest.is_empty() {
            let mut counts = [0; 4];
            for count in &mut counts {
                *count = u32::from_le_bytes(take(&mut rest).ok_or_else(damaged)?) as usize;
            }
            let [letters, samples, ranges, length] = counts;
            let name = rest.get(..letters).ok_or_else(damaged)?;
            let name = std::str::from_utf8(name).map_err(|_| damaged())?.to_owned();
            rest = &rest[letters..];
            let mut list = Vec::new();
            for _ in 0..samples {
                let mut point = Vec::new();
                for _ in 0..ranges {
                    let share = i32::from_le_bytes(take(&mut rest).ok_or_else(damaged)?);
                    point.push(f64::from(share) * (UNIT * UNIT));
                }
                let mut values = Vec::new();
                for _ in 0..length {
                    let statistic = i16::from_le_bytes(take(&mut rest).ok_or_else(damaged)?);
                    values.push(f64::from(statistic) * UNIT);
                }
                list.push((point, values));
            }
            calibration.classes.push((name, list));
        }
        Ok(calibration)
    }
}

/// The next `N` bytes.
fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = rest.split_first_chunk()?;
    *rest = tail;
    Some(*head)
}
