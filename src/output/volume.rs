//! Arrays with the place and size of their cells, as volume files carry them.

use anyhow::{Context as _, Result, ensure};
use ndarray::{ArrayD, IxDyn};
use std::io::Read;

/// An array and where its nodes are.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Its values: `[nz, ny, nx]`, leading axes may be absent.
    pub values: ArrayD<f64>,
    /// Distances of nodes along x, y, z (length).
    pub spacing: [f64; 3],
    /// Position x, y, z of the first node (length).
    pub origin: [f64; 3],
}

impl Volume {
    /// Nodes one apart, the first at 0.
    pub fn new(values: ArrayD<f64>) -> Self {
        Self { values, spacing: [1.0; 3], origin: [0.0; 3] }
    }

    /// Numbers of nodes along x, y, z.
    ///
    /// # Errors
    /// If there are more than three axes.
    pub fn sizes(&self) -> Result<[usize; 3]> {
        let shape = self.values.shape();
        ensure!(shape.len() <= 3, "shape {shape:?} is no volume; wanted are 1 to 3 axes");
        Ok(std::array::from_fn(|n| shape.len().checked_sub(n + 1).map_or(1, |axis| shape[axis])))
    }

    /// From values with x fastest; absent axes (of size 1, from the last) are dropped.
    pub(super) fn from_values(
        sizes: &[usize],
        values: Vec<f64>,
        spacing: [f64; 3],
        origin: [f64; 3],
    ) -> Result<Self> {
        let used = sizes.iter().rposition(|&n| n != 1).map_or(1, |last| last + 1);
        let shape: Vec<usize> = sizes[..used].iter().rev().copied().collect();
        for (v, name) in spacing.iter().zip(["x", "y", "z"]) {
            ensure!(v.is_finite() && *v > 0.0, "the spacing along {name} is {v}");
        }
        ensure!(origin.iter().all(|v| v.is_finite()), "the origin is {origin:?}");
        Ok(Self { values: ArrayD::from_shape_vec(IxDyn(&shape), values)?, spacing, origin })
    }
}

/// Types of elements that volume files have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Element {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers of `data`, a multiple of [`Self::bytes`].
    pub(super) fn decode(self, data: &[u8], little: bool) -> Vec<f64> {
        /// Reads elements of one type.
        macro_rules! all {
            ($kind:ty) => {{
                let read = |b: &[u8]| {
                    let b = b.try_into().unwrap_or_default();
                    (if little { <$kind>::from_le_bytes(b) } else { <$kind>::from_be_bytes(b) })
                        as f64
                };
                data.chunks_exact(size_of::<$kind>()).map(read).collect()
            }};
        }
        match self {
            Self::I8 => all!(i8),
            Self::U8 => all!(u8),
            Self::I16 => all!(i16),
            Self::U16 => all!(u16),
            Self::I32 => all!(i32),
            Self::U32 => all!(u32),
            Self::I64 => all!(i64),
            Self::U64 => all!(u64),
            Self::F32 => all!(f32),
            Self::F64 => all!(f64),
        }
    }
}

/// Number of elements of `sizes`, which must fit in `limit` bytes of f64.
pub(super) fn count(sizes: &[usize], limit: u64) -> Result<usize> {
    let count = sizes.iter().try_fold(1_usize, |n, &size| n.checked_mul(size));
    let count = count.with_context(|| format!("shape {sizes:?} overflows"))?;
    let needed = (count as u64).saturating_mul(8);
    ensure!(
        needed <= limit,
        "shape {sizes:?} needs {needed} bytes, more than the limit of {limit}"
    );
    Ok(count)
}

/// The first `count` bytes of `data`.
pub(super) fn head(data: &[u8], count: usize) -> Result<&[u8]> {
    let found = data.len();
    data.get(..count).with_context(|| {
        format!("{count} bytes of data are announced, {found} are there (truncated?)")
    })
}

/// At most `count` bytes of gzip `data`.
pub(crate) fn gunzip(data: &[u8], count: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    flate2::read::MultiGzDecoder::new(data)
        .take(count)
        .read_to_end(&mut bytes)
        .context("a truncated or corrupt gzip")?;
    Ok(bytes)
}
