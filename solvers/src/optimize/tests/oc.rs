//! Density updates, against recorded bits of a line-by-line port of the published programs.
#![expect(clippy::print_stdout, reason = "measured figures are for the reader of a test run")]

use super::*;

const N: usize = 12;
const TARGET: f64 = 0.4 * N as f64;

/// Densities and gradients that are short binary fractions.
fn data() -> [Vec<f64>; 3] {
    let fraction =
        |factor: usize, modulus: usize| move |k: usize| 1.0 + ((factor * k) % modulus) as f64;
    let x = (0..N).map(|k| fraction(7, 13)(k) / 16.0).collect();
    let dc = (0..N).map(|k| -fraction(11, 17)(k).powi(2) / 8.0).collect();
    [x, dc, (0..N).map(|k| fraction(5, 7)(k) / 4.0).collect()]
}

fn sum(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |sum, x| sum + x)
}

fn excess(x: &[f64]) -> f64 {
    sum(x) - TARGET
}

fn optimizer(bounds: Bounds, config: OcConfig) -> OptimalityCriteria {
    OptimalityCriteria::new(bounds, config).unwrap()
}

/// Checks densities, multiplier and bisections.
fn check(oc: &OptimalityCriteria, x: &[f64], recorded: [u64; N], last: u64, bisections: usize) {
    assert_eq!(bits(x), recorded);
    assert_eq!((oc.multiplier().to_bits(), oc.bisections()), (last, bisections));
}

#[test]
fn rules_of_99_lines_to_the_last_bit() {
    let [x, dc, _] = data();
    let mut oc = optimizer(Bounds::uniform(N, 0.001, 1.0).unwrap(), OcConfig::top99());
    let recorded = [
        0x3f7581095c785340,
        0x3fe020c7055a3e70,
        0x3fb020c7055a3e70,
        0x3fe8666666666666,
        0x3fc62d11a75c15d9,
        0x3fdb333333333333,
        0x3fd581095c785340,
        0x3fe27ae40b77678a,
        0x3fbccccccccccccc,
        0x3fee3d752a093510,
        0x3fd224dfe605863e,
        0x3fe399999999999a,
    ];
    let next = oc.update(&x, &dc, None, excess).unwrap().to_vec();
    check(&oc, &next, recorded, 0x4031b7206e800000, 30);
    let mut calls = 0;
    let counted = |x: &[f64]| {
        calls += 1;
        excess(x)
    };
    let next = oc.update_sum(&x, &dc, None, TARGET, counted).unwrap().to_vec();
    check(&oc, &next, recorded, 0x4031b7206e800000, 30);
    assert_eq!(calls, 0);
}

#[test]
fn passive_elements_of_99_lines_to_the_last_bit() {
    let [x, dc, _] = data();
    let mut bounds = Bounds::uniform(N, 0.001, 1.0).unwrap();
    bounds.fix(3, 0.001).unwrap();
    bounds.fix(5, 0.001).unwrap();
    let mut oc = optimizer(bounds, OcConfig::top99());
    let recorded = [
        0x3f84721796c210f9,
        0x3fe6666666666666,
        0x3fbeab2362231976,
        0x3f50624dd2f1a9fc,
        0x3fd515a853782181,
        0x3f50624dd2f1a9fc,
        0x3fdccccccccccccd,
        0x3fec666666666666,
        0x3fc98e9d7c729537,
        0x3fee666666666666,
        0x3fe14043e733be53,
        0x3fe399999999999a,
    ];
    let next = oc.update(&x, &dc, None, excess).unwrap().to_vec();
    check(&oc, &next, recorded, 0x401398cdc2000000, 30);
}

/// Physical densities: means of three neighbours, a void first and a solid last element.
#[test]
fn rules_of_88_lines_to_the_last_bit() {
    let [x, dc, dv] = data();
    let mut oc = optimizer(Bounds::uniform(N, 0.0, 1.0).unwrap(), OcConfig::top88());
    let recorded = [
        0x3f7e81080cedafe9,
        0x3fd3333333333333,
        0x3fa6e0c609b243ef,
        0x3fe8666666666666,
        0x3fb7c78b3fa437ef,
        0x3fdb333333333333,
        0x3fd19c8be16847e5,
        0x3fea36e2eb1c432d,
        0x3fbccccccccccccc,
        0x3fe572b9a9171fb0,
        0x3fd23308ec72d0f9,
        0x3fe399999999999a,
    ];
    let physical = |x: &[f64]| {
        let mean = |i: usize| (x[i.max(1) - 1] + x[i] + x[(i + 1).min(N - 1)]) / 3.0;
        let mut filtered: Vec<f64> = (0..N).map(mean).collect();
        (filtered[0], filtered[N - 1]) = (0.0, 1.0);
        excess(&filtered)
    };
    let next = oc.update(&x, &dc, Some(&dv), physical).unwrap().to_vec();
    check(&oc, &next, recorded, 0x40419b99ec400000, 34);
}

