//! Analytic shapes: distances against dense samples of their contours, TOML, errors.

use proptest::prelude::*;
use solvers::level_set::Shape;
use solvers::level_set::shapes::Point;
use std::f64::consts::TAU;

fn parse(text: &str) -> Shape {
    toml::from_str(text).unwrap()
}

fn zoo() -> Vec<(&'static str, Shape)> {
    [
        ("circle", "kind = 'circle'\ncenter = [0.1, -0.2]\nradius = 0.7"),
        ("ellipse", "kind = 'ellipse'\ncenter = [0.1, 0]\nradii = [0.9, 0.3]"),
        ("ellipsoid", "kind = 'ellipsoid'\ncenter = [0.1, 0, 0]\nradii = [0.9, 0.3, 0.5]"),
        ("box", "kind = 'box'\ncenter = [0, 0.1]\nsize = [1.2, 0.6]\nrounding = 0.1"),
        ("box 3D", "kind = 'box'\ncenter = [0, 0.1, 0]\nsize = [1.2, 0.6, 0.8]"),
        ("star", "kind = 'star'\ncenter = [0, 0]\npoints = 5\nouter = 0.9\ninner = 0.4"),
        ("flower", "kind = 'flower'\ncenter = [0, 0]\nradius = 0.6\namplitude = 0.4\nlobes = 5"),
        ("half-plane", "kind = 'half-plane'\npoint = [0.1, 0]\nnormal = [1, 2]"),
        ("capsule", "kind = 'capsule'\nfrom = [-0.5, 0, 0.1]\nto = [0.5, 0.3, -0.2]\nradius = 0.2"),
        ("torus", "kind = 'torus'\ncenter = [0, 0]\nmajor = 0.6\nminor = 0.2"),
        ("zalesak", "kind = 'zalesak'\ncenter = [0, 0]\nradius = 0.8\nslot_width = 0.3\nslot_length = 1.2"),
        ("polygon", "kind = 'polygon'\npoints = [[-0.8, -0.7], [0.9, -0.5], [0.1, 0.0], [0.6, 0.8]]"),
        (
            "moved",
            "kind = 'moved'\nshift = [0.2, 0.1]\nturn = 30\nscale = 1.3\n[shape]\nkind = 'star'\ncenter = [0, 0]\npoints = 3\nouter = 0.7\ninner = 0.3",
        ),
    ]
    .map(|(name, text)| (name, parse(text)))
    .to_vec()
}

/// A function is the signed distance to its contour if it has slope 1 along its own
/// gradient line down to the contour: p - d grad d must lie on the contour.
#[test]
fn foot_points_lie_on_the_contour_and_none_is_nearer() {
    let mut numbers = solvers::random::stream(3, "shapes", 0);
    let mut coordinate = || 3.0 * solvers::random::uniform(&mut numbers) - 1.5;
    for (name, shape) in zoo() {
        shape.validate().unwrap();
        let mut worst = 0.0_f64;
        for _ in 0..4000 {
            let (p, q) = (
                [coordinate(), coordinate(), coordinate()],
                [coordinate(), coordinate(), coordinate()],
            );
            let d = shape.distance(p);
            // Lipschitz: no contour is nearer than it says.
            let apart = (0..3).map(|m| (p[m] - q[m]).powi(2)).sum::<f64>().sqrt();
            assert!((d - shape.distance(q)).abs() <= apart + 1e-9, "{name} at {p:?} and {q:?}");
            let step = 1e-6;
            let slope: [f64; 3] = std::array::from_fn(|m| {
                let shifted = |s: f64| {
                    let mut r = p;
                    r[m] += s;
                    shape.distance(r)
                };
                (shifted(step) - shifted(-step)) / (2.0 * step)
            });
            let length = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
            if (length - 1.0).abs() < 1e-5 {
                let foot: [f64; 3] = std::array::from_fn(|m| p[m] - d * slope[m]);
                worst = worst.max(shape.distance(foot).abs());
            } else {
                // Only on the medial axis, which has no volume.
                assert!(length < 1.0, "{name}: slope {length} at {p:?}");
            }
        }
        println!("{name}: feet within {worst:.1e} of the contour");
        // Central differences at step 1e-6 are good to about 1e-9 / 1e-6 times eps: 1e-5 is ample.
        assert!(worst < 1e-5, "{name}: {worst}");
    }
}

