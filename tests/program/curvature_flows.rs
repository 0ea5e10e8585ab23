//! The flows of the curvature energy: the published one against its program, what the others keep,
//! and the same bits for any threads.

use crate::curvature::{CASES, SHAPE, components, energy, load, potential};
use patterns::curvature::energy::{Edges, Energy, EnergyConfig, Orientation, Spatial};
use patterns::curvature::flow::{
    Descent, DescentConfig, Fast, FastConfig, Opened, OpenedConfig, Paper, PaperConfig, StepInfo,
    start,
};
use patterns::curvature::{Mask, Potential};
use solvers::optimize::Adam;
use solvers::random::{stream, uniform};

/// Asymmetric energies amplify roundings a thousandfold in a few steps: only the first five
/// are compared.
#[test]
fn published_flow() {
    for (case, steps, tolerance) in
        [(&CASES[0], 300, 1e-10), (&CASES[1], 5, 1e-10), (&CASES[2], 5, 1e-9)]
    {
        let a = components(&load("A0"));
        let map = potential(SHAPE, case.m0);
        let mut flow =
            Paper::from_potential(energy::<f64>(case), map, PaperConfig::default(), a).unwrap();
        let expected = load(&format!("{}_adam_E_0_300_f64", case.name));
        let mut worst = 0.0_f64;
        for &expected in &expected[..=steps] {
            let info = flow.step().unwrap();
            worst = worst.max((info.energy / expected - 1.0).abs());
        }
        println!("{}: {steps} steps within {worst:.1e}", case.name);
        assert!(worst < tolerance);
    }
}

/// The published flow keeps div A and five fields; Adam on A itself, as published, keeps nine.
/// A box of the fewest planes, several slabs, one of a single plane.
#[test]
fn the_published_flow_is_adam_on_the_potential() {
    for (shape, threads) in [([4, 9, 32], 1), ([26, 21, 33], 2), ([17, 32, 36], 3)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let worst = pool.install(|| {
            let voxels: usize = shape.iter().product();
            let config = EnergyConfig::new(shape, 0.01, 0.02, CASES[0].coefficients.into());
            let mut energy = Energy::<f64>::new(config).unwrap();
            let mass = (0..voxels).map(|i| -0.4 + 0.1 * (i % 7) as f64 / 7.0).collect();
            let mut map = Potential::new(shape, 0.01, 2.0, &Spatial::Map(mass)).unwrap();
            let config = PaperConfig::default();
            let mut a = start::<f64>(voxels, 0.01, 5);
            let mut flow =
                Paper::from_potential(energy.clone(), map.clone(), config, a.clone()).unwrap();
            let zeros = || vec![0.0; voxels];
            let [mut u, mut du, mut between] = [zeros(), zeros(), zeros()];
            let mut means = [zeros(), zeros(), zeros()];
            let [mut squares, mut gradient] = [means.clone(), means.clone()];
            for t in 1..=12 {
                map.phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
                energy.value_and_gradient(&u, &mut du);
                map.blur_in_place(&mut du, &mut between);
                map.gradient(&du, gradient.each_mut().map(|g| &mut g[..]));
                let adam = Adam::new(&config.adam, t);
                for axis in 0..3 {
                    let state = [&mut a[axis], &mut means[axis], &mut squares[axis]];
                    adam.update(state.map(|values| &mut values[..]), &gradient[axis]);
                }
                let norm = gradient.iter().flatten().map(|g| g * g).sum::<f64>().sqrt();
                let step = flow.step().unwrap();
                assert!((step.gradient_norm / norm - 1.0).abs() < 1e-9, "{shape:?}, step {t}");
            }
            map.phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
            let apart = u.iter().zip(flow.phase()).map(|(a, b)| (a - b).abs());
            apart.fold(0.0_f64, f64::max)
        });
        println!("{shape:?}, {threads} threads: {worst:.1e}");
        assert!(worst < 1e-10, "{shape:?}: {worst:.1e}");
    }
}

