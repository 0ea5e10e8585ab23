//! The conservative method, against the plain one and the literature.
#![expect(clippy::print_stdout, reason = "measured figures are for the reader of a test run")]

use super::*;

/// One outer iteration; the trials it took.
fn outer(gcmma: &mut Gcmma, problem: impl Fn(&[f64]) -> Values, x: &mut Vec<f64>) -> usize {
    let (f0, df0, g, dg) = problem(x);
    let mut trial = gcmma.propose(x, f0, &df0, &g, &dg).unwrap().to_vec();
    for trials in 1.. {
        let (f0, _, g, _) = problem(&trial);
        match gcmma.accept(f0, &g).unwrap() {
            Verdict::Tighten => trial = gcmma.trial().unwrap().to_vec(),
            verdict => {
                assert_eq!(verdict, Verdict::Accepted);
                *x = trial;
                return trials;
            }
        }
    }
    unreachable!()
}

fn standard(bounds: &Bounds, m: usize) -> Gcmma {
    Gcmma::new(bounds.clone(), Artificial::standard(m), GcmmaConfig::default()).unwrap()
}

#[test]
fn published_problems_are_solved() {
    for Known { name, problem, bounds, start, solution, optimum } in known() {
        let mut x = start;
        let mut gcmma = standard(&bounds, problem(&x).2.len());
        let (mut trials, mut within) = (0, 0);
        for k in 1..=40 {
            let feasible = problem(&x).2.iter().all(|g| *g <= 0.0);
            let before = problem(&x).0;
            trials += outer(&mut gcmma, problem, &mut x);
            if feasible {
                assert!(problem(&x).0 <= before + 1e-6, "{name} rises");
                assert!(problem(&x).2.iter().all(|g| *g <= 2e-7), "{name} leaves");
            }
            if within == 0 && distance(&x, solution) < 1e-3 {
                within = k;
            }
        }
        let (error, f0) = (distance(&x, solution), problem(&x).0);
        println!("{name}: 1e-3 after {within}; after 40 and {trials} trials {error:.1e}, {f0:.9}");
        assert!(error < 1e-4 && (f0 - optimum).abs() < 1e-7 && within < 20);
    }
}

/// Iterates 1, 2 and 4 of an independent implementation of the published constants.
#[test]
fn iterates_are_those_of_another_implementation() {
    let recorded: [[&[f64]; 3]; 3] = [
        [
            &[
                5.568393720716523,
                5.083547105660897,
                4.496633312368803,
                3.8307141905769373,
                3.2746057888888123,
            ],
            &[
                5.811575783860226,
                5.222888188938905,
                4.507970023976995,
                3.607115383718947,
                2.490799421800507,
            ],
            &[
                5.96570676971144,
                5.303649836321889,
                4.514427993936241,
                3.5313349543077144,
                2.160535500873168,
            ],
        ],
        [
            &[1.4090209485670218, 0.40143833446286753],
            &[1.4093570415608583, 0.3822824677688522],
            &[1.4115354836709815, 0.3772785301588768],
        ],
        [
            &[2.5550373138934246, 1.8906221016349385, 1.0765471105718696],
            &[2.072173511189885, 1.795876118030272, 1.1910268595772044],
            &[2.016950173974017, 1.7834788614405306, 1.23349570831353],
        ],
    ];
    for (Known { name, problem, bounds, start, .. }, recorded) in known().into_iter().zip(recorded)
    {
        let mut x = start;
        let mut gcmma = standard(&bounds, problem(&x).2.len());
        let mut worst = 0.0_f64;
        for k in 1..=4 {
            outer(&mut gcmma, problem, &mut x);
            if let Some(at) = [1, 2, 4].iter().position(|&recorded| recorded == k) {
                worst = worst.max(distance(&x, recorded[at]));
            }
        }
        println!("{name}: iterates differ by {worst:.1e}");
        assert!(worst < 1e-4, "{name}: {worst:e}");
    }
}

/// An optimum inside the box, where the approximations of the plain method have no curvature
/// of their own: it goes on jumping over the optimum.
#[test]
fn falls_where_the_plain_method_oscillates() {
    const N: usize = 20;
    let target = |j: usize| 0.2 + 0.03 * j as f64;
    let problem = |x: &[f64]| -> Values {
        let offset: Vec<f64> = x.iter().enumerate().map(|(j, x)| x - target(j)).collect();
        let f0 = 50.0 * offset.iter().map(|d| d * d).sum::<f64>();
        (f0, offset.iter().map(|d| 100.0 * d).collect(), vec![], vec![])
    };
    let bounds = Bounds::uniform(N, 0.0, 1.0).unwrap();
    let mut mma = Mma::new(bounds.clone(), Artificial::standard(0), MmaConfig::default()).unwrap();
    let (mut x, mut rises) = (vec![0.9; N], 0);
    for _ in 0..60 {
        let (f0, df0, ..) = problem(&x);
        x = mma.step(&x, f0, &df0, &[], &[]).unwrap().to_vec();
        rises += usize::from(problem(&x).0 > f0);
    }
    let plain = problem(&x).0;
    let mut gcmma = standard(&bounds, 0);
    let (mut x, mut trials) = (vec![0.9; N], 0);
    for _ in 0..60 {
        let before = problem(&x).0;
        trials += outer(&mut gcmma, problem, &mut x);
        assert!(problem(&x).0 <= before + 1e-7, "rises from {before}");
    }
    let left = problem(&x).0;
    println!("plain: {rises} rises, f0 {plain:.1e}; conservative: {trials} trials, f0 {left:.1e}");
    assert!(rises > 5 && left < 1e-6 && left < 1e-2 * plain);
}

#[test]
fn calls_out_of_order_are_refused() {
    let mut gcmma = standard(&Bounds::uniform(2, 0.0, 1.0).unwrap(), 0);
    assert!(gcmma.accept(0.0, &[]).unwrap_err().to_string().contains("propose first"));
    assert!(gcmma.trial().is_none());
    gcmma.propose(&[0.5; 2], 1.0, &[1.0, -1.0], &[], &[]).unwrap();
    let error = gcmma.propose(&[0.5; 2], 1.0, &[1.0, -1.0], &[], &[]).unwrap_err();
    assert!(error.to_string().contains("call accept"), "{error}");
    let error = gcmma.accept(f64::NAN, &[]).unwrap_err();
    assert_eq!(error.to_string(), "f0 is NaN, which is not finite");
    assert_eq!(gcmma.accept(-9.0, &[]).unwrap(), Verdict::Accepted);
}

#[test]
fn values_that_no_curvature_explains_exhaust_the_trials() {
    let mut gcmma = standard(&Bounds::uniform(2, 0.0, 1.0).unwrap(), 0);
    gcmma.propose(&[0.5; 2], 1.0, &[1.0, -1.0], &[], &[]).unwrap();
    let verdicts: Vec<Verdict> = (0..15).map(|_| gcmma.accept(1e9, &[]).unwrap()).collect();
    assert!(verdicts[..14].iter().all(|v| *v == Verdict::Tighten));
    assert_eq!(verdicts[14], Verdict::Exhausted);
    gcmma.propose(&[0.5; 2], 1.0, &[1.0, -1.0], &[], &[]).unwrap();
}
