#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::{design::Design, simp::Evaluator, update::Functions, *};
use crate::NoInputs;

fn context() -> Context<'static> {
    Context { seed: 0, inputs: &NoInputs, memory: 1 << 33 }
}

/// A problem of the database with other settings.
fn table(name: &str, settings: &str) -> toml::Table {
    let mut table: toml::Table = settings.parse().unwrap();
    table.insert("table".into(), toml::Value::String(name.into()));
    database::expand(&table).unwrap()
}

/// Runs to the end.
fn run(table: &toml::Table) -> Box<dyn Run> {
    let mut run = start(table, &context()).unwrap();
    while run.step().unwrap() == Status::Running {}
    run
}

fn metric(run: &dyn Run, name: &str) -> f64 {
    run.metrics().into_iter().find(|metric| metric.name == name).unwrap().value
}

/// The printed compliance and the number of iterations.
fn printed(name: &str, settings: &str) -> (String, u64) {
    let run = run(&table(name, settings));
    let value = run.observe()[0].value;
    println!("{name} {settings:?}: {value:.4} after {} iterations", run.iterations());
    (format!("{value:.4}"), run.iterations())
}

/// Octave's figures with the originals (Sigmund 2001; Andreassen et al. 2011), to all
/// printed digits, with the same number of iterations.
#[test]
fn the_originals_digit_by_digit() {
    let expected = [
        ("row-a", "", "203.3061", 94),
        ("mbb", "", "203.1925", 94),
        ("mbb", "filter = 'density'", "218.8032", 127),
        ("cantilever", "", "57.3492", 71),
        ("row-c", "", "47.4605", 33),
        ("row-c", "rules = '88'\ninterpolation = 'modified'", "47.4410", 33),
        ("row-l", "volume = 0.4\nfilter_radius = 1.2", "61.2880", 76),
        ("row-h", "", "22.2650", 17),
        ("row-l", "", "50.4218", 29),
        ("row-d", "", "9.5551", 19),
        ("row-f", "", "23.6862", 26),
        ("row-p", "", "6.3028", 20),
        // From here to row n by a port of the 99 lines in scipy, run on the same problems.
        ("row-b", "", "197.9515", 69),
        ("row-e", "", "104.0407", 65),
        ("row-g", "", "23.2509", 47),
        ("row-i", "", "190.6529", 52),
        ("row-j", "", "29.4459", 63),
        ("row-k", "", "19.9276", 60),
        ("row-m", "", "48.8582", 44),
        ("row-q", "", "112.8361", 21),
        ("row-n", "", "10.5339", 221),
        ("row-l", "one_case = true", "17.0364", 53),
        // The 99 lines' third example: a hole, and the load at the corner.
        ("row-p", "problem.load = [{ node = [46, 31], force = [0.0, 1.0] }]", "52.1080", 34),
        ("row-h", "one_case = true\nrules = '88'\ninterpolation = 'modified'", "5.0960", 37),
    ];
    for (name, settings, value, iterations) in expected {
        assert_eq!(printed(name, settings), (value.to_owned(), iterations), "{name} {settings}");
    }
}

/// top88(300, 100, 0.5, 3, 4, 1) after 50 iterations, by both solvers. With the tolerance that
/// follows the change of the design the iterative one prints 198.4737.
#[test]
fn a_large_beam_as_by_the_88_lines() {
    let settings = "filter_radius = 4.0\niterations = 50\nproblem.elements = [300, 100]\n\
        problem.support = [{ edge = 'left', fix = 'x' }, { node = [301, 101], fix = 'y' }]";
    for solver in ["solver = 'direct'", "solver = 'multigrid'\nsolver_tolerance = 1e-9"] {
        let (value, _) = printed("mbb", &format!("{solver}\n{settings}"));
        assert_eq!(value, "198.4735", "{solver}");
    }
}

