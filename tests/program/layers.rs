//! Models may use `solvers` and `crate::{Error, Run, ...}`, never each other; disocclusion, which
//! runs them, stands above.

use std::{
    fs,
    path::{Path, PathBuf},
};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    files.into_iter().chain(folders.iter().flat_map(|f| sources(f))).collect()
}

#[test]
fn models_do_not_import_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("patterns/src");
    let folders = fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path());
    let models: Vec<_> = folders.filter(|path| path.is_dir()).collect();
    assert!(!models.is_empty());
    // Disocclusion runs the others and holds what is seen in them: it alone may use them.
    for model in models.iter().filter(|model| !model.ends_with("disocclusion")) {
        for file in sources(model) {
            let source = fs::read_to_string(&file).unwrap();
            for other in models.iter().filter(|other| *other != model) {
                let import = format!("crate::{}::", other.file_name().unwrap().display());
                assert!(!source.contains(&import), "{} uses {import}", file.display());
            }
        }
    }
}

#[test]
fn solvers_know_no_pattern() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("solvers");
    for file in sources(&root.join("src")).into_iter().chain([root.join("Cargo.toml")]) {
        let source = fs::read_to_string(&file).unwrap();
        assert!(!source.contains("use patterns"), "{} uses the models", file.display());
        assert!(!source.contains("patterns.workspace"), "{} uses the models", file.display());
    }
}
