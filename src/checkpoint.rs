//! Checkpoints on disk: an NPZ archive of a run's [`State`].

use anyhow::{Context as _, Result, bail};
use ndarray::{Array1, Ix1, OwnedRepr};
use ndarray_npy::{NpzReader, NpzWriter};
use patterns::{State, Values};
use std::{fs::File, io::Cursor, path::Path};

/// Name of the checkpoint in an output folder.
pub const FILE: &str = "checkpoint.npz";

/// The archive's bytes.
///
/// # Errors
/// If the archive cannot be built.
pub fn to_bytes(state: &State) -> Result<Vec<u8>> {
    let mut archive = NpzWriter::new(Cursor::new(Vec::new()));
    for (name, values) in &state.arrays {
        match values {
            Values::F64(v) => archive.add_array(name, &Array1::from(v.clone()))?,
            Values::F32(v) => archive.add_array(name, &Array1::from(v.clone()))?,
            Values::U64(v) => archive.add_array(name, &Array1::from(v.clone()))?,
            Values::U8(v) => archive.add_array(name, &Array1::from(v.clone()))?,
        }
    }
    Ok(archive.finish()?.into_inner())
}

/// Reads a checkpoint.
///
/// # Errors
/// If the file is missing, truncated or holds other types.
pub fn read(path: &Path) -> Result<State> {
    let broken = || format!("the checkpoint `{}` cannot be used", path.display());
    let file = File::open(path).with_context(broken)?;
    let mut archive = NpzReader::new(file).with_context(broken)?;
    let mut state = State::default();
    for file in archive.names().with_context(broken)? {
        let name = file.trim_end_matches(".npy").to_owned();
        let values = if let Ok(a) = archive.by_name::<OwnedRepr<f64>, Ix1>(&file) {
            Values::F64(a.into_raw_vec_and_offset().0)
        } else if let Ok(a) = archive.by_name::<OwnedRepr<f32>, Ix1>(&file) {
            Values::F32(a.into_raw_vec_and_offset().0)
        } else if let Ok(a) = archive.by_name::<OwnedRepr<u64>, Ix1>(&file) {
            Values::U64(a.into_raw_vec_and_offset().0)
        } else if let Ok(a) = archive.by_name::<OwnedRepr<u8>, Ix1>(&file) {
            Values::U8(a.into_raw_vec_and_offset().0)
        } else {
            bail!("{}: `{name}` is truncated or of an unknown type", broken());
        };
        state.arrays.insert(name, values);
    }
    Ok(state)
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
