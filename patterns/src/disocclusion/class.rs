//! A class of the database: a model, what is fixed in its configuration, and ranges of the rest.

use crate::{Context, Error, Inputs, MODELS, Model, Result};
use solvers::random::{stream, uniform};
use toml::{Table, Value};

/// Keys of an entry.
const KEYS: &[&str] = &["name", "about", "family", "model", "seeds", "config", "range"];

/// Keys of a range.
const RANGE_KEYS: &[&str] = &["low", "high", "log", "integer", "choices", "also"];

/// A model and ranges of its configuration; never a stored pattern.
#[derive(Clone)]
pub struct Class {
    /// Name, `kebab-case`.
    pub name: String,
    /// One sentence.
    pub about: String,
    /// Classes of one family make pictures that cannot be told apart; without one, the name.
    pub family: String,
    /// The model that makes its patterns.
    pub model: &'static Model,
    /// Whether a seed changes the pattern: such classes are matched by statistics, the
    /// others pixel by pixel.
    pub free_seeds: bool,
    /// The model's configuration, complete, before the ranges are written into it.
    pub config: Table,
    /// What varies, in the order of the keys.
    pub ranges: Vec<Range>,
}

/// What a key of the configuration may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Dotted key of the configuration; numbers count the entries of a list from 0.
    pub key: String,
    /// Further keys that take the same value.
    pub also: Vec<String>,
    /// The values.
    pub values: Values,
}

/// The values of a [`Range`].
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers between two others, both included.
    Between {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Whether ratios count, not differences.
        log: bool,
        /// Whether only whole numbers are meant.
        integer: bool,
    },
    /// One of a list.
    Choices(Vec<Value>),
}

impl Values {
    /// The value at `share` of the way through the range, in [0, 1] (clamped).
    pub fn at(&self, share: f64) -> Value {
        let share = share.clamp(0.0, 1.0);
        match self {
            Self::Between { low, high, log, integer } => {
                let value = if *log {
                    low * libm::exp(share * libm::log(high / low))
                } else {
                    low + share * (high - low)
                };
                if *integer { Value::Integer(value.round() as i64) } else { Value::Float(value) }
            }
            Self::Choices(list) => {
                let last = list.len() - 1;
                list[((share * list.len() as f64) as usize).min(last)].clone()
            }
        }
    }

    /// The inverse of [`Values::at`], the middle of those that give `value`; outside of [0, 1]
    /// outside of the range, none for what is no value of it.
    fn share(&self, value: &Value) -> Option<f64> {
        let number = match value {
            Value::Integer(n) => *n as f64,
            Value::Float(x) => *x,
            _ => f64::NAN,
        };
        let share = match self {
            Self::Between { low, high, log: true, .. } => {
                libm::log(number / low) / libm::log(high / low)
            }
            Self::Between { low, high, .. } => (number - low) / (high - low),
            Self::Choices(list) => {
                let n = list.iter().position(|choice| choice == value)?;
                (n as f64 + 0.5) / list.len() as f64
            }
        };
        share.is_finite().then_some(share)
    }
}

impl Class {
    /// Reads an entry.
    ///
    /// # Errors
    /// [`Error::Config`] with the key and what is wanted: an unknown or missing key, a model
    /// that is not there, a range that is empty, a value that the model refuses.
    pub fn parse(text: &str, inputs: &dyn Inputs) -> Result<Self> {
        let table: Table = text.parse().map_err(|e: toml::de::Error| {
            Error::config("toml", e.to_string().trim().replace('\n', " "))
        })?;
        known(&table, KEYS, "")?;
        let name = text_of(&table, "name")?;
        let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if name.is_empty() || !name.chars().all(good) {
            let reason = format!("`{name}`: wanted are letters a to z, digits and `-`");
            return Err(Error::config("name", reason));
        }
        let wanted = text_of(&table, "model")?;
        let model = MODELS.iter().copied().find(|model| model.name == wanted).ok_or_else(|| {
            let names: Vec<_> = MODELS.iter().map(|model| model.name).collect();
            Error::config("model", format!("no `{wanted}`; known: {}", names.join(", ")))
        })?;
        let free_seeds = match text_of(&table, "seeds")?.as_str() {
            "free" => true,
            "fixed" => false,
            other => {
                return Err(Error::config("seeds", format!("`{other}`; wanted: free, fixed")));
            }
        };
        // Complete, so that ranges reach into the lists of a preset.
        let context = Context { seed: 0, inputs, memory: 1 << 30 };
        let config = (model.start)(&table_of(&table, "config")?, &context)
            .map_err(|error| inside("config", error))?
            .config();
        let ranges = table_of(&table, "range")?;
        let ranges: Result<Vec<_>> = ranges.iter().map(|(k, v)| range(k, v)).collect();
        let about = text_of(&table, "about")?;
        let family =
            if table.contains_key("family") { text_of(&table, "family")? } else { name.clone() };
        Ok(Self { name, about, family, model, free_seeds, config, ranges: ranges? })
    }

