//! The same bytes for 1 and 2 threads, and across a kill or Ctrl-C followed by `--resume`.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

const RD: &[&str] = &["rd", "--spots", "--size", "96", "--iterations", "6000"];
const LEVEL_SET: &[&str] =
    &["level-set", "--size", "256", "--iterations", "100", "--animation", "apng"];

const TOPOPT: &[&str] =
    &["topopt", "--mbb", "150x50", "--filter-radius", "3", "--solver", "multigrid"];

const ATLAS: &[&str] = &[
    "curvature",
    "atlas",
    "--count",
    "12",
    "--size",
    "16",
    "--evaluations",
    "60",
    "--cluster",
    "3",
    "--pictures",
    "2",
];

fn patterns(args: &[&str], out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    command.args(args).arg("--out").arg(out).args(more);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn ok(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// All files of a folder but the timings, which differ from run to run.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.file_name() != "timing.json" {
            files.insert(entry.file_name().into(), fs::read(entry.path()).unwrap());
        }
    }
    files
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (bytes(a), bytes(b));
    assert!(a.len() > 3, "{:?}", a.keys());
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, content) in &a {
        assert!(*content == b[name], "{} differs", name.display());
    }
}

/// Starts a run and waits until its first checkpoint is there.
fn start_and_wait(args: &[&str], out: &Path, every: &str) -> std::process::Child {
    let mut child = patterns(args, out, &["--checkpoint-every", every]).spawn().unwrap();
    let started = Instant::now();
    while !out.join("checkpoint.npz").exists() {
        assert!(child.try_wait().unwrap().is_none(), "the run ended before its first checkpoint");
        assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint within a minute");
        sleep(Duration::from_millis(1));
    }
    child
}

fn resume(out: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_patterns"));
    ok(&command.args(["run", "--resume"]).arg(out).output().unwrap());
    assert!(!out.join("checkpoint.npz").exists());
}

#[test]
fn one_and_two_threads_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for (n, args) in [RD, LEVEL_SET, TOPOPT, ATLAS].into_iter().enumerate() {
        let [one, two] = ["1", "2"].map(|threads| {
            let out = folder.path().join(format!("{n}-{threads}"));
            ok(&patterns(args, &out, &["--threads", threads]).output().unwrap());
            out
        });
        assert_same(&one, &two);
    }
}

#[test]
fn a_killed_run_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let runs = [(RD, "700"), (LEVEL_SET, "7"), (TOPOPT, "9"), (ATLAS, "1")];
    for (n, (args, every)) in runs.into_iter().enumerate() {
        let whole = folder.path().join(format!("whole-{n}"));
        ok(&patterns(args, &whole, &[]).output().unwrap());
        let killed = folder.path().join(format!("killed-{n}"));
        let mut child = start_and_wait(args, &killed, every);
        child.kill().unwrap(); // SIGKILL on Unix
        child.wait().unwrap();
        let status = fs::read_to_string(killed.join("run.json")).unwrap();
        assert!(status.contains("\"running\""), "{status}");
        resume(&killed);
        assert_same(&whole, &killed);
    }
    assert!(
        fs::read(folder.path().join("whole-1/animation.apng")).unwrap().starts_with(b"\x89PNG")
    );
}

#[cfg(unix)]
#[test]
fn ctrl_c_saves_and_says_how_to_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    ok(&patterns(RD, &whole, &[]).output().unwrap());
    let stopped = folder.path().join("stopped");
    let child = start_and_wait(RD, &stopped, "300");
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains(&format!("patterns run --resume {}", stopped.display())), "{said}");
    resume(&stopped);
    assert_same(&whole, &stopped);
}