#[test]
fn zalesak_area_and_inside() {
    let shape =
        parse("kind = 'zalesak'\ncenter = [50, 75]\nradius = 15\nslot_width = 5\nslot_length = 25");
    // Zalesak 1979: slot 5 wide from below, 25 long: the bridge above is 5 thick.
    assert!(shape.distance([50.0, 84.0, 0.0]) > 0.0);
    assert!(shape.distance([50.0, 86.0, 0.0]) < 0.0);
    assert!((shape.distance([50.0, 85.0, 0.0])).abs() < 1e-12);
    assert!((shape.distance([50.0, 70.0, 0.0]) - 2.5).abs() < 1e-12);
}

#[test]
fn clear_errors() {
    let wrong = |text: &str| toml::from_str::<Shape>(text).unwrap_err().to_string();
    let message = wrong("kind = 'circel'\nradius = 1");
    assert!(message.contains("circel") && message.contains("zalesak"), "{message}");
    let message = wrong("kind = 'circle'\ncenter = [0, 0]\nradius = 1\nradios = 2");
    assert!(message.contains("radios"), "{message}");
    let message = wrong("kind = 'circle'\ncenter = [0, 0, 0, 0]\nradius = 1");
    assert!(message.contains("a point has 1 to 3 components, found 4"), "{message}");
    let message = wrong("kind = 'circle'\ncenter = [0, 0]");
    assert!(message.contains("radius"), "{message}");
    let invalid = |text: &str| parse(text).validate().unwrap_err().to_string();
    assert_eq!(
        invalid("kind = 'circle'\ncenter = [0, 0]\nradius = -1"),
        "circle.radius = -1 is outside its range (0, inf)"
    );
    assert_eq!(
        invalid("kind = 'box'\ncenter = [0, 0]\nsize = [2, 4]\nrounding = 1.5"),
        "box.rounding = 1.5 is outside its range [0, 1]"
    );
    assert_eq!(invalid("kind = 'union'\nshapes = []"), "shapes has 0 entries, expected at least 1");
    assert_eq!(
        invalid("kind = 'polygon'\npoints = [[0, 0], [1, 1]]"),
        "polygon.points has 2 entries, expected at least 3"
    );
}

#[test]
fn shapes_survive_toml() {
    for (name, shape) in zoo() {
        let text = toml::to_string(&shape).unwrap();
        assert_eq!(parse(&text), shape, "{name}: {text}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn combinations(x in -2.0..2.0_f64, y in -2.0..2.0_f64, angle in 0.0..TAU) {
        let p = [x, y, 0.0];
        let circle = |cx: f64| Shape::Circle { center: Point([cx, 0.1, 0.0]), radius: 0.6 };
        let (a, b) = (circle(-0.4), circle(0.5));
        let (da, db) = (a.distance(p), b.distance(p));
        let both = || vec![a.clone(), b.clone()];
        prop_assert_eq!(Shape::Union { shapes: both() }.distance(p), da.min(db));
        prop_assert_eq!(Shape::Intersection { shapes: both() }.distance(p), da.max(db));
        let cut = Shape::Difference { from: Box::new(a.clone()), minus: vec![b.clone()] };
        prop_assert_eq!(cut.distance(p), da.max(-db));
        let smooth = Shape::SmoothUnion { shapes: both(), radius: 0.2 }.distance(p);
        // The blend is deepest, radius / 4, where both are equally far.
        prop_assert!(smooth <= da.min(db) && smooth >= da.min(db) - 0.05 - 1e-15);
        let turned = Shape::Moved {
            shape: Box::new(a),
            shift: Point([0.3, -0.2, 0.0]),
            turn: angle.to_degrees(),
            axis: Point([0.0, 0.0, 1.0]),
            scale: 2.0,
        };
        let (s, c) = angle.sin_cos();
        let q = [0.3 + 2.0 * (c * x - s * y), -0.2 + 2.0 * (s * x + c * y), 0.0];
        prop_assert!((turned.distance(q) - 2.0 * da).abs() < 1e-12);
    }
}
