use super::degrade::{HARMS, Harm, harm};
use super::*;
use crate::NoInputs;
use solvers::Grid;
use solvers::random::{stream, uniform};
use toml::Value;

const GOOD: &str = "name = 'mine'\nabout = 'spots'\nmodel = 'rd'\nseeds = 'free'\n\
                    [config]\npreset = 'spots'\nsize = [64, 64]\niterations = 3000\n\
                    curve = { speed = 'off' }\n[range]\n";

fn class(ranges: &str) -> Result<Class> {
    Class::parse(&format!("{GOOD}{ranges}"), &NoInputs)
}

fn key(result: Result<Class>) -> String {
    match result {
        Err(Error::Config { key, .. }) => key,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("accepted"),
    }
}

fn everything(shape: [usize; 2], ink: &[bool]) -> Normal {
    let grid = Grid::new(&shape, 1.0).unwrap();
    let values = ink.iter().map(|&i| if i { 0.0 } else { 1.0 }).collect();
    normalize(&Field::from_vec(grid, values).unwrap(), &vec![true; ink.len()]).unwrap()
}

#[test]
fn a_bad_entry_is_refused_by_key_and_range() {
    assert_eq!(
        key(class("'parameters.xi' = { low = 13.0, high = 12.0 }")),
        "range.\"parameters.xi\".high"
    );
    assert_eq!(key(class("'parameters.xi' = { low = 11.0 }")), "range.\"parameters.xi\".high");
    assert_eq!(
        key(class("'parameters.xi' = { low = 0.0, high = 1.0, log = true }")),
        "range.\"parameters.xi\".low"
    );
    assert_eq!(key(class("'parameters.xi' = { lo = 0.0 }")), "range.\"parameters.xi\".lo");
    assert_eq!(key(class("'dt' = { choices = [] }")), "range.\"dt\".choices");
    assert_eq!(key(Class::parse(&GOOD.replace("'rd'", "'dr'"), &NoInputs)), "model");
    assert_eq!(
        key(Class::parse(&GOOD.replace("iterations", "iteration"), &NoInputs)),
        "config.iteration"
    );
    let outside = class("'parameters.xi' = { low = 11.0, high = 17.0 }").unwrap();
    let message = outside.check(&NoInputs).unwrap_err().to_string();
    assert!(message.contains("range.\"parameters.xi\"") && message.contains("at 17"), "{message}");
    let mut database = Database::built_in().unwrap();
    let again = BUILT_IN[0].1;
    let message = database.add("mine.toml", again, &NoInputs).err().unwrap().to_string();
    assert!(message.contains("mine.toml: name"), "{message}");
}

#[test]
fn every_class_that_is_carried_runs_at_the_ends_of_its_ranges() {
    let database = Database::built_in().unwrap();
    assert!(database.classes.len() >= 12);
    for (class, (file, _)) in database.classes.iter().zip(BUILT_IN) {
        assert_eq!(format!("{}.toml", class.name), *file);
        class.check(&NoInputs).unwrap();
        assert!(!class.ranges.is_empty(), "{file}");
    }
}

#[test]
fn ranges_reach_linked_keys_of_lists_and_stay_inside() {
    let database = Database::built_in().unwrap();
    let row = database.find("topology-row-h").unwrap();
    let last = row.ranges.len();
    for (share, column) in [(0.0, 27), (1.0, 35), (7.0, 35)] {
        let config = row.configure(&vec![share; last]).unwrap();
        for load in [0, 1] {
            assert_eq!(config["problem"]["load"][load]["node"][0], Value::Integer(column));
        }
    }
    for index in 0..50 {
        assert!(row.point(3, index).iter().all(|share| (0.0..1.0).contains(share)));
    }
    assert_ne!(row.point(3, 0), row.point(4, 0));
}