    /// Starts the model at the ends of every range, the others in their middle.
    ///
    /// # Errors
    /// [`Error::Config`] with the range's key and what the model says to the value.
    pub fn check(&self, inputs: &dyn Inputs) -> Result<()> {
        let context = Context { seed: 0, inputs, memory: 1 << 30 };
        for (n, range) in self.ranges.iter().enumerate() {
            for share in [0.0, 1.0] {
                let mut point = vec![0.5; self.ranges.len()];
                point[n] = share;
                (self.model.start)(&self.configure(&point)?, &context).map_err(|error| {
                    let value = range.values.at(share);
                    Error::config(
                        &format!("range.\"{}\"", range.key),
                        format!("at {value}: {error}"),
                    )
                })?;
            }
        }
        Ok(())
    }

    /// The configuration at `point`, one share in [0, 1] per range.
    ///
    /// # Errors
    /// [`Error::Config`] if a key of a range leads through something that is no table or list.
    pub fn configure(&self, point: &[f64]) -> Result<Table> {
        let mut config = self.config.clone();
        for (range, &share) in self.ranges.iter().zip(point) {
            for key in std::iter::once(&range.key).chain(&range.also) {
                set(&mut config, key, range.values.at(share))?;
            }
        }
        Ok(config)
    }

    /// Values of the ranges at `point`.
    pub fn values(&self, point: &[f64]) -> Vec<Value> {
        self.ranges.iter().zip(point).map(|(range, &share)| range.values.at(share)).collect()
    }

    /// The point of the entry's own configuration; the middle of ranges that it lies outside of.
    pub fn usual(&self) -> Vec<f64> {
        let share = |range: &Range| {
            let own = get(&self.config, &range.key)?;
            let share = range.values.share(own)?;
            (0.0..=1.0).contains(&share).then_some(share)
        };
        self.ranges.iter().map(|range| share(range).unwrap_or(0.5)).collect()
    }

    /// The `index`th of a sequence of points that fill the ranges evenly: a Kronecker
    /// sequence (Roberts 2018, roots of x^(d+1) = x + 1) shifted by the seed.
    pub fn point(&self, seed: u64, index: u64) -> Vec<f64> {
        let dim = self.ranges.len() as i32;
        let root = (0..60).fold(2.0_f64, |x, _| (1.0 + x).powf(1.0 / f64::from(dim + 1)));
        let mut shift = stream(seed, &self.name, 0);
        (1..=dim)
            .map(|d| (uniform(&mut shift) + (index + 1) as f64 / root.powi(d)).rem_euclid(1.0))
            .collect()
    }
}

/// An error of a configuration with the table in which it is.
fn inside(table: &str, error: Error) -> Error {
    match error {
        Error::Config { key, reason } => Error::Config { key: format!("{table}.{key}"), reason },
        other => other,
    }
}

/// The value at a dotted key.
pub(super) fn get<'a>(config: &'a Table, key: &str) -> Option<&'a Value> {
    let mut parts = key.split('.');
    let first = config.get(parts.next()?)?;
    parts.try_fold(first, |at, part| match at {
        Value::Table(table) => table.get(part),
        Value::Array(list) => list.get(part.parse::<usize>().ok()?),
        _ => None,
    })
}