/// The first compliances that Octave prints: they pin the analysis before any update.
#[test]
fn the_first_compliances() {
    for (name, expected) in [
        ("row-a", "1007.0221"),
        ("row-c", "219.7673"),
        ("row-d", "49.9480"),
        ("row-f", "111.5320"),
        ("row-h", "93.9507"),
        ("row-l", "228.0925"),
        ("row-p", "45.2751"),
        ("cantilever", "429.2330"),
    ] {
        let found = printed(name, "iterations = 1");
        assert_eq!(found, (expected.to_owned(), 1), "{name}");
    }
}

/// The exponent rises to its end before a run may stop, and starts where it should: the first
/// compliance is that of the start's exponent.
#[test]
fn the_penalization_rises() {
    let rising = "penalization_start = 1.0\npenalization_step = 1.0\npenalization_every = 7\n\
                  filter = 'density'";
    let first = |settings: &str| printed("mbb", &format!("iterations = 1\n{settings}"));
    assert_eq!(first(rising), first("penalization = 1.0\nfilter = 'density'"));
    let mut rises = start(&table("mbb", rising), &context()).unwrap();
    let mut constant = start(&table("mbb", "filter = 'density'"), &context()).unwrap();
    let mut compliances = Vec::new();
    while rises.step().unwrap() == Status::Running {
        compliances.push(rises.observe()[0].value);
    }
    while constant.step().unwrap() == Status::Running {}
    // A higher exponent makes the same grey softer: steps after 7 and 14 iterations.
    for at in [7, 14] {
        assert!(compliances[at] > 1.05 * compliances[at - 1], "{at}: {compliances:?}");
    }
    let (last, wanted) = (metric(rises.as_ref(), "compliance_final"), 218.8);
    println!("rising {last:.4} after {}, constant 218.8032", rises.iterations());
    assert!((last / wanted - 1.0).abs() < 0.02, "{last}");
    // A tolerance that everything meets: two rises and one more iteration.
    let quick = run(&table("mbb", &format!("tolerance = 1.0\n{rising}")));
    assert_eq!(quick.iterations(), 3);
}

/// Both methods on one yardstick: exactly half of the elements solid, void 1e-9. The digest's
/// figures of SIMP are 43.877 and 189.476; its level set reached 45.119 and 196.503.
#[test]
fn the_front_reaches_simp() {
    for (name, simp, front) in [("row-c", 43.8772, 45.119), ("row-a", 189.4757, 196.503)] {
        let found = metric(run(&table(name, "")).as_ref(), "compliance_thresholded");
        assert!((found - simp).abs() < 6e-5, "{name}: SIMP {found}");
        let by_front = run(&table(name, "method = 'level-set'"));
        let found = metric(by_front.as_ref(), "compliance_thresholded");
        let volume = metric(by_front.as_ref(), "volume");
        let n = by_front.iterations();
        println!("{name}: level set {found:.3}, volume {volume:.4}, after {n}; SIMP {simp}");
        assert!(found <= front, "{name}: level set {found}");
        assert!((volume - 0.5).abs() < 1e-3, "{name}: volume {volume}");
    }
}

fn refusal(name: &str, settings: &str) -> String {
    match start(&table(name, settings), &context()) {
        Ok(_) => panic!("{name} {settings} was not refused"),
        Err(error) => error.to_string(),
    }
}

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

