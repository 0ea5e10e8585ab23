use super::*;
use crate::NoInputs;
use crate::disocclusion::{Database, Ink, normalize, simulate};
use solvers::level_set::label_components;

/// Class `name` on `size` x `size` cells, at its defaults without ranges.
fn class(name: &str, config: &str) -> Class {
    let text = format!(
        "name = '{name}'\nabout = ''\nmodel = 'rd'\nseeds = 'free'\n[config]\n{config}\n\
         precision = 'f32'\ncurve = {{ speed = 'off' }}\nsize = [96, 96]"
    );
    Class::parse(&text, &NoInputs).unwrap()
}

fn spots() -> Class {
    class("spots", "preset = 'spots'\nboundary = 'periodic'")
}

/// All but boxes of `side` pixels in the middle of squares of `period` pixels.
fn boxes([ny, nx]: [usize; 2], period: usize, side: usize) -> Vec<bool> {
    let first = (period - side) / 2;
    let hidden = |x: usize| (first..first + side).contains(&(x % period));
    (0..ny * nx).map(|n| !(hidden(n / nx) && hidden(n % nx))).collect()
}

fn field(shape: [usize; 2], values: Vec<f64>) -> Field {
    Field::from_vec(Grid::new(&shape, 1.0).unwrap(), values).unwrap()
}

fn normal(pattern: &Ink, visible: &[bool]) -> Normal {
    let grey = pattern.ink.iter().map(|&ink| if ink { 0.0 } else { 1.0 }).collect();
    normalize(&field(pattern.shape, grey), visible).unwrap()
}

fn iou(truth: &[bool], found: &[bool], visible: &[bool]) -> f64 {
    let count = |test: &dyn Fn(usize) -> bool| {
        (0..truth.len()).filter(|&n| !visible[n] && test(n)).count() as f64
    };
    count(&|n| truth[n] && found[n]) / count(&|n| truth[n] || found[n])
}

#[test]
fn spots_in_small_holes_come_back_and_their_polarity_does_not_matter() {
    let class = spots();
    let pattern = simulate(&class, &[], 3, &NoInputs).unwrap();
    let visible = boxes(pattern.shape, 32, 16);
    let filled =
        fill(&normal(&pattern, &visible), Some(&class), &[], &Fill::default(), &NoInputs).unwrap();
    let found = iou(&pattern.ink, filled.picture(), &visible);
    assert!(found >= 0.65, "{found}");
    assert_eq!((filled.method, filled.samples.len()), ("reaction-diffusion", 1));
    for n in (0..visible.len()).filter(|&n| visible[n]) {
        assert!(filled.picture()[n] == pattern.ink[n] && filled.confidence[n] == 1.0);
    }
    let inverse = Ink { ink: pattern.ink.iter().map(|ink| !ink).collect(), ..pattern };
    let settings = Fill { inverted: true, ..Fill::default() };
    let other = fill(&normal(&inverse, &visible), Some(&class), &[], &settings, &NoInputs).unwrap();
    assert!(other.picture().iter().zip(filled.picture()).all(|(a, b)| a != b));
}

