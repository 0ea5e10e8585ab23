//! Voxels whose phase is given.

use rayon::prelude::*;
use solvers::{Error, Float, Result};

/// Voxels of a task.
const PART: usize = 4096;

/// Voxels at which u is given: included ones (any value) and excluded ones (-1).
#[derive(Clone, Debug)]
pub struct Mask<T> {
    /// The given value, or NaN where u is free.
    values: Vec<T>,
}

impl<T: Float> Mask<T> {
    /// From the given values, NaN where u is free.
    ///
    /// # Errors
    /// If a value is infinite.
    pub fn new(values: Vec<T>) -> Result<Self> {
        match values.iter().find(|v| v.to_f64().is_infinite()) {
            Some(v) => Err(Error::out_of_range("given phase", v.to_f64(), "(-inf, inf)")),
            None => Ok(Self { values }),
        }
    }

    /// u = -1 where `inside` is false, free where it is true.
    pub fn outside(inside: &[bool]) -> Self {
        let value = |&inside: &bool| T::from_f64(if inside { f64::NAN } else { -1.0 });
        Self { values: inside.iter().map(value).collect() }
    }

    /// Puts the given values into `u`.
    pub fn fix(&self, u: &mut [T]) {
        u.par_iter_mut().zip(&self.values).with_min_len(PART).for_each(|(u, &value)| {
            if !value.to_f64().is_nan() {
                *u = value;
            }
        });
    }

    /// Puts 0 where u is given.
    pub fn clear(&self, gradient: &mut [T]) {
        gradient.par_iter_mut().zip(&self.values).with_min_len(PART).for_each(
            |(gradient, value)| {
                if !value.to_f64().is_nan() {
                    *gradient = T::from_f64(0.0);
                }
            },
        );
    }
}
