#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::{Diagram, MODEL};
use crate::{Artifact, Context, Inputs, NoInputs, Run, Status};
use solvers::{Field, Grid, isosurface::Polyline};
use std::f64::consts::PI;

/// A ball for every name.
struct Ball;

impl Inputs for Ball {
    fn field(&self, _: &str, _: &str) -> crate::Result<Field> {
        let grid = Grid::new(&[12, 16, 20], 1.0)?;
        let inside =
            |p: [f64; 3]| [10.0, 8.0, 6.0].iter().zip(p).map(|(c, x)| (x - c).powi(2)).sum::<f64>();
        Ok(Field::from_fn(grid, |p| f64::from(u8::from(inside(p) < 9.0))))
    }

    fn lines(&self, key: &str, path: &str) -> crate::Result<Vec<Polyline>> {
        NoInputs.lines(key, path)
    }
}

fn start(settings: &str) -> crate::Result<Box<dyn Run>> {
    let context = Context { seed: 5, inputs: &Ball, memory: 1 << 33 };
    (MODEL.start)(&settings.parse().unwrap(), &context)
}

const SMALL: &str = "size = [12, 16, 20]\nevaluations = 60\n";

/// Every flow and kind of energy, half way, saved and taken up again: the same bytes, and the
/// same number of evaluations.
#[test]
fn every_flow_resumes_to_the_same_bytes() {
    let along = "along = { axis = 'x', stops = [\
        { at = 0.2, coefficients = [2, 2, 2, 0, 0, 0], mass = -0.4 }, \
        { at = 0.7, coefficients = [1, 2, 6, -40, -40, 400], mass = -0.6 }] }";
    for settings in [
        "flow = 'paper'",
        "flow = 'paper'\nprecision = 'f64'\nexclude = 'ball.npy'",
        "flow = 'fast'\nopening = 8\ninclude = 'ball.npy'",
        "flow = 'fast'\nopening = 4\nexclude = 'ball.npy'",
        "flow = 'fast'\nopening = 6\nprecision = 'f64'",
        "flow = 'fast'\nopening = 8\nrate = 300.0",
        "flow = 'fast'\nopening = 2\nrate = 300.0",
        "flow = 'fast'\norientation = { weight = 100.0, direction = [0, 0, 2] }",
        along,
        "flow = 'l2'\nblur = 1.0\nboundary = 'replicated'",
        "flow = 'l2'\nblur = 0.0\nboundary = 'free'\nstart = { kind = 'sphere', radius = 0.04 }",
        "flow = 'l2-mass'\nprecision = 'f64'",
    ] {
        let settings = format!("{SMALL}{settings}");
        let mut whole = start(&settings).unwrap();
        let mut half = start(&settings).unwrap();
        for _ in 0..6 {
            assert_eq!(whole.step().unwrap(), Status::Running, "{settings}");
            half.step().unwrap();
        }
        let mut resumed = start(&settings).unwrap();
        resumed.restore(&half.save()).unwrap();
        for _ in 0..6 {
            assert_eq!(whole.step().unwrap(), resumed.step().unwrap(), "{settings}");
        }
        assert!(whole.save() == resumed.save(), "{settings}");
        assert_eq!(whole.metrics(), resumed.metrics(), "{settings}");
    }
}

/// What costs more than a step is measured where a runner observes, a dozen times and at the end.
#[test]
fn looks_fall_on_observations() {
    // Observed at every step, at every third one, and with a remainder at the end.
    for evaluations in [60, 850, 1201] {
        let settings = format!("size = [12, 16, 20]\nmass = -0.5\nevaluations = {evaluations}");
        let mut run = start(&settings).unwrap();
        let every = crate::observation_interval(evaluations);
        let mut looks = 0;
        while run.step().unwrap() == Status::Running {
            if run.iterations().is_multiple_of(every) {
                let metrics = run.observe();
                let value = |name: &str| metrics.iter().find(|m| m.name == name).unwrap().value;
                let known = value("components").is_finite();
                assert!(!known || (value("mass") + 0.5).abs() < 1e-6, "{metrics:?}");
                looks += usize::from(known);
            }
        }
        assert!((10..=12).contains(&looks), "{evaluations}: {looks}");
        assert!(run.observe().iter().all(|metric| metric.value.is_finite()));
    }
}