#[test]
fn contrast_light_polarity_and_speckle_leave_the_ink() {
    let ink: Vec<bool> = (0..96 * 96)
        .map(|n| ((n % 96) as f64 % 12.0 - 6.0).hypot((n / 96) as f64 % 12.0 - 6.0) < 3.6)
        .collect();
    let grid = Grid::new(&[96, 96], 1.0).unwrap();
    let picture = |f: &dyn Fn(f64, f64, f64) -> f64| {
        let value = |n: usize| f(f64::from(u8::from(!ink[n])), (n % 96) as f64, (n / 96) as f64);
        Field::from_vec(grid, (0..ink.len()).map(value).collect()).unwrap()
    };
    let seen = vec![true; ink.len()];
    let lit = picture(&|v, x, y| 40.0 + 3.0 * v + 0.03 * x - 0.0002 * y * y);
    assert_eq!(normalize(&lit, &seen).unwrap().ink, ink);
    let negative = normalize(&picture(&|v, _, _| 5.0 - v), &seen).unwrap().ink;
    assert!(negative.iter().zip(&ink).all(|(a, b)| a != b));
    let source = Ink { shape: [96, 96], ink: ink.clone() };
    let noisy = harm(&source, Harm::Speckle, 0.25, 1).unwrap();
    let clean = normalize(&noisy.picture, &noisy.visible).unwrap();
    assert!(clean.despeckled);
    let wrong = |ink: &dyn Fn(usize) -> bool| {
        (0..96 * 96).filter(|&n| noisy.visible[n] && ink(n) != source.ink[n]).count()
    };
    let before = wrong(&|n| noisy.picture.as_slice()[n] < 0.5);
    assert!(3 * wrong(&|n| clean.ink[n]) < before, "{before} {}", wrong(&|n| clean.ink[n]));
}

#[test]
fn faults_are_named() {
    let grid = Grid::new(&[32, 32], 1.0).unwrap();
    let flat = Field::constant(grid, 0.5);
    let message = |visible: &[bool]| normalize(&flat, visible).unwrap_err().to_string();
    assert!(message(&[true; 7]).contains("`mask`"));
    assert!(message(&[false; 1024]).contains("hides the whole picture"));
    assert!(message(&[true; 1024]).contains("one value only"));
    let damaged = Calibration::from_bytes(b"nonsense").unwrap_err().to_string();
    assert!(damaged.contains("calibration"), "{damaged}");
}

#[test]
fn the_calibration_is_what_the_classes_make() {
    let calibration = built_in().unwrap();
    assert_eq!(Calibration::from_bytes(&calibration.to_bytes()).unwrap(), calibration);
    let database = Database::built_in().unwrap();
    for (name, index) in [("turing-spots", 0), ("schnakenberg-worms", 2)] {
        let made = samples(database.find(name).unwrap(), index, &NoInputs).unwrap();
        let kept = &calibration.classes.iter().find(|(class, _)| class == name).unwrap().1;
        let first = 5 * index as usize;
        for (made, kept) in made.iter().zip(&kept[first..]) {
            assert_eq!(made.0, kept.0);
            // Fourier transforms differ in the last bits between processors: one step.
            let close = made.1.iter().zip(&kept.1).all(|(a, b)| (a - b).abs() < 6e-4);
            assert!(close, "{name} {index}");
        }
        assert_eq!(made.len(), 5);
    }
}

#[test]
fn unseen_spots_are_found_and_hidden_pixels_change_no_bit() {
    let identifier = Identifier::new(Database::built_in().unwrap(), &built_in().unwrap()).unwrap();
    let class = identifier.database().find("schnakenberg-spots").unwrap();
    let pattern = simulate(class, &[0.4, 0.6], 977, &NoInputs).unwrap();
    let harmed = harm(&pattern, Harm::Box, 0.5, 3).unwrap();
    let answer = |picture: &Field| {
        let normal = normalize(picture, &harmed.visible).unwrap();
        let answer = identifier.identify(&normal, &NoInputs).unwrap();
        assert!(!answer.none);
        answer.ranking
    };
    let ranking = answer(&harmed.picture);
    assert_eq!(identifier.database().classes[ranking[0].class].name, "schnakenberg-spots");
    let mut other = harmed.picture.clone();
    let mut random = stream(2, "hidden", 0);
    for (value, _) in other.as_mut_slice().iter_mut().zip(&harmed.visible).filter(|(_, s)| !**s) {
        *value = uniform(&mut random);
    }
    assert_eq!(format!("{:?}", answer(&other)), format!("{ranking:?}"));
}

