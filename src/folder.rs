//! The output folder: found, made, filled by whole files, and taken away again after a failure.

use anyhow::{Context as _, Result, bail};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// An output folder that this run may write to.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// The outermost folder that this run made; taken away again if the run fails early.
    made: Option<PathBuf>,
    written: Vec<String>,
}

impl Folder {
    /// Makes `out`, or the first free `out/<command>-<n>`.
    ///
    /// # Errors
    /// If `out` is there and not empty (unless `force`), or cannot be made or written to.
    pub fn create(out: Option<&Path>, command: &str, force: bool) -> Result<Self> {
        let path = match out {
            Some(path) => path.to_path_buf(),
            None => first_free(command),
        };
        if path.is_file() {
            bail!("--out {}: there is a file of that name, expected a folder", path.display());
        }
        let occupied = path.is_dir() && fs::read_dir(&path).is_ok_and(|mut d| d.next().is_some());
        if occupied && !force {
            bail!("--out {}: the folder is not empty; --force overwrites it", path.display());
        }
        let made = outermost_missing(&path);
        let folder = Self { path, made, written: Vec::new() };
        let probe = folder.path.join(".patterns-probe.partial");
        let made = fs::create_dir_all(&folder.path).and_then(|()| fs::write(&probe, b"writable"));
        if let Err(error) = made {
            let message = format!("cannot write to the output folder `{}`", folder.path.display());
            folder.discard();
            return Err(error).context(message);
        }
        fs::remove_file(&probe).with_context(|| format!("cannot remove `{}`", probe.display()))?;
        if occupied {
            folder.remove_old_run();
        }
        Ok(folder)
    }

    /// Opens the folder of an earlier run.
    pub fn open(path: &Path) -> Self {
        Self { path: path.to_path_buf(), made: None, written: Vec::new() }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files written so far, relative to the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let mut files = self.written.clone();
        files.sort();
        files.dedup();
        files
    }

    /// Writes a whole file under a temporary name, then renames it.
    ///
    /// # Errors
    /// If the disk refuses; the temporary file is removed.
    pub fn write(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.path.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)
                .with_context(|| format!("cannot make the folder `{}`", parent.display()))?;
        }
        crate::output::save_bytes(&path, bytes)?;
        self.written.push(name.into());
        Ok(())
    }

    /// Writes a file that the manifest does not list.
    ///
    /// # Errors
    /// As [`Folder::write`].
    pub fn write_hidden(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        crate::output::save_bytes(&self.path.join(name), bytes)
    }

    /// Counts the files of an earlier part of the run among this run's.
    pub fn adopt(&mut self, files: &[String]) {
        self.written.extend_from_slice(files);
    }

    /// Removes a file if it is there.
    pub fn remove(&mut self, name: &str) {
        // A checkpoint that cannot be removed is harmless: the manifest says "done".
        let _ = fs::remove_file(self.path.join(name));
        self.written.retain(|written| written != name);
    }

    /// Takes away what this run wrote, and the folders that it made.
    pub fn discard(self) {
        for name in &self.written {
            let _ = fs::remove_file(self.path.join(name));
        }
        if let Some(made) = self.made {
            let _ = fs::remove_dir_all(made);
        }
    }

    /// With `--force`: the files that the old manifest lists go, others stay.
    fn remove_old_run(&self) {
        let old = fs::read_to_string(self.path.join("run.json"));
        let Some(old) = old.ok().and_then(|text| crate::manifest::Manifest::parse(&text).ok())
        else {
            return;
        };
        let plain = |name: &&String| {
            Path::new(name).components().all(|c| matches!(c, std::path::Component::Normal(_)))
        };
        for name in old.files.iter().filter(plain) {
            let _ = fs::remove_file(self.path.join(name));
        }
        let _ = fs::remove_file(self.path.join("run.json"));
        let _ = fs::remove_file(self.path.join(crate::checkpoint::FILE));
    }
}

fn first_free(command: &str) -> PathBuf {
    let mut n = 1_u64;
    loop {
        let path = Path::new("out").join(format!("{command}-{n}"));
        if !path.exists() {
            return path;
        }
        n += 1;
    }
}

fn outermost_missing(path: &Path) -> Option<PathBuf> {
    path.ancestors()
        .filter(|a| !a.as_os_str().is_empty())
        .take_while(|a| !a.exists())
        .last()
        .map(Path::to_path_buf)
}