#[test]
fn too_long_a_rate_is_halved_until_the_energy_falls() {
    let cases = [
        ("opening = 0", 0, 2.0),
        ("opening = 10", 10, 1.25),
        ("opening = 0\nprecision = 'f64'", 0, 2.0),
    ];
    // What the halvings take of 150 evaluations is missed at the end.
    for ((settings, begun, rise), (length, near)) in
        cases.into_iter().flat_map(|case| [(case, (150, 3.0)), (case, (250, 1.5))])
    {
        let ends = [0.5, 1e3, 1e9].map(|rate| {
            let settings =
                format!("size = [12, 16, 20]\nevaluations = {length}\nrate = {rate}\n{settings}");
            let mut run = start(&settings).unwrap();
            let mut energies = Vec::new();
            while run.step().unwrap() == Status::Running {
                energies.push(run.observe()[0].value);
            }
            println!("{settings}: F {energies:?} {:?}", run.notes());
            let ceiling = rise * energies[begun];
            assert!(energies[begun..].iter().all(|energy| *energy <= ceiling), "{energies:?}");
            assert_eq!(run.notes().iter().any(|note| note.contains("halved")), rate > 1.0);
            energies[energies.len() - 1]
        });
        assert!(ends[1..].iter().all(|end| *end < near * ends[0]), "{ends:?}");
    }
}

/// The diagram of a ball from its run, whose area and genus are known.
fn ball(radius: f64, epsilon: f64) -> Diagram {
    let run = start(&format!(
        "size = 72\nflow = 'l2'\nblur = 0.0\nboundary = 'replicated'\nepsilon = {epsilon}\n\
         start = {{ kind = 'sphere', radius = {radius} }}"
    ))
    .unwrap();
    let metrics = run.metrics();
    let metric = |name: &str| metrics.iter().find(|m| m.name == name).unwrap().value;
    assert_eq!([metric("genus"), metric("components")], [0.0, 1.0]);
    let area = 4.0 * PI * radius * radius;
    assert!((metric("area") / area - 1.0).abs() < 0.01, "{}", metric("area"));
    let table = run.artifacts().into_iter().find_map(|artifact| match artifact {
        Artifact::Table { columns, .. } => Some(columns),
        _ => None,
    });
    let [first, second, weight] = &table.unwrap()[..] else { panic!("three columns") };
    let values = first.1.iter().zip(&second.1).map(|(a, b)| [*a, *b]).collect();
    Diagram(solvers::mesh::SurfaceSamples { values, weights: weight.1.clone() })
}

/// Both curvatures of a ball are 1 / R: their mean is right, and they part by the root of an
/// error of second order in dx / epsilon, half as much at half of it. The distance of two diagrams is that of two points.
#[test]
fn diagrams_of_balls() {
    let means = |diagram: &Diagram| {
        [0, 1].map(|c| {
            let pairs = diagram.0.values.iter().zip(&diagram.0.weights);
            pairs.map(|(k, w)| k[c] * w).sum::<f64>() / diagram.area()
        })
    };
    let [coarse, large, small] = [(0.2, 0.02), (0.2, 0.04), (0.125, 0.04)].map(|(r, e)| ball(r, e));
    let parted = |diagram: &Diagram| means(diagram)[0] - means(diagram)[1];
    for (diagram, curvature) in [(&coarse, 5.0), (&large, 5.0), (&small, 8.0)] {
        let [first, second] = means(diagram);
        println!("1 / R = {curvature}: {first:.3} {second:.3}");
        assert!((0.5 * (first + second) / curvature - 1.0).abs() < 0.02, "{first} {second}");
    }
    assert!(parted(&large) < 0.5 * parted(&coarse), "{} {}", parted(&large), parted(&coarse));
    // Of two points d = 3 sqrt 2 apart: 2 reach^2 (1 - exp(-d^2 / 4 reach^2)) = 2.99^2.
    let distance = large.distance(&small, 0).unwrap();
    println!("distance {distance:.3}");
    assert!((distance / 2.99 - 1.0).abs() < 0.05, "{distance}");
    assert!(large.distance(&large, 0).unwrap() < 1e-3);
}

