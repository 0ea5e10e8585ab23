//! `patterns database`: what it prints, and a class of one's own.

use std::{path::Path, process::Command};

fn patterns(folder: &Path, args: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    let output = command.current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn classes_are_listed_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let list = patterns(folder.path(), &["database", "list"]);
    assert!(list.lines().count() >= 12 && list.contains("topology-row-c"), "{list}");
    let class = patterns(folder.path(), &["database", "show", "turing-spots"]);
    for word in ["model rd", "by statistics", "parameters.xi", "[11.8, 12.4]"] {
        assert!(class.contains(word), "`{word}` is not in: {class}");
    }
}

#[test]
fn a_class_without_chance_is_added_by_its_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let entry = "name = \"my-beam\"\nabout = \"Short cantilever\"\nmodel = \"topopt\"\n\
                 seeds = \"fixed\"\n[config]\ntable = \"cantilever\"\niterations = 5\n\
                 [range]\nvolume = { low = 0.3, high = 0.5 }\n";
    std::fs::write(folder.path().join("my-beam.toml"), entry).unwrap();
    patterns(folder.path(), &["database", "add", "my-beam.toml", "--to", "mine"]);
    let list = patterns(folder.path(), &["database", "list", "--database", "mine"]);
    assert!(list.lines().last().unwrap().contains("my-beam"), "{list}");
    let shown = ["database", "show", "my-beam", "--database", "mine"];
    assert!(patterns(folder.path(), &shown).contains("pixel by pixel"));
}
