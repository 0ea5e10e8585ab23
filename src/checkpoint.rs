//! Checkpoints on disk: an NPZ archive of a run's [`State`].

use crate::output::npy;
use anyhow::{Context as _, Result, bail};
use patterns::{State, Values};
use std::{
    fs::File,
    io::{Cursor, Read as _},
    path::Path,
};
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

/// Name of the checkpoint in an output folder.
pub const FILE: &str = "checkpoint.npz";

/// The archive's bytes: an NPZ of one-dimensional arrays, not compressed.
///
/// # Errors
/// If the archive cannot be built.
pub fn to_bytes(state: &State) -> Result<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, values) in &state.arrays {
        let (descr, count, data): (_, _, Vec<u8>) = match values {
            Values::F64(v) => ("<f8", v.len(), v.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Values::F32(v) => ("<f4", v.len(), v.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Values::U64(v) => ("<u8", v.len(), v.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Values::U8(v) => ("|u1", v.len(), v.clone()),
        };
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(data.len() >= u32::MAX as usize);
        archive.start_file(format!("{name}.npy"), options)?;
        npy::write_raw(descr, count, &data, &mut archive)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// Reads a checkpoint.
///
/// # Errors
/// If the file is missing, truncated or holds other types.
pub fn read(path: &Path) -> Result<State> {
    let arrays = || -> Result<State> {
        let mut archive = ZipArchive::new(File::open(path)?)?;
        let mut state = State::default();
        for n in 0..archive.len() {
            let mut file = archive.by_index(n)?;
            let name = file.name().trim_end_matches(".npy").to_owned();
            let mut bytes = Vec::new();
            file.read_to_end(&mut bytes).with_context(|| format!("`{name}`"))?;
            let values = values(&bytes).with_context(|| format!("`{name}`"))?;
            state.arrays.insert(name, values);
        }
        Ok(state)
    };
    arrays().with_context(|| format!("the checkpoint `{}` cannot be used", path.display()))
}

/// An array from the bytes of an NPY.
fn values(bytes: &[u8]) -> Result<Values> {
    let (descr, data) = npy::read_raw(bytes)?;
    Ok(match descr.as_str() {
        "<f8" => Values::F64(numbers(data, f64::from_le_bytes)),
        "<f4" => Values::F32(numbers(data, f32::from_le_bytes)),
        "<u8" => Values::U64(numbers(data, u64::from_le_bytes)),
        "|u1" => Values::U8(data.to_vec()),
        other => bail!("elements of type `{other}`, which no checkpoint has"),
    })
}

fn numbers<V, const N: usize>(data: &[u8], read: fn([u8; N]) -> V) -> Vec<V> {
    data.as_chunks::<N>().0.iter().map(|&bytes| read(bytes)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_comes_back_to_the_last_bit() {
        let mut state = State::default();
        state.put_f64("a", &[1.0, f64::MIN_POSITIVE, -0.0]);
        state.put_f32("b", &[0.1]);
        state.put_u64("c/d", &[u64::MAX]);
        state.put_u8("e", b"text");
        state.put_f64("empty", &[]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE);
        let bytes = to_bytes(&state).unwrap();
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(read(&path).unwrap(), state);
        for cut in [0, 10, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            assert!(read(&path).is_err(), "cut at {cut}");
        }
    }
}