#[test]
fn topology_rows_are_found_turned_and_inverted() {
    let identifier = Identifier::new(Database::built_in().unwrap(), &built_in().unwrap()).unwrap();
    let class = identifier.database().find("topology-row-l").unwrap();
    let small = simulate(class, &[0.4, 0.5, 0.3], 0, &NoInputs).unwrap();
    let ink = (0..90 * 90).map(|n| small.ink[n / 90 / 3 * 30 + n % 90 / 3]).collect();
    let pattern = Ink { shape: [90, 90], ink };
    for kind in [Harm::Rotate, Harm::Invert, Harm::SmallBoxes] {
        let harmed = harm(&pattern, kind, 0.25, 5).unwrap();
        let normal = normalize(&harmed.picture, &harmed.visible).unwrap();
        let answer = identifier.identify(&normal, &NoInputs).unwrap();
        let first = &answer.ranking[0];
        assert_eq!(identifier.database().classes[first.class].name, "topology-row-l", "{kind:?}");
        assert_eq!(first.inverted, kind == Harm::Invert, "{kind:?}");
        assert!(!answer.none);
    }
}

#[test]
fn pictures_that_no_model_made_are_none_of_the_classes() {
    let identifier = Identifier::new(Database::built_in().unwrap(), &built_in().unwrap()).unwrap();
    let taken: Vec<&str> = (0..foreign::NAMES.len())
        .filter(|&index| {
            let picture = foreign::picture(index, 128, 11).unwrap();
            let normal = normalize(&picture, &vec![true; 128 * 128]).unwrap();
            !identifier.identify(&normal, &NoInputs).unwrap().none
        })
        .map(|index| foreign::NAMES[index])
        .collect();
    assert!(taken.len() <= foreign::NAMES.len() / 10, "{taken:?}");
}

#[test]
fn the_papers_score_is_a_correlation_and_its_least_value_finds_nothing() {
    let class = class("'parameters.xi' = { low = 11.8, high = 12.2 }").unwrap();
    let database: Vec<Ink> = (0..3)
        .flat_map(|seed| [0.0, 1.0].map(|xi| simulate(&class, &[xi], seed, &NoInputs).unwrap()))
        .collect();
    for (index, pattern) in database.iter().enumerate() {
        let harmed = harm(pattern, HARMS[0], 0.25, 1).unwrap();
        let normal = normalize(&harmed.picture, &harmed.visible).unwrap();
        let best = |score: &dyn Fn(&Ink) -> f64| {
            (0..database.len())
                .min_by(|&a, &b| score(&database[a]).total_cmp(&score(&database[b])))
                .unwrap()
        };
        assert_ne!(best(&|c| scores::sum_of_products(&normal, c)), index);
        assert_eq!(best(&|c| -scores::sum_of_products(&normal, c)), index);
        assert_eq!(best(&|c| scores::mean_squared_error(&normal, c)), index);
        assert_eq!(scores::mean_squared_error(&normal, pattern), 0.0);
    }
    let whole = everything(database[0].shape, &database[0].ink);
    assert_eq!(whole.ink, database[0].ink);
}

/// Disks on a lattice, as a source.
fn disks(side: usize) -> Ink {
    let inside =
        |n: usize| ((n % side) as f64 % 12.0 - 6.0).hypot((n / side) as f64 % 12.0 - 6.0) < 3.6;
    Ink { shape: [side, side], ink: (0..side * side).map(inside).collect() }
}

