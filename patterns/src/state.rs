//! Checkpoints: named arrays, exact to the last bit.

use crate::{Error, Result};
use std::collections::BTreeMap;

/// The state of a run as named arrays. The laboratory stores them as NPZ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// The arrays, by name.
    pub arrays: BTreeMap<String, Values>,
}

/// A one-dimensional array of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// 64-bit floats.
    F64(Vec<f64>),
    /// 32-bit floats.
    F32(Vec<f32>),
    /// Counters.
    U64(Vec<u64>),
    /// Raw bytes: text, pictures, random generators.
    U8(Vec<u8>),
}

impl State {
    /// Adds 64-bit floats.
    pub fn put_f64(&mut self, name: &str, values: &[f64]) {
        self.arrays.insert(name.into(), Values::F64(values.to_vec()));
    }

    /// Adds 32-bit floats.
    pub fn put_f32(&mut self, name: &str, values: &[f32]) {
        self.arrays.insert(name.into(), Values::F32(values.to_vec()));
    }

    /// Adds counters.
    pub fn put_u64(&mut self, name: &str, values: &[u64]) {
        self.arrays.insert(name.into(), Values::U64(values.to_vec()));
    }

    /// Adds bytes.
    pub fn put_u8(&mut self, name: &str, values: &[u8]) {
        self.arrays.insert(name.into(), Values::U8(values.to_vec()));
    }

    /// Copies 64-bit floats into `target`, which has the right length.
    ///
    /// # Errors
    /// If the array is missing, of another type or of another length.
    pub fn get_f64(&self, name: &str, target: &mut [f64]) -> Result<()> {
        match self.arrays.get(name) {
            Some(Values::F64(values)) if values.len() == target.len() => {
                target.copy_from_slice(values);
                Ok(())
            }
            other => Err(mismatch(name, &format!("{} 64-bit floats", target.len()), other)),
        }
    }

    /// Copies 32-bit floats into `target`, which has the right length.
    ///
    /// # Errors
    /// If the array is missing, of another type or of another length.
    pub fn get_f32(&self, name: &str, target: &mut [f32]) -> Result<()> {
        match self.arrays.get(name) {
            Some(Values::F32(values)) if values.len() == target.len() => {
                target.copy_from_slice(values);
                Ok(())
            }
            other => Err(mismatch(name, &format!("{} 32-bit floats", target.len()), other)),
        }
    }

    /// 64-bit floats of any length.
    ///
    /// # Errors
    /// If the array is missing or of another type.
    pub fn all_f64(&self, name: &str) -> Result<&[f64]> {
        match self.arrays.get(name) {
            Some(Values::F64(values)) => Ok(values),
            other => Err(mismatch(name, "64-bit floats", other)),
        }
    }

    /// Counters of any length.
    ///
    /// # Errors
    /// If the array is missing or of another type.
    pub fn all_u64(&self, name: &str) -> Result<&[u64]> {
        match self.arrays.get(name) {
            Some(Values::U64(values)) => Ok(values),
            other => Err(mismatch(name, "counters", other)),
        }
    }

    /// A single counter.
    ///
    /// # Errors
    /// If it is missing, of another type or not alone.
    pub fn one_u64(&self, name: &str) -> Result<u64> {
        match self.arrays.get(name) {
            Some(Values::U64(values)) if values.len() == 1 => Ok(values[0]),
            other => Err(mismatch(name, "1 counter", other)),
        }
    }

    /// Bytes of any length.
    ///
    /// # Errors
    /// If the array is missing or of another type.
    pub fn all_u8(&self, name: &str) -> Result<&[u8]> {
        match self.arrays.get(name) {
            Some(Values::U8(values)) => Ok(values),
            other => Err(mismatch(name, "bytes", other)),
        }
    }
}

fn mismatch(name: &str, wanted: &str, found: Option<&Values>) -> Error {
    let found = match found {
        None => "nothing".into(),
        Some(Values::F64(v)) => format!("{} 64-bit floats", v.len()),
        Some(Values::F32(v)) => format!("{} 32-bit floats", v.len()),
        Some(Values::U64(v)) => format!("{} counters", v.len()),
        Some(Values::U8(v)) => format!("{} bytes", v.len()),
    };
    let told = format!("`{name}` should hold {wanted} and holds {found}");
    Error::Checkpoint(format!("{told}; an older or newer version may have written it"))
}
