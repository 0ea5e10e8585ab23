//! Continuation, optimizers, checkpoints.

use super::*;

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