#[test]
fn a_wide_hole_has_the_patterns_spots_and_an_honest_confidence() {
    let class = spots();
    let pattern = simulate(&class, &[], 5, &NoInputs).unwrap();
    let visible = boxes(pattern.shape, 96, 48);
    let settings = Fill { samples: Some(4), ..Fill::default() };
    let normal = normal(&pattern, &visible);
    let filled = fill(&normal, Some(&class), &[], &settings, &NoInputs).unwrap();
    let statistics = |ink: &[bool]| {
        let inside: Vec<bool> = ink.iter().zip(&visible).map(|(a, b)| *a && !*b).collect();
        let grid = Grid::new(&pattern.shape, 1.0).unwrap();
        let sizes = label_components(&inside, grid, Boundary::Neumann).unwrap().sizes;
        let large: Vec<usize> = sizes.into_iter().filter(|&size| size >= 4).collect();
        let count = large.len() as f64;
        (count, large.iter().sum::<usize>() as f64 / count)
    };
    let ((n, area), (wanted, wanted_area)) =
        (statistics(filled.picture()), statistics(&pattern.ink));
    assert!((n / wanted - 1.0).abs() <= 0.15, "{n} {wanted}");
    assert!((area / wanted_area - 1.0).abs() <= 0.15, "{area} {wanted_area}");
    let depth = depth(&normal).unwrap();
    let ring = |low: f64, high: f64| {
        let inside = (0..depth.len()).filter(|&n| depth[n] > low && depth[n] <= high);
        let (mut right, mut told, mut count) = (0.0, 0.0, 0.0);
        for n in inside {
            right += f64::from(u8::from(filled.picture()[n] == pattern.ink[n]));
            told += filled.confidence[n];
            count += 1.0;
        }
        (right / count, told / count)
    };
    let rings = [ring(0.0, 4.0), ring(4.0, 12.0), ring(12.0, 24.0)];
    assert!(rings.iter().all(|(right, told)| (right - told).abs() < 0.15), "{rings:?}");
    assert!(rings[0].1 > rings[1].1 && rings[1].1 > rings[2].1, "{rings:?}");
}

#[test]
fn a_magnified_pattern_is_filled_at_its_own_scale() {
    let class = spots();
    let pattern = simulate(&class, &[], 7, &NoInputs).unwrap();
    let at = |n: usize| pattern.ink[n / 192 / 2 * 96 + n % 192 / 2];
    let large = Ink { shape: [192, 192], ink: (0..192 * 192).map(at).collect() };
    let visible = boxes(large.shape, 64, 32);
    let filled =
        fill(&normal(&large, &visible), Some(&class), &[], &Fill::default(), &NoInputs).unwrap();
    let found = iou(&large.ink, filled.picture(), &visible);
    assert!(found >= 0.6, "{found}");
}

#[test]
fn grey_levels_tell_more_than_colours() {
    let class = class("labyrinth", "preset = 'labyrinth'\nboundary = 'periodic'");
    let context = crate::Context { seed: 2, inputs: &NoInputs, memory: 1 << 30 };
    let mut run = (class.model.start)(&class.config, &context).unwrap();
    while run.step().unwrap() == crate::Status::Running {}
    let b = run.artifacts().into_iter().find_map(|artifact| match artifact {
        crate::Artifact::Image(image) if image.name == "b" => Some(image.field),
        _ => None,
    });
    let b = b.unwrap();
    let mean = b.mean_std().0;
    let ink: Vec<bool> = b.as_slice().iter().map(|&b| b < mean).collect();
    let visible = boxes([96, 96], 32, 16);
    let normal = normal(&Ink { shape: [96, 96], ink: ink.clone() }, &visible);
    let found = |grey: Option<Field>| {
        let settings = Fill { grey, ..Fill::default() };
        let filled = fill(&normal, Some(&class), &[], &settings, &NoInputs).unwrap();
        iou(&ink, filled.picture(), &visible)
    };
    // Any rising function of the concentration: only its order counts.
    let grey = b.as_slice().iter().map(|b| (b + 1.0).ln()).collect();
    let (by_grey, by_colour) = (found(Some(field([96, 96], grey))), found(None));
    assert!(by_grey >= 0.62 && by_colour >= 0.55 && by_grey > by_colour, "{by_grey} {by_colour}");
}