/// Some gradients are positive. Powers of two libraries may differ in the last bit.
#[test]
fn rules_for_mechanisms() {
    let [x, dc, _] = data();
    let dc: Vec<f64> = dc.iter().map(|dc| dc + 4.0).collect();
    let bounds = Bounds::uniform(N, 0.001, 1.0).unwrap();
    let mut oc = optimizer(bounds.clone(), OcConfig::mechanism());
    let recorded = [
        0x3f50624dd2f1a9fc_u64,
        0x3fde785105ae9e35,
        0x3fa66d1894c88f08,
        0x3fe5333333333333,
        0x3fc554686949a735,
        0x3fe0cccccccccccd,
        0x3fd2c1a875114f24,
        0x3fe2cccccccccccd,
        0x3fcb333333333333,
        0x3feae7b7775e73b7,
        0x3fd1d5464bdbbe82,
        0x3fe6cccccccccccd,
    ];
    let next = oc.update(&x, &dc, None, excess).unwrap().to_vec();
    let ulps = bits(&next).iter().zip(recorded).map(|(a, b)| a.abs_diff(b)).max();
    println!("mechanism: {ulps:?} units in the last place");
    assert!(ulps <= Some(1));
    assert_eq!((oc.multiplier().to_bits(), oc.bisections()), (0x40307bd170000000, 25));
    assert_eq!(oc.update_sum(&x, &dc, None, TARGET, excess).unwrap(), next);
    let strict = OcConfig { floor: None, ..OcConfig::mechanism() };
    let error = optimizer(bounds, strict).update(&x, &dc, None, excess).unwrap_err();
    assert_eq!(error.to_string(), "dc[0] = 3.875 is outside its range (-inf, 0]");
}

#[test]
fn sums_give_the_bytes_of_the_closure_on_any_number_of_threads() {
    let n = 30_000;
    let mut noise = noise(9);
    let mut random =
        |scale: f64, shift: f64| -> Vec<f64> { (0..n).map(|_| scale * noise() + shift).collect() };
    let (x, dc, dv) = (random(1.0, 0.0), random(-50.0, 0.0), random(1.0, 0.5));
    let mut bounds = Bounds::uniform(n, 0.0, 1.0).unwrap();
    (0..n).step_by(17).for_each(|j| bounds.fix(j, (j % 2) as f64).unwrap());
    let target = 0.45 * n as f64;
    for config in [OcConfig::top99(), OcConfig::top88(), OcConfig::mechanism()] {
        let mut oc = optimizer(bounds.clone(), config);
        let volume = |x: &[f64]| sum(x) - target;
        let plain = with_threads(1, || bits(oc.update(&x, &dc, Some(&dv), volume).unwrap()));
        let (multiplier, bisections) = (oc.multiplier(), oc.bisections());
        let mut calls = 0;
        let counted = |x: &[f64]| {
            calls += 1;
            sum(x) - target
        };
        let fast =
            with_threads(3, || bits(oc.update_sum(&x, &dc, Some(&dv), target, counted).unwrap()));
        let met = volume(oc.update(&x, &dc, Some(&dv), volume).unwrap());
        println!("{bisections} bisections, {calls} exact sums, volume met to {met:.1e} of {n}");
        assert!(fast == plain && multiplier == oc.multiplier() && bisections == oc.bisections());
        assert!(met.abs() < 1e-3 * target);
    }
}

#[test]
fn a_close_call_is_left_to_the_exact_sum() {
    let (x, dc) = (vec![0.5; 8], vec![-1.0; 8]);
    let config = OcConfig { greatest_multiplier: 2.0, ..OcConfig::top88() };
    let mut oc = optimizer(Bounds::uniform(8, 0.0, 1.0).unwrap(), config);
    // The first multiplier tried is 1, which leaves the densities as they are.
    let mut calls = 0;
    oc.update_sum(&x, &dc, None, 4.0, |x| {
        calls += 1;
        sum(x) - 4.0
    })
    .unwrap();
    assert_eq!(calls, 1);
}

#[test]
fn an_objective_without_slope_ends() {
    let mut oc = optimizer(Bounds::uniform(4, 0.0, 1.0).unwrap(), OcConfig::top88());
    let next = oc.update(&[0.5; 4], &[0.0; 4], None, |x| sum(x) - 2.0).unwrap();
    assert_eq!(next, [0.3; 4]);
}

#[test]
fn misfits_are_named() {
    let mut oc = optimizer(Bounds::uniform(3, 0.0, 1.0).unwrap(), OcConfig::top88());
    let x = [0.5; 3];
    let zero = |_: &[f64]| 0.0;
    let message = |result: crate::Result<&[f64]>| result.unwrap_err().to_string();
    let found = message(oc.update(&x, &[-1.0; 2], None, zero));
    assert_eq!(found, "dc has shape [2], expected [3]");
    let found = message(oc.update(&x, &[-1.0, f64::NAN, -1.0], None, zero));
    assert_eq!(found, "dc[1] is NaN, which is not finite");
    let found = message(oc.update(&x, &[-1.0; 3], Some(&[1.0, 1.0, 0.0]), zero));
    assert_eq!(found, "dv[2] = 0 is outside its range (0, inf)");
    let found = message(oc.update(&[0.5, 1.5, 0.5], &[-1.0; 3], None, zero));
    assert_eq!(found, "x[1] = 1.5 is outside its range [0, 1]");
    let found = message(oc.update(&x, &[-1.0; 3], None, |_| f64::NAN));
    assert_eq!(found, "excess of the volume[0] is NaN, which is not finite");
    assert!(
        OptimalityCriteria::new(Bounds::uniform(3, -1.0, 1.0).unwrap(), OcConfig::top88()).is_err()
    );
}