#[test]
fn occluders_are_found_where_they_are_and_nowhere_else() {
    let source = disks(120);
    let overlap = |found: &[bool], truth: &[bool]| {
        let hidden = |f: &dyn Fn(bool, bool) -> bool| {
            found.iter().zip(truth).filter(|(a, b)| f(!**a, !**b)).count() as f64
        };
        hidden(&|a, b| a && b) / hidden(&|a, b| a || b)
    };
    for seed in 0..4 {
        for (kind, share, named) in [
            (Harm::Box, 0.25, Occluder::Flat),
            (Harm::SmallBoxes, 0.5, Occluder::Flat),
            (Harm::Dots, 0.25, Occluder::Dots),
            (Harm::Blur, 0.25, Occluder::Flat),
        ] {
            let harmed = harm(&source, kind, share, seed).unwrap();
            let detection = detect(&harmed.picture).unwrap();
            assert_eq!(detection.found.len(), 1, "{kind:?} {seed}: {:?}", detection.found);
            assert_eq!(detection.found[0].0, named);
            let overlap = overlap(&detection.visible, &harmed.visible);
            assert!(
                overlap > if named == Occluder::Flat { 0.99 } else { 0.9 },
                "{kind:?} {overlap}"
            );
        }
        // A black box has the ink's level.
        let mut harmed = harm(&source, Harm::Box, 0.2, seed).unwrap();
        let seen = harmed.visible.clone();
        let hidden = harmed.picture.as_mut_slice().iter_mut().zip(&seen).filter(|(_, s)| !**s);
        hidden.for_each(|(v, _)| *v = 0.0);
        let detection = detect(&harmed.picture).unwrap();
        assert!(overlap(&detection.visible, &harmed.visible) > 0.85, "{seed}");
        // Salt and pepper hides single pixels all over.
        let noisy = harm(&source, Harm::Speckle, 0.0, seed).unwrap();
        let detection = detect(&noisy.picture).unwrap();
        assert_eq!(detection.found[0].0, Occluder::Noise);
        let wrong = |n: &usize| (noisy.picture.as_slice()[*n] < 0.5) != source.ink[*n];
        let flipped: Vec<usize> = (0..seen.len()).filter(wrong).collect();
        let caught = flipped.iter().filter(|&&n| !detection.visible[n]).count();
        assert!(caught as f64 > 0.9 * flipped.len() as f64, "{caught} of {}", flipped.len());
    }
    let clean = harm(&source, Harm::Box, 0.0, 0).unwrap();
    assert!(detect(&clean.picture).unwrap().found.is_empty());
    for class in ["topology-row-l", "topology-row-c", "schnakenberg-spots"] {
        let database = Database::built_in().unwrap();
        let class = database.find(class).unwrap();
        let pattern = simulate(class, &vec![0.5; class.ranges.len()], 3, &NoInputs).unwrap();
        let times = if class.free_seeds { 1 } else { 3 };
        let whole = harm(&pattern.magnify(times), Harm::Box, 0.0, 0).unwrap();
        let found = detect(&whole.picture).unwrap().found;
        assert!(found.is_empty(), "{}: {found:?}", class.name);
    }
}