/// The digest's value for row k at x = 0.5, whichever node is pinned.
#[test]
fn a_free_motion_without_work_changes_nothing() {
    let mut run = start(&table("row-k", "one_case = true"), &context()).unwrap();
    run.step().unwrap();
    let value = run.observe()[0].value;
    assert!((value - 49.265_378).abs() < 5e-7, "{value}");
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

/// Gradients by the design variables against central differences.
#[test]
fn gradients_agree_with_differences() {
    let project = "projection = { beta = 4.0, beta_max = 4.0, delta = 0.2 }";
    let mma = "optimizer = 'mma'";
    let cases = [
        ("mbb", "filter = 'density'".to_owned()),
        ("mbb", format!("filter = 'helmholtz'\n{mma}\n{project}")),
        ("mbb", "filter = 'none'\ninterpolation = 'ramp'".to_owned()),
        ("mbb", "problem.body_force = [0.01, 0.02]\nfilter = 'density'".to_owned()),
        (
            "cantilever",
            "problem.support = [{ edge = 'left' }, { node = [33, 1], fix = 'y', value = [0.0, 0.5] }]\n\
             filter = 'density'"
                .to_owned(),
        ),
        ("row-h", format!("filter = 'density'\ncases = 'worst'\n{mma}")),
        ("force-inverter", "filter = 'density'".to_owned()),
        ("heat-sink", "filter = 'density'".to_owned()),
        ("l-bracket", format!("objective = 'stress'\n{mma}")),
        ("cantilever", "filter = 'density'\nproblem.symmetry = ['y']".to_owned()),
        ("row-h", "filter = 'helmholtz'\nproblem.symmetry = ['x', 'y']".to_owned()),
        (
            "mbb",
            format!(
                "filter = 'density'\nproblem.symmetry = ['x']\n{mma}\n\
                 projection = {{ beta = 2.0 }}\n\
                 problem.passive = [{{ box = [[5.0, 5.0], [9.0, 9.0]], material = 'solid' }}]"
            ),
        ),
        (
            "cantilever-3d",
            "filter = 'density'\nproblem.elements = [6, 4, 3]\n\
            problem.load = [{ nodes = [[7, 5, 1], [7, 5, 4]], force = [0.0, 1.0, 0.5] }]"
                .to_owned(),
        ),
    ];
    for (name, settings) in &cases {
        let config: Config = crate::from_table(&table(name, settings)).unwrap();
        let problem = Problem::new(&config, &context()).unwrap();
        let solver = LinearSolver::new(&problem.system, Choice::Direct, 1 << 33).unwrap();
        let mut analysis = Analysis::new(&problem, solver);
        let mut design = Design::new(&config, &problem).unwrap();
        let n = problem.grid.len();
        let mut rho = vec![0.0; n];
        let beta = config.projection.map_or(0.0, |projection| projection.beta);
        let count = simp::groups(&config, &problem);
        let law = Law::new(&config, config.penalization);
        let mut at = |x: &[f64]| {
            let (analysis, design, rho) = (&mut analysis, &mut design, &mut rho[..]);
            let (config, problem, tolerance) = (&config, &problem, 1e-10);
            let mut functions = Functions::new(count, n);
            Evaluator { config, problem, analysis, design, law, beta, tolerance, rho }
                .evaluate(x, &mut functions)
                .unwrap();
            functions
        };
        let mut x: Vec<f64> =
            (0..n).map(|e| 0.3 + 0.4 * ((e * 7919 % 101) as f64 / 101.0)).collect();
        for (e, x) in x.iter_mut().enumerate().filter(|(e, _)| problem.passive[*e].is_some()) {
            *x = f64::from(u8::from(problem.passive[e] == Some(Material::Solid)));
        }
        problem.symmetrize(&mut x);
        let functions = at(&x);
        let free: Vec<usize> = (0..n).filter(|&e| problem.passive[e].is_none()).collect();
        for &e in &[free[0], free[free.len() / 2], free[free.len() / 3]] {
            // Fourth order: at the second either round-off or the next term is too large.
            const STEP: f64 = 1e-4;
            // Along a direction as symmetric as the designs: shares that add up to 1.
            let mut along = vec![0.0; n];
            along[e] = 1.0;
            problem.symmetrize(&mut along);
            let mut moved = |step: f64| {
                let x: Vec<f64> = x.iter().zip(&along).map(|(x, d)| x + step * d).collect();
                at(&x)
            };
            let points = [-2.0, -1.0, 1.0, 2.0].map(|n| moved(n * STEP));
            for (k, (value, gradient)) in functions.objectives.iter().enumerate() {
                let [a, b, c, d] = points.each_ref().map(|point| point.objectives[k].0);
                let difference = (8.0 * (c - b) - (d - a)) / (12.0 * STEP);
                let scale = gradient.iter().fold(value.abs() * 1e-6, |a, g| a.max(g.abs()));
                let error = (difference - gradient[e]).abs() / scale;
                assert!(error < 2e-6, "{name} {settings}: {difference} {}", gradient[e]);
            }
        }
    }
}

/// A robust inverter's objectives are negative: the worst of them must go on falling.
#[test]
fn a_robust_mechanism_moves() {
    let settings = "optimizer = 'mma'\nfilter = 'density'\niterations = 60\n\
                    projection = { beta_max = 4.0, every = 20, delta = 0.1 }";
    let run = run(&table("force-inverter", settings));
    let found = run.observe()[0].value;
    println!("robust inverter: worst output {found:.4} after {}", run.iterations());
    assert!(found < -0.3, "{found}");
}

/// What the front makes small is all that it makes small; sources of heat everywhere leave it
/// nothing to move.
#[test]
fn the_front_refuses_other_objectives() {
    for (name, settings) in [
        ("force-inverter", ""),
        ("row-h", "cases = 'worst'"),
        ("row-c", "objective = 'stress'"),
        ("heat-sink", ""),
    ] {
        let message = refusal(name, &format!("method = 'level-set'\n{settings}"));
        assert!(message.contains("take `--method simp`"), "{message}");
    }
}

/// What the front takes for the worth of solid is minus the derivative of the compliances
/// by the density, with weight, springs, prescribed displacements, several cases and heat.
#[test]
fn the_worth_of_solid_agrees_with_differences() {
    for (name, settings) in [
        ("mbb", "problem.body_force = [0.01, 0.02]"),
        ("cantilever", "problem.spring = [{ node = [33, 1], stiffness = [0.1, 0.3] }]"),
        (
            "cantilever",
            "problem.support = [{ edge = 'left' }, { node = [33, 1], fix = 'y', value = [0.0, 0.5] }]",
        ),
        ("row-h", "problem.case_weights = [1.0, 3.0]"),
        ("heat-sink", ""),
        ("cantilever-3d", "problem.body_force = [0.0, 0.1, 0.0]"),
    ] {
        let config: Config = crate::from_table(&table(name, settings)).unwrap();
        let problem = Problem::new(&config, &context()).unwrap();
        let solver = LinearSolver::new(&problem.system, Choice::Direct, 1 << 33).unwrap();
        let mut analysis = Analysis::new(&problem, solver);
        let mut rho = vec![1.0; problem.grid.len()];
        let mut compliance = |rho: &[f64]| {
            analysis.solve(&problem, rho, Law::linear(VOID), 1e-10).unwrap();
            analysis.compliances(&problem, rho)
        };
        const STEP: f64 = 1e-4;
        let elements = [7, rho.len() / 2, rho.len() - 40];
        let differences = elements.map(|e| {
            let mut moved = |step: f64| {
                rho[e] += step;
                let value = compliance(&rho);
                rho[e] = 1.0;
                value
            };
            (moved(-STEP) - moved(STEP)) / (2.0 * STEP)
        });
        compliance(&rho);
        let mut worth = vec![0.0; rho.len()];
        analysis.worth(&problem, &mut worth);
        let scale = worth.iter().fold(0.0_f64, |a, w| a.max(w.abs()));
        for (e, difference) in elements.into_iter().zip(differences) {
            let error = (difference - worth[e]).abs() / scale;
            assert!(error < 1e-6, "{name} {settings}: {difference} {}", worth[e]);
        }
    }
}

/// The front with weight, springs, prescribed displacements, fixed material, several cases and
/// heat, beside densities on the same yardstick. It may rest in another local optimum: row l's
/// is 22 % above.
#[test]
fn the_front_knows_every_compliance() {
    for (name, settings) in [
        ("mbb", "problem.body_force = [0.0, 0.002]\noptimizer = 'mma'"),
        ("cantilever", "problem.spring = [{ node = [33, 1], stiffness = [0.0, 0.1] }]"),
        (
            "cantilever",
            "problem.support = [{ edge = 'left' }, \
             { node = [33, 1], fix = 'y', value = [0.0, 5.0] }]\noptimizer = 'mma'",
        ),
        ("row-p", "problem.load = [{ node = [46, 31], force = [0.0, 1.0] }]"),
        ("row-l", ""),
        ("heat-sink", "problem.load = [{ nodes = [[61, 1], [61, 5]], force = [1.0] }]"),
    ] {
        let run_of = |method: &str| run(&table(name, &format!("{settings}\n{method}")));
        let simp = metric(run_of("").as_ref(), "compliance_thresholded");
        let front = run_of("method = 'level-set'");
        let found = metric(front.as_ref(), "compliance_thresholded");
        let volume = metric(front.as_ref(), "volume");
        let n = front.iterations();
        println!("{name} {settings}: front {found:.4} after {n}, SIMP {simp:.4}, {volume:.4}");
        assert!(found < simp + 0.25 * simp.abs(), "{name} {settings}: {found}, SIMP {simp}");
    }
}

/// A front in space: symmetric as its problem is, at the volume, and much stiffer than the
/// grey box of that volume that SIMP starts from. It ends 10 % above SIMP after these 150
/// iterations, and 7 % after 1000.
#[test]
fn a_front_in_space() {
    let small = "problem.elements = [16, 8, 6]\n\
        problem.load = [{ nodes = [[17, 9, 1], [17, 9, 7]], force = [0.0, 1.0, 0.0] }]";
    let settings = "method = 'level-set'\niterations = 150\nproblem.symmetry = ['z']";
    let front = run(&table("cantilever-3d", &format!("{small}\n{settings}")));
    let simp = run(&table("cantilever-3d", small));
    let black = |run: &dyn Run| metric(run, "compliance_thresholded");
    let (found, by_simp) = (black(front.as_ref()), black(simp.as_ref()));
    let mut grey = start(&table("cantilever-3d", small), &context()).unwrap();
    grey.step().unwrap();
    let grey = grey.observe()[0].value;
    let config: Config = crate::from_table(&table("cantilever-3d", small)).unwrap();
    let volume = metric(front.as_ref(), "volume");
    println!("front {found:.4} after {}, SIMP {by_simp:.4}, grey {grey:.4}", front.iterations());
    assert!((volume - config.volume).abs() < 5e-3, "{volume}");
    assert!(found < 0.5 * grey && found < 1.15 * by_simp, "{found}");
    let rho = front.artifacts().into_iter().find_map(|artifact| match artifact {
        Artifact::Image(image) if image.name == "density" => Some(image.field),
        _ => None,
    });
    let rho = rho.unwrap();
    for k in 0..6 {
        for e in 0..16 * 8 {
            let pair = [k, 5 - k].map(|k| rho.as_slice()[k * 16 * 8 + e]);
            assert_eq!(pair[0], pair[1], "plane {k}, element {e}");
        }
    }
}

/// The topological derivative foretells what a small round hole costs a plate under uniform
/// stresses `s1`, `s2`: Kirsch's hole, up to the finite plate, which costs some (radius / width)^2
/// (2.3 % here, 7.8 % and 12.9 % for a radius of 12 and 16 elements).
#[test]
fn a_hole_costs_what_its_derivative_says() {
    let cost = |s1: f64, s2: f64| {
        let settings = "problem.elements = [160, 160]\n\
            problem.load = [{ node = [81, 81], force = [0.0, 1.0] }]\n\
            problem.support = [{ node = [1, 1] }]";
        let config: Config = crate::from_table(&table("row-c", settings)).unwrap();
        // The written load gives way to tractions on all four sides, in equilibrium.
        let mut problem = Problem::new(&config, &context()).unwrap();
        let lattice = problem.system.lattice();
        let mut force = vec![0.0; problem.system.unknowns()];
        for n in 0..=160 {
            let share = if n == 0 || n == 160 { 0.5 } else { 1.0 };
            force[2 * lattice.node([160, n, 0])] += share * s1;
            force[2 * lattice.node([0, n, 0])] -= share * s1;
            force[2 * lattice.node([n, 160, 0]) + 1] += share * s2;
            force[2 * lattice.node([n, 0, 0]) + 1] -= share * s2;
        }
        problem.cases = vec![(1.0, force)];
        mechanism::hold(&mut problem).unwrap();
        let solver = LinearSolver::new(&problem.system, Choice::Direct, 1 << 33).unwrap();
        let mut analysis = Analysis::new(&problem, solver);
        let full = vec![1.0; problem.grid.len()];
        let mut holed = full.clone();
        for (e, x) in holed.iter_mut().enumerate() {
            let [cx, cy, _] = problem.grid.position(e).map(|x| x + 0.5 - 80.0);
            *x = f64::from(u8::from(cx.hypot(cy) > 8.0));
        }
        let after = analysis.black_and_white(&problem, &holed).unwrap();
        let before = analysis.black_and_white(&problem, &full).unwrap();
        let mut derivative = vec![0.0; full.len()];
        front::topological_derivative(&problem, &analysis, &mut derivative);
        (after - before, derivative[80 * 160 + 80])
    };
    let (even, even_says) = cost(1.0, 1.0);
    for (s1, s2) in [(1.0, -1.0), (1.0, 0.0), (1.0, 0.5)] {
        let (found, says) = cost(s1, s2);
        let ratio = found / even / (says / even_says);
        println!("stresses {s1}, {s2}: {found:.2} {says:.3}, ratio {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.03, "stresses {s1}, {s2}: {ratio}");
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

/// MMA ends where the optimality criteria do, within half a percent. GCMMA, whose steps are
/// shorter, comes to rest in another local optimum of the cantilever (3.5 % above); so does
/// the published program, a port of which ends at 62.92 and, moved by at most 0.2, at 63.73.
#[test]
fn the_optimizers_agree() {
    for name in ["mbb", "cantilever"] {
        let base =
            "rules = '88'\ninterpolation = 'modified'\nfilter = 'density'\niterations = 200\n";
        let oc = metric(run(&table(name, base)).as_ref(), "compliance_final");
        for (method, above) in [("mma", 1.005), ("gcmma", 1.05)] {
            let by = run(&table(name, &format!("{base}optimizer = '{method}'")));
            let found = metric(by.as_ref(), "compliance_final");
            println!("{name}: oc {oc:.4}, {method} {found:.4} after {}", by.iterations());
            assert!(found < above * oc, "{name}: {method} {found}, oc {oc}");
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

/// Half way, saved and taken up again: the same bytes.
#[test]
fn runs_resume_to_the_same_bytes() {
    for (name, settings) in [
        ("mbb", ""),
        ("mbb", "optimizer = 'mma'\nfilter = 'density'"),
        ("mbb", "method = 'level-set'"),
        ("mbb", "penalization_start = 1.0\npenalization_every = 4"),
        ("force-inverter", "solver = 'multigrid'"),
    ] {
        let table = table(name, settings);
        let mut whole = start(&table, &context()).unwrap();
        let mut half = start(&table, &context()).unwrap();
        for _ in 0..6 {
            whole.step().unwrap();
            half.step().unwrap();
        }
        let mut resumed = start(&table, &context()).unwrap();
        resumed.restore(&half.save()).unwrap();
        for _ in 0..6 {
            whole.step().unwrap();
            resumed.step().unwrap();
        }
        assert_eq!(whole.save(), resumed.save(), "{name} {settings}");
    }
}