#[test]
fn mass_is_kept() {
    let case = &CASES[1];
    let a = components(&load("A0"));
    let (mut u, mut between) = (a[0].clone(), a[0].clone());
    potential(SHAPE, case.m0).phase([&a[0], &a[1], &a[2]], &mut between, &mut u);
    let mean = |u: &[f64]| u.iter().sum::<f64>() / u.len() as f64;
    let before = mean(&u);
    let map = potential(SHAPE, case.m0);
    let mut paper =
        Paper::from_potential(energy::<f64>(case), map, PaperConfig::default(), a).unwrap();
    let map = Potential::new(SHAPE, 0.01, 2.0, &Spatial::Uniform(case.m0)).unwrap();
    let mut single = Paper::new(energy::<f32>(case), map, PaperConfig::default(), 3).unwrap();
    let single_mean = |flow: &Paper<f32>| {
        flow.phase().iter().map(|&u| f64::from(u)).sum::<f64>() / u.len() as f64
    };
    // The blur's weights in single precision add up to 1 but for a rounding.
    let single_before = single_mean(&single);
    assert!((single_before - case.m0).abs() < 2e-7);
    for _ in 0..100 {
        paper.step().unwrap();
        single.step().unwrap();
    }
    let moved = [mean(paper.phase()) - before, single_mean(&single) - single_before];
    println!("paper: mean moved by {:.1e}, in f32 {:.1e}", moved[0], moved[1]);
    assert!(moved[0].abs() < 1e-14 && moved[1].abs() < 1e-7);
    let mut fast = Fast::new(energy::<f64>(case), FastConfig::default(), u.clone()).unwrap();
    let first = fast.step().unwrap().energy;
    for _ in 0..60 {
        fast.step().unwrap();
    }
    let last = fast.step().unwrap().energy;
    println!("fast: F {first:.1} to {last:.1}, mean moved by {:.1e}", mean(fast.phase()) - before);
    assert!((mean(fast.phase()) - before).abs() < 1e-14 && last < 0.1 * first);
    let free = DescentConfig { sigma: None, keep_mass: true, ..DescentConfig::default() };
    let spectral = DescentConfig { beta: Some(1.0), sigma: None, ..DescentConfig::default() };
    let blurred = DescentConfig { keep_mass: true, ..DescentConfig::default() };
    for (name, config) in [("plain", free), ("blurred", blurred), ("spectral", spectral)] {
        let mut flow = Descent::new(energy::<f64>(&CASES[0]), config, None, u.clone()).unwrap();
        let before = mean(flow.phase());
        let mut energies = Vec::new();
        for _ in 0..40 {
            energies.push(flow.step().unwrap().0.energy);
        }
        println!(
            "{name}: F {:.2} to {:.3}, {} evaluations, mean moved by {:.1e}",
            energies[0],
            energies[39],
            flow.counts()[1],
            mean(flow.phase()) - before
        );
        assert!((mean(flow.phase()) - before).abs() < 1e-13, "{name}");
        assert!(energies.windows(2).all(|pair| pair[1] <= pair[0]), "{name}");
        // Forty steps without a preconditioner are early days.
        assert!(energies[39] < 0.2 * energies[0], "{name}");
    }
}

/// Its opening is the published flow and its rest the fast one from there, to the bit; given
/// voxels stay in both.
#[test]
fn an_opened_flow_is_the_published_one_and_then_the_fast_one() {
    let case = &CASES[1];
    let inside: Vec<bool> = (0..SHAPE.iter().product()).map(|i| i % SHAPE[2] >= 6).collect();
    let mask = || Mask::outside(&inside);
    let map = || potential(SHAPE, case.m0);
    let energy = energy::<f64>(case);
    for opening in [0, 5] {
        let config = OpenedConfig::new(50, Some(opening));
        let opened = Opened::new(energy.clone(), map(), config, 3).unwrap();
        let mut opened = opened.with_mask(mask());
        let paper = Paper::new(energy.clone(), map(), config.paper, 3).unwrap();
        let mut paper = paper.with_mask(mask());
        for _ in 0..opening {
            assert_eq!(opened.step().unwrap(), paper.step().unwrap());
        }
        let fast = Fast::new(energy.clone(), config.fast, paper.phase().to_vec()).unwrap();
        let mut fast = fast.with_mask(mask());
        for n in 0..7 {
            let step = fast.step().unwrap();
            let StepInfo { iteration, energy, .. } = opened.step().unwrap();
            assert_eq!(step.energy.to_bits(), energy.to_bits());
            assert_eq!([iteration, opened.steps()], [opening + n, opening + n + 1]);
        }
        assert_eq!(opened.phase(), fast.phase());
        assert!(opened.phase().iter().zip(&inside).all(|(&u, &inside)| inside || u == -1.0));
    }
}

#[test]
fn given_voxels_stay() {
    let case = &CASES[1];
    let [nz, ny, nx] = SHAPE;
    let inside: Vec<bool> = (0..nz * ny * nx).map(|i| i % nx >= 6).collect();
    let map = potential(SHAPE, case.m0);
    let flow = Paper::new(energy::<f64>(case), map, PaperConfig::default(), 3).unwrap();
    let mut flow = flow.with_mask(Mask::outside(&inside));
    let first = flow.step().unwrap().energy;
    for _ in 0..50 {
        flow.step().unwrap();
    }
    assert!(flow.step().unwrap().energy < 0.5 * first);
    assert!(flow.phase().iter().zip(&inside).all(|(&u, &inside)| inside || u == -1.0));
}