#[test]
fn refinement_of_a_structure_lowers_its_pixel_error_and_finds_its_volume() {
    let identifier = Identifier::new(Database::built_in().unwrap(), &built_in().unwrap()).unwrap();
    let class = identifier.database().find("topology-row-l").unwrap();
    let truth = [0.37, 0.6, 0.2];
    let pattern = simulate(class, &truth, 0, &NoInputs).unwrap().magnify(3);
    let harmed = harm(&pattern, Harm::Box, 0.25, 2).unwrap();
    let normal = normalize(&harmed.picture, &harmed.visible).unwrap();
    let answer = identifier.identify(&normal, &NoInputs).unwrap();
    let first = &answer.ranking[0];
    let error = |point: &[f64]| {
        let candidate = simulate(class, point, 0, &NoInputs).unwrap();
        let placed = Placement::of(first).place(&candidate, normal.shape);
        scores::mean_squared_error(&normal, &placed)
    };
    let mut search = Refiner::new(&identifier, &normal, first, 1).unwrap();
    while search.history().len() < 16 && search.step(&NoInputs).unwrap().is_some() {}
    let refined = search.finish();
    let (before, after) = (error(&first.point), error(&refined.point));
    assert!(after < 0.7 * before, "{before} {after}");
    // Beside the pixel error a little for its distance from the entry's own configuration.
    let best = search.history().last().unwrap().best;
    assert_eq!(refined.cost, Some(best));
    assert!(best >= after && best <= after + 0.004 * class.ranges.len() as f64, "{best} {after}");
    // Whole numbers among the parameters give candidates that are known already.
    assert_eq!(search.history().last().unwrap().candidates[0], search.tried().len());
    let volume = class.ranges.iter().position(|r| r.key == "volume").unwrap();
    assert!((refined.point[volume] - truth[volume]).abs() < 0.15, "{refined:?}");
    assert!(refined.deviations.iter().all(|d| *d > 0.0 && *d < 1.0));
}

#[test]
fn the_usual_point_is_the_entrys_own_configuration() {
    for class in &Database::built_in().unwrap().classes {
        let usual = class.usual();
        let own = class.configure(&usual).unwrap();
        for (range, share) in class.ranges.iter().zip(usual) {
            let same = match [&own, &class.config].map(|c| class::get(c, &range.key).cloned()) {
                [Some(Value::Float(a)), Some(Value::Float(b))] => (a - b).abs() <= 1e-9 * b.abs(),
                [a, b] => a == b,
            };
            // The rows' published volume, radius and nodes lie in their ranges.
            let middle = share == 0.5 && !class.name.starts_with("topology-row");
            assert!(same || middle, "{}: {}", class.name, range.key);
        }
    }
}

