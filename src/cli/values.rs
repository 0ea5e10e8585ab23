//! Values of flags as configurations want them.

use anyhow::{Context as _, Result, bail};
use toml::Value;

/// `128`, `100x200` or `64x64x64` as a list of `axes` or more numbers.
///
/// # Errors
/// If a part is no whole number.
pub(super) fn size(text: &str, axes: usize) -> Result<Value> {
    let parts: Result<Vec<i64>, _> = text.split('x').map(|part| part.trim().parse()).collect();
    let wanted = || format!("--size {text}: expected N, NYxNX or NZxNYxNX, whole numbers");
    let mut parts = parts.with_context(wanted)?;
    if parts.is_empty() || parts.len() > 3 {
        bail!(wanted());
    }
    if parts.len() == 1 {
        parts = vec![parts[0]; axes];
    }
    Ok(Value::Array(parts.into_iter().map(Value::Integer).collect()))
}

/// `1.5,2` as a list of numbers.
///
/// # Errors
/// If a part is no number.
pub(super) fn list(text: &str, flag: &str) -> Result<Value> {
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parts = parts.with_context(|| format!("{flag} {text}: expected numbers with commas"))?;
    Ok(Value::Array(parts.into_iter().map(Value::Float).collect()))
}

/// A counter as TOML's integer; beyond its range the greatest one, which every range refuses.
pub(super) fn integer(value: Option<u64>) -> Option<i64> {
    value.map(|v| i64::try_from(v).unwrap_or(i64::MAX))
}

/// `0,4000` as a list of whole numbers.
///
/// # Errors
/// If a part is no whole number.
pub(super) fn integers(text: &str, flag: &str) -> Result<Value> {
    let parts: Result<Vec<i64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parts =
        parts.with_context(|| format!("{flag} {text}: expected whole numbers with commas"))?;
    Ok(Value::Array(parts.into_iter().map(Value::Integer).collect()))
}