#[test]
fn threads_do_not_change_a_bit() {
    let run = |shape: [usize; 3], threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let config = EnergyConfig::new(shape, 0.01, 0.02, CASES[1].coefficients.into());
            let energy = Energy::<f32>::new(config).unwrap();
            let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).unwrap();
            let mut paper = Paper::new(energy.clone(), map, PaperConfig::default(), 3).unwrap();
            let start = paper.phase().to_vec();
            let mut fast = Fast::new(energy.clone(), FastConfig::default(), start.clone()).unwrap();
            let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).unwrap();
            let config = OpenedConfig::new(50, Some(2));
            let mut opened = Opened::new(energy.clone(), map, config, 3).unwrap();
            let config = DescentConfig { beta: Some(1.0), ..DescentConfig::default() };
            let mut descent = Descent::new(energy, config, None, start).unwrap();
            let mut energies = Vec::new();
            for _ in 0..4 {
                energies.push(paper.step().unwrap().energy.to_bits());
                energies.push(fast.step().unwrap().energy.to_bits());
                energies.push(opened.step().unwrap().energy.to_bits());
                energies.push(descent.step().unwrap().0.energy.to_bits());
            }
            let all = [paper.phase(), fast.phase(), opened.phase(), descent.phase()].concat();
            (energies, all.iter().map(|u| u.to_bits()).collect::<Vec<_>>())
        })
    };
    assert_eq!(run([33, 30, 37], 1), run([33, 30, 37], 2));
    // A slab of a single plane.
    assert_eq!(run([17, 32, 36], 1), run([17, 32, 36], 3));
}

/// Adam's first step is its rate in every variable whose gradient is not tiny; the k-th of a
/// steady gradient is too.
#[test]
fn the_rate_rises_and_falls_as_it_is_told() {
    let case = &CASES[1];
    let map = potential(SHAPE, case.m0);
    let paper = Paper::new(energy::<f64>(case), map, PaperConfig::default(), 3).unwrap();
    let usual = FastConfig::default();
    let first = |warmup, decay| {
        let config = FastConfig { warmup, decay, ..usual };
        let mut fast = Fast::new(energy::<f64>(case), config, paper.phase().to_vec()).unwrap();
        fast.step().unwrap();
        fast.state()[0].iter().fold(0.0_f64, |most, y| most.max(y.abs()))
    };
    for (warmup, rate) in [(0, 1.0), (1, 0.5), (9, 0.1), (99, 0.01)] {
        let most = first(warmup, None);
        assert!((most / rate - 1.0).abs() < 1e-6, "{warmup}: {most}");
    }
    // Opened: a rate of .5 that rises in a quarter of what is left, at most 100.
    for (evaluations, opening, warmup) in [(800, 200, 100), (400, 100, 75), (40, 10, 7)] {
        let config = OpenedConfig::new(evaluations, None);
        assert_eq!((config.opening, config.fast.warmup), (opening, warmup));
        assert_eq!(config.fast.decay, Some(evaluations - opening));
    }
    // In half of what is left where that is less than the opening.
    for (evaluations, opening, warmup) in [(1920, 1700, 100), (1730, 1600, 65), (40, 20, 5)] {
        let config = OpenedConfig::new(evaluations, Some(opening));
        assert_eq!(config.fast.warmup, warmup);
    }
}

/// Slabs of several planes and of one, each kind of edge, the same coefficients everywhere or not.
#[test]
fn slabs_do_not_change_a_gradient() {
    let shape @ [nz, ny, nx] = [17, 32, 36];
    let mut stream = stream(5, "slabs", 0);
    let u: Vec<f64> = (0..nz * ny * nx).map(|_| uniform(&mut stream) - 0.5).collect();
    for edges in [Edges::Periodic, Edges::Replicate, Edges::Free] {
        for oriented in [false, true] {
            let run = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let coefficients = CASES[2].coefficients.into();
                    let mut config = EnergyConfig::new(shape, 0.01, 0.02, coefficients);
                    config.edges = edges;
                    let [mu, one, none] = [0.5, 1.0, 0.0].map(Spatial::Uniform);
                    let theta = [one, none.clone(), none];
                    config.orientation = oriented.then_some(Orientation { mu, theta });
                    let mut gradient = vec![0.0; u.len()];
                    let energy = Energy::new(config).unwrap().value_and_gradient(&u, &mut gradient);
                    let bits: Vec<u64> = gradient.iter().map(|g| g.to_bits()).collect();
                    (energy.to_bits(), bits)
                })
            };
            let whole = run(1);
            // Two threads make slabs of 5, 5, 5 and 2 planes, three of 4, 4, 4, 4 and 1.
            assert!(whole == run(2), "{edges:?}, oriented {oriented}, 2 threads");
            assert!(whole == run(3), "{edges:?}, oriented {oriented}, 3 threads");
        }
    }
}