#[test]
fn the_search_decides_between_structures_and_shares_out_their_confidence() {
    let found = |class: usize, confidence: f64| Match {
        class,
        confidence,
        distance: 0.5,
        square: None,
        inverted: false,
        point: vec![0.5],
        angle: Some(0.0),
    };
    let ranking = vec![found(0, 0.9), found(1, 0.0), found(2, 0.0), found(3, 0.1)];
    let before = Answer { ranking, none: false, wavelength: None };
    let decided = |costs: &[f64]| {
        let mut answer = before.clone();
        answer.decide(costs);
        answer.ranking.iter().map(|m| (m.class, m.confidence)).collect::<Vec<_>>()
    };
    // exp(-60 x .068) = .0169.
    let far = decided(&[0.07, 0.002]);
    assert_eq!(far.iter().map(|m| m.0).collect::<Vec<_>>(), [1, 0, 2, 3]);
    assert!((far[0].1 - 0.9 / 1.0169).abs() < 1e-4 && (far[1].1 - 0.9 + far[0].1).abs() < 1e-12);
    assert_eq!([far[2].1, far[3].1], [0.0, 0.1]);
    let level = decided(&[0.01, 0.01, 0.01]);
    assert_eq!(level.iter().map(|m| m.0).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert!(level[..3].iter().all(|m| (m.1 - 0.3).abs() < 1e-12));
}

/// The half that holds the load is hidden: nothing seen tells of it but what it did to the rest.
#[test]
fn the_hidden_half_of_a_structure_follows_from_the_other() {
    let identifier = Identifier::new(Database::built_in().unwrap(), &built_in().unwrap()).unwrap();
    let class = identifier.database().find("topology-row-d").unwrap();
    assert_eq!(class.values(&class.usual())[1], Value::Integer(16));
    for (truth, turned) in [(class.usual(), 0.0), (class.point(77, 1), 0.04)] {
        let pattern = simulate(class, &truth, 0, &NoInputs).unwrap().magnify(3);
        let [ny, nx] = pattern.shape;
        let visible: Vec<bool> = (0..ny * nx).map(|n| n % nx < nx / 2).collect();
        let grid = Grid::new(&[ny, nx], 1.0).unwrap();
        let grey = pattern.ink.iter().map(|&ink| f64::from(u8::from(!ink))).collect();
        let normal = normalize(&Field::from_vec(grid, grey).unwrap(), &visible).unwrap();
        let answer = identifier.identify(&normal, &NoInputs).unwrap();
        assert_eq!(identifier.class(&answer.ranking[0]).name, "topology-row-d");
        // As if a worse candidate had looked best at another angle.
        let first = Match { angle: Some(turned), ..answer.ranking[0].clone() };
        let mut search = Refiner::new(&identifier, &normal, &first, 1).unwrap();
        while search.history().len() < 16 && search.step(&NoInputs).unwrap().is_some() {}
        let refined = search.finish();
        let found = simulate(class, &refined.point, 0, &NoInputs).unwrap();
        let placement = Placement { angle: refined.angle, ..Placement::of(&first) };
        let placed = placement.place(&found, normal.shape);
        let hidden = (0..ny * nx).filter(|&n| !visible[n]);
        let count = |test: fn(bool, bool) -> bool| {
            hidden.clone().filter(|&n| test(placed.ink[n], pattern.ink[n])).count() as f64
        };
        let iou = count(|a, b| a && b) / count(|a, b| a || b);
        assert!(iou >= 0.95, "{iou} {refined:?} {truth:?}");
        assert_eq!(refined.angle, Some(0.0));
    }
}

#[test]
fn a_placed_structure_agrees_with_its_own_picture() {
    let small = Ink { shape: [20, 30], ink: (0..600).map(|n| n % 30 < 9 || n / 30 > 15).collect() };
    let pattern = small.magnify(4);
    for (kind, inverted) in [(Harm::Box, false), (Harm::Invert, true), (Harm::Rotate, false)] {
        let harmed = harm(&pattern, kind, 0.0, 9).unwrap();
        let normal = normalize(&harmed.picture, &harmed.visible).unwrap();
        let (correlation, angle, found) = agree(&normal, &small).unwrap();
        assert_eq!(found, inverted, "{kind:?}");
        let placement = Placement { inverted, angle: Some(angle), scale: 1.0 };
        let placed = placement.place(&small, normal.shape);
        assert!(
            (scores::correlation(&normal, &placed) - correlation).abs() < 1e-9
                || kind == Harm::Rotate
        );
        assert!(scores::mean_squared_error(&normal, &placed) < 0.02, "{kind:?}");
    }
}

#[test]
fn grey_levels_are_those_under_an_even_light() {
    let grid = Grid::new(&[64, 64], 1.0).unwrap();
    let wave = |n: usize| libm::sin((n % 64) as f64 * 0.7) * libm::cos((n / 64) as f64 * 0.6);
    let lit = |n: usize| wave(n) + 0.01 * (n % 64) as f64;
    let all = vec![true; 64 * 64];
    let picture = Field::from_vec(grid, (0..64 * 64).map(lit).collect()).unwrap();
    let normal = normalize(&picture, &all).unwrap();
    let levels = grey_levels(&picture, &normal).unwrap();
    let off = |f: &dyn Fn(usize) -> f64| {
        let mean = (0..64 * 64).map(|n| f(n) - wave(n)).sum::<f64>() / 4096.0;
        (0..64 * 64).map(|n| (f(n) - wave(n) - mean).abs()).fold(0.0, f64::max)
    };
    // A tenth of the light: seven waves have a little of a polynomial in them.
    let left = off(&|n| levels.as_slice()[n]);
    assert!(left < 0.1 * off(&lit), "{left}");
    let flat = Field::from_vec(grid, (0..64 * 64).map(|n| wave(n).signum()).collect()).unwrap();
    assert!(grey_levels(&flat, &normalize(&flat, &all).unwrap()).is_none());
}
