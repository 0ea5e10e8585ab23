//! Problems: what is refused, what is symmetric, what the database holds.

use super::*;

/// Rows d, f, g as printed turn about the lower right corner; with the pin they run.
#[test]
fn mechanisms_are_refused_with_their_motion() {
    for (name, pivot) in [("row-d", "(33, 21)"), ("row-f", "(61, 21)"), ("row-g", "(61, 21)")] {
        let message = refusal(name, "as_printed = true");
        assert!(message.contains(&format!("rotate about node {pivot}")), "{message}");
        assert!(message.contains("support y at one more node, e.g. (1, 21)"), "{message}");
        assert!(start(&table(name, ""), &context()).is_ok(), "{name} as interpreted");
    }
    assert!(refusal("row-o", "").contains("which a support holds along y"));
    for name in ["row-k", "row-m"] {
        let run = start(&table(name, ""), &context()).unwrap();
        assert!(run.notes().iter().any(|note| note.contains("free to move along x")), "{name}");
    }
}

#[test]
fn bad_problems_are_refused() {
    let with = |settings: &str| refusal("row-c", settings);
    for (settings, wanted) in [
        ("volume = 1.0", "`volume`: 1 is outside its range (0, 1)"),
        ("volume = nan", "`volume`: NaN is outside"),
        ("filter_radius = 0.5", "`filter_radius`: 0.5 is outside its range [1, 1000]"),
        ("problem.load = []", "`problem.load`: there is none"),
        ("problem.support = []", "`problem.support`: there is none"),
        ("problem.load = [{ node = [33, 21], force = [0.0, nan] }]", "finite numbers"),
        ("problem.load = [{ node = [34, 21], force = [0.0, 1.0] }]", "lies outside the mesh"),
        (
            "problem.load = [{ node = [1, 21], force = [0.0, 1.0] }]",
            "which a support holds along y",
        ),
        ("problem.load = [{ force = [0.0, 1.0] }]", "exactly one of"),
        ("problem.passive = [{ circle = [99.0, 5.0, 3.0] }]", "outside the domain"),
        ("problem.passive = [{ box = [[0.0, 0.0], [32.0, 20.0]] }]", "nothing is left to design"),
        ("problem.elements = [0, 20]", "axis of 0 nodes"),
        ("problem.elements = [100000, 100000]", "GiB of memory"),
        ("problem.symmetry = ['z']", "`z` is no axis"),
        ("problem.poisson_ratio = 0.5", "`problem.poisson_ratio`: 0.5 is outside"),
        ("cases = 'worst'\nobjective = 'stress'", "`optimizer`: `oc` cannot make stresses small"),
        ("objective = 'displacement'", "`problem.output`"),
        ("projection = {}", "`projection`: a projection needs"),
        ("problem.case_weights = [1.0, 2.0]", "2 weights for 1 load cases"),
        (
            "penalization_start = 4.0",
            "`penalization_start`: 4 is outside its range [0, penalization]",
        ),
        ("penalization_step = 0.0", "`penalization_step`: 0 is outside its range (0, 20]"),
        ("penalization_every = 0", "`penalization_every`: 0 is outside its range [1, inf)"),
        ("solver_tolerance = 0.1", "`solver_tolerance`: 0.1 is outside its range [1e-12, 0.01]"),
        (
            "problem.symmetry = ['y']\nproblem.passive = [\
             { box = [[0.0, 0.0], [3.0, 3.0]], material = 'solid' }, \
             { box = [[0.0, 17.0], [3.0, 20.0]] }]",
            "mirror images of each other across y",
        ),
        ("typo = 1", "typo"),
    ] {
        let message = with(settings);
        assert!(message.contains(wanted), "{settings}: {message}");
    }
}

/// A factorization that would not fit is refused with its size, before any work.
#[test]
fn a_factor_that_does_not_fit_is_refused() {
    let direct = table(
        "cantilever-3d",
        "solver = 'direct'\nproblem.elements = [96, 48, 48]\n\
        problem.load = [{ node = [97, 49, 1], force = [0.0, 1.0, 0.0] }]",
    );
    let small = Context { memory: 2 << 30, ..context() };
    let message = start(&direct, &small).err().unwrap().to_string();
    assert!(message.contains("factor") && message.contains("GiB"), "{message}");
    // Ten million elements on a small machine.
    let large = "problem.elements = [4000, 2500]\n\
                 problem.load = [{ node = [4001, 2501], force = [0.0, 1.0] }]";
    let message = start(&table("row-c", large), &small).err().unwrap().to_string();
    assert!(message.contains("4000 x 2500") || message.contains("2500 x 4000"), "{message}");
    assert!(message.contains("GiB"), "{message}");
}

/// Every problem of the database starts (or is refused for its known reason) and steps.
#[test]
fn every_entry_of_the_database_works() {
    for preset in database::presets() {
        if preset.name == "row-o" {
            continue;
        }
        let mut run = start(&preset.config.parse().unwrap(), &context())
            .unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        run.step().unwrap_or_else(|error| panic!("{}: {error}", preset.name));
        let value = run.observe()[0].value;
        assert!(value.is_finite() && value != 0.0, "{}: {value}", preset.name);
        let files = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/database/topology"));
        if let Ok(files) = files {
            assert_eq!(files.count(), database::presets().len());
        }
    }
}

/// The problem's mirror image and its quarter turn have the same compliance.
#[test]
fn mirrors_and_turns_change_nothing() {
    let after = |table: &toml::Table| {
        let mut run = start(table, &context()).unwrap();
        for _ in 0..5 {
            run.step().unwrap();
        }
        run.observe()[0].value
    };
    let problem = |elements: &str, load: &str, force: &str, edge: &str| {
        let text = format!(
            "filter = 'density'\n[problem]\nelements = {elements}\n\
             load = [{{ node = {load}, force = {force} }}]\nsupport = [{{ edge = '{edge}' }}]"
        );
        after(&text.parse().unwrap())
    };
    let plain = problem("[16, 10]", "[17, 11]", "[0.0, 1.0]", "left");
    let mirrored = problem("[16, 10]", "[1, 11]", "[0.0, 1.0]", "right");
    let turned = problem("[10, 16]", "[1, 17]", "[-1.0, 0.0]", "top");
    assert!((plain - mirrored).abs() < 1e-9 * plain, "{plain} {mirrored}");
    assert!((plain - turned).abs() < 1e-9 * plain, "{plain} {turned}");
}