#[test]
fn what_a_flow_cannot_do_is_refused() {
    for (settings, key) in [
        ("size = 7", "size"),
        ("size = [100, 100, 3]", "size"),
        ("size = 100000", "size"),
        ("mass = -1.0", "mass"),
        ("mass = nan", "mass"),
        ("coefficients = [1, 2, 6, nan, 0, 0]", "coefficients"),
        ("coefficients = [1, 2, 6, 0, 0, 0]\nsquares = { h2 = 1.0 }", "squares"),
        ("epsilon = 0.001", "epsilon"),
        ("spacing = 0.0", "spacing"),
        ("boundary = 'replicated'", "boundary"),
        ("flow = 'paper'\nboundary = 'free'", "boundary"),
        ("flow = 'paper'\nstart = { kind = 'sphere', radius = 0.1 }", "start"),
        ("flow = 'l2-mass'\ninclude = 'ball.npy'", "include"),
        ("include = 'ball.npy'", "include"),
        ("orientation = { weight = 1.0 }", "orientation"),
        ("along = { axis = 'x', stops = [] }", "along.stops"),
        ("preset = 'tubs'", "preset"),
        ("evaluations = 300\nopening = 300", "opening"),
        ("flow = 'paper'\nopening = 10", "opening"),
        ("start = { kind = 'sphere', radius = 0.1 }\nopening = 10", "opening"),
        ("level = 1.0", "level"),
    ] {
        let message = start(settings).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains(&format!("`{key}`")), "{settings}: {message}");
    }
    let notes = start(&format!("{SMALL}coefficients = [1, 3, 1, 0, 0, 0]")).unwrap().notes();
    assert!(notes[0].contains("no lower bound"), "{notes:?}");
}

/// A phase that grew, for inference; a mesh around it is left to the laboratory's tests.
struct Grown(Field);

impl crate::Inputs for Grown {
    fn field(&self, _: &str, _: &str) -> crate::Result<Field> {
        Ok(self.0.clone())
    }

    fn lines(&self, key: &str, path: &str) -> crate::Result<Vec<Polyline>> {
        NoInputs.lines(key, path)
    }
}

/// A small texture, its two-valued copy, and what is found for both: the best that was seen, and
/// the same by a run that is taken up again.
#[test]
fn inference_brings_diagrams_together() {
    let mut run =
        start("size = 24\nevaluations = 80\ncoefficients = [1, 2, 6, -40, -40, 400]\nmass = -0.5")
            .unwrap();
    while run.step().unwrap() == Status::Running {}
    let phase = run
        .artifacts()
        .into_iter()
        .find_map(|artifact| match artifact {
            Artifact::Image(image) if image.name == "phase" => Some(image.field),
            _ => None,
        })
        .unwrap();
    let solid: Vec<f64> = phase.as_slice().iter().map(|u| f64::from(u8::from(*u > 0.0))).collect();
    let solid = Field::from_vec(phase.grid(), solid).unwrap();
    // In a box as small as this the phase is not the profile of a distance, as which its
    // two-valued copy is read: the mean differs by .06.
    for (field, kind, near) in [(phase, "a phase field", 1e-6), (solid, "two values", 0.1)] {
        let inputs = Grown(field);
        let context = Context { seed: 3, inputs: &inputs, memory: 1 << 33 };
        let settings = "shape = 'given.npy'\ncount = 3\ngenerations = 4\nnearest = 3\n\
            growth = { size = 16, evaluations = 40 }";
        let begin = || (super::infer::MODEL.start)(&settings.parse().unwrap(), &context).unwrap();
        let part = "shape = 'given.npy'\ngrowth = { evaluations = 40 }".parse().unwrap();
        let config = (super::infer::MODEL.start)(&part, &context).unwrap().config();
        assert_eq!(config["growth"]["size"].as_integer(), Some(48), "{config}");
        let mut whole = begin();
        let mut saved = Vec::new();
        while whole.step().unwrap() == Status::Running {
            saved.push(whole.save());
        }
        let metrics = whole.metrics();
        let metric = |name: &str| metrics.iter().find(|m| m.name == name).unwrap().value;
        println!("{kind}: {metrics:?}");
        assert!(whole.notes()[0].contains(kind), "{:?}", whole.notes());
        assert!((metric("shape_mass") + 0.5).abs() < near, "{}", metric("shape_mass"));
        // What is written is the best that was seen.
        let told = saved.last().unwrap().all_f64("told").unwrap();
        let best = told.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(told.len() == 3 + 4 * 8 && metric("distance") == best, "{} {best}", told.len());
        for name in ["a11", "a02", "b10", "b01", "c"] {
            let [low, high] = ["low", "high"].map(|end| metric(&format!("{name}_{end}")));
            assert!((low..=high).contains(&metric(name)), "{name}: {low} {high}");
        }
        assert!(metric("distance") < 20.0, "{}", metric("distance"));
        for state in saved.iter().step_by(2) {
            let mut resumed = begin();
            resumed.restore(state).unwrap();
            while resumed.step().unwrap() == Status::Running {}
            assert_eq!(resumed.metrics(), metrics);
        }
    }
}