#[test]
fn the_hidden_half_of_a_structure_is_optimized_again() {
    let database = Database::built_in().unwrap();
    let class = database.find("topology-row-l").unwrap();
    let point = [0.4, 0.5, 0.3];
    let small = simulate(class, &point, 0, &NoInputs).unwrap();
    // On its side: a quarter turn from x towards y takes column i of row j to row i.
    let at = |n: usize| small.ink[(29 - n % 90 / 3) * 30 + n / 90 / 3];
    let pattern = Ink { shape: [90, 90], ink: (0..90 * 90).map(|n| !at(n)).collect() };
    let visible: Vec<bool> = (0..90 * 90).map(|n| n % 90 < 45).collect();
    let settings = Fill {
        inverted: true,
        angle: std::f64::consts::FRAC_PI_2,
        samples: Some(2),
        ..Fill::default()
    };
    let normal = normal(&pattern, &visible);
    let filled = fill(&normal, Some(class), &point, &settings, &NoInputs).unwrap();
    assert_eq!((filled.method, filled.picture()), ("topology", &pattern.ink[..]));
    // Parameters that are off: the visible material guides the optimizer.
    let off = [0.55, 0.7, 0.5];
    let joined = fill(&normal, Some(class), &off, &settings, &NoInputs).unwrap();
    let found: Vec<bool> = joined.picture().iter().map(|ink| !ink).collect();
    let truth: Vec<bool> = pattern.ink.iter().map(|ink| !ink).collect();
    assert!(iou(&truth, &found, &visible) >= 0.8, "{}", iou(&truth, &found, &visible));
}

#[test]
fn bricks_are_continued_by_patches_to_the_pixel() {
    let brick = |n: usize| {
        let (j, i) = (n / 80, n % 80);
        j % 4 == 0 || (i + 4 * (j / 4 % 2)) % 8 == 0
    };
    let pattern = Ink { shape: [80, 80], ink: (0..80 * 80).map(brick).collect() };
    let visible = boxes(pattern.shape, 80, 20);
    let filled = fill(&normal(&pattern, &visible), None, &[], &Fill::default(), &NoInputs).unwrap();
    assert_eq!((filled.method, filled.picture()), ("patch", &pattern.ink[..]));
}

#[test]
fn the_contour_is_the_border_of_the_picture() {
    let disk = |n: usize| ((n / 64) as f64 - 31.5).hypot((n % 64) as f64 - 31.5) < 14.0;
    let pattern = Ink { shape: [64, 64], ink: (0..64 * 64).map(disk).collect() };
    let visible = vec![true; 64 * 64];
    let filled = fill(&normal(&pattern, &visible), None, &[], &Fill::default(), &NoInputs).unwrap();
    assert_eq!(filled.picture(), &pattern.ink[..]);
    let measures = solvers::level_set::Measures::of(&filled.contour, Boundary::Neumann);
    let area = std::f64::consts::PI * 14.0 * 14.0;
    // Stairs of one pixel have a border that is 4/pi too long.
    let circle = std::f64::consts::TAU * 14.0;
    assert!((measures.area / area - 1.0).abs() < 0.02, "{measures:?}");
    assert!((measures.perimeter / circle - 1.0).abs() < 0.06, "{measures:?}");
    assert_eq!(measures.components, 1);
}

#[test]
fn threads_change_no_bit() {
    let class = spots();
    let pattern = simulate(&class, &[], 1, &NoInputs).unwrap();
    let visible = boxes(pattern.shape, 96, 24);
    let settings = Fill { samples: Some(3), seed: 4, ..Fill::default() };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let normal = normal(&pattern, &visible);
        let filled = pool.install(|| fill(&normal, Some(&class), &[], &settings, &NoInputs));
        format!("{:?}", filled.unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn what_cannot_be_filled_is_refused() {
    let pattern = Ink { shape: [20, 20], ink: (0..400).map(|n| n % 7 < 3).collect() };
    let error = |visible: &[bool], settings: &Fill| {
        let normal = normal(&pattern, visible);
        fill(&normal, None, &[], settings, &NoInputs).unwrap_err().to_string()
    };
    let visible = boxes([20, 20], 20, 4);
    let none = error(&visible, &Fill { samples: Some(0), ..Fill::default() });
    assert!(none.contains("samples"), "{none}");
    let grey = Some(field([20, 19], vec![0.0; 380]));
    let other = error(&visible, &Fill { grey, ..Fill::default() });
    assert!(other.contains("[20, 19]") && other.contains("grey"), "{other}");
    let grid: Vec<bool> = (0..400).map(|n| n % 20 % 3 == 0).collect();
    let full = error(&grid, &Fill::default());
    assert!(full.contains("mask"), "{full}");
}