/// Writes `value` at a dotted key; tables that are missing are made, lists are not.
fn set(config: &mut Table, key: &str, value: Value) -> Result<()> {
    let broken = |reason: String| Error::config(&format!("range.\"{key}\""), reason);
    let (first, rest) = match key.split_once('.') {
        Some((first, rest)) => (first, Some(rest)),
        None => (key, None),
    };
    let Some(rest) = rest else {
        config.insert(first.into(), value);
        return Ok(());
    };
    let mut at = config.entry(first).or_insert_with(|| Value::Table(Table::new()));
    let parts: Vec<&str> = rest.split('.').collect();
    for (n, part) in parts.iter().enumerate() {
        let slot = match at {
            Value::Table(table) => table.entry(*part).or_insert_with(|| Value::Table(Table::new())),
            Value::Array(list) => {
                let length = list.len();
                let index: Option<usize> = part.parse().ok();
                match index.and_then(|index| list.get_mut(index)) {
                    Some(slot) => slot,
                    None => {
                        return Err(broken(format!("no entry `{part}` in a list of {length}")));
                    }
                }
            }
            other => {
                return Err(broken(format!(
                    "`{part}` would be inside a value of type {}",
                    other.type_str()
                )));
            }
        };
        if n + 1 == parts.len() {
            *slot = value;
            return Ok(());
        }
        at = slot;
    }
    Ok(())
}

fn known(table: &Table, keys: &[&str], prefix: &str) -> Result<()> {
    match table.keys().find(|key| !keys.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => {
            let key = format!("{prefix}{key}");
            Err(Error::config(&key, format!("unknown key; known: {}", keys.join(", "))))
        }
    }
}

fn text_of(table: &Table, key: &str) -> Result<String> {
    match table.get(key) {
        Some(Value::String(text)) => Ok(text.clone()),
        Some(other) => {
            Err(Error::config(key, format!("expected text, found {}", other.type_str())))
        }
        None => Err(Error::config(key, "missing")),
    }
}

fn table_of(table: &Table, key: &str) -> Result<Table> {
    match table.get(key) {
        Some(Value::Table(inner)) => Ok(inner.clone()),
        Some(other) => {
            Err(Error::config(key, format!("expected a table, found {}", other.type_str())))
        }
        None => Ok(Table::new()),
    }
}

fn range(key: &str, value: &Value) -> Result<Range> {
    let name = format!("range.\"{key}\"");
    let fail = |part: &str, reason: String| Err(Error::config(&format!("{name}{part}"), reason));
    let Value::Table(table) = value else {
        return fail("", format!("expected {{ low, high }} or {{ choices }}, found {value}"));
    };
    known(table, RANGE_KEYS, &format!("{name}."))?;
    let flag = |part: &str| match table.get(part) {
        None => Ok(false),
        Some(Value::Boolean(flag)) => Ok(*flag),
        Some(other) => {
            Err(Error::config(&format!("{name}.{part}"), format!("expected true, found {other}")))
        }
    };
    let mut also = Vec::new();
    match table.get("also") {
        None => {}
        Some(Value::Array(list)) if list.iter().all(Value::is_str) => {
            also.extend(list.iter().filter_map(Value::as_str).map(str::to_owned));
        }
        Some(other) => return fail(".also", format!("expected a list of keys, found {other}")),
    }
    if let Some(choices) = table.get("choices") {
        return match choices {
            Value::Array(list) if !list.is_empty() => {
                Ok(Range { key: key.into(), also, values: Values::Choices(list.clone()) })
            }
            other => fail(".choices", format!("expected a list of values, found {other}")),
        };
    }
    let number = |part: &str| {
        let value = match table.get(part) {
            Some(Value::Float(value)) => *value,
            Some(Value::Integer(value)) => *value as f64,
            Some(other) => {
                let reason = format!("expected a number, found {other}");
                return Err(Error::config(&format!("{name}.{part}"), reason));
            }
            None => return Err(Error::config(&format!("{name}.{part}"), "missing")),
        };
        let finite = value.is_finite().then_some(value);
        finite.ok_or_else(|| Error::range(&format!("{name}.{part}"), value, "(-inf, inf)"))
    };
    let (low, high, log, integer) =
        (number("low")?, number("high")?, flag("log")?, flag("integer")?);
    if low >= high {
        let key = format!("{name}.high");
        return Err(Error::range(&key, high, &format!("(low = {low}, inf)")));
    }
    if log && low <= 0.0 {
        let key = format!("{name}.low");
        return Err(Error::range(&key, low, "(0, high), as a logarithmic range needs"));
    }
    if integer && (low.fract() != 0.0 || high.fract() != 0.0) {
        return fail("", format!("[{low}, {high}]: whole numbers are wanted"));
    }
    let values = Values::Between { low, high, log, integer };
    Ok(Range { key: key.into(), also, values })
}
