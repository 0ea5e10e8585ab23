//! Pictures of surfaces against what optics says.

use lab::render::{
    Lighting, PAPER, Paint, Part, Picture, Projection, Stage, Up, View, render, shapes,
};
use rayon::ThreadPoolBuilder;
use solvers::mesh::TriangleMesh;
use std::f64::consts::{PI, TAU};

/// A ball of radius 1 about 0.
fn ball() -> TriangleMesh {
    let (rows, columns) = (160, 320);
    let mut mesh = TriangleMesh::default();
    for row in 0..=rows {
        let (s, c) = (PI * f64::from(row) / f64::from(rows)).sin_cos();
        for column in 0..columns {
            let (sin, cos) = (TAU * f64::from(column) / f64::from(columns)).sin_cos();
            mesh.vertices.push([s * cos, s * sin, c]);
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let at = |r: i32, c: i32| (r * columns + c % columns) as u32;
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh
}

fn front(elevation: f64) -> View {
    View { azimuth: 0.0, elevation, projection: Projection::Orthographic, up: Up::Z }
}

/// One small lamp and nothing else.
fn lamp() -> Lighting {
    let direction = [-48.0, 30.0];
    Lighting { key: 1.0, direction, radius: 0.1, sky: 0.0, fill: 0.0, ground: false }
}

/// Light of the green channel, in [0, 1].
fn green(color: [u8; 3]) -> f64 {
    let v = f64::from(color[1]) / 255.0;
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn pixel(picture: &Picture, x: f64, y: f64) -> f64 {
    green(picture.pixels[y as usize * picture.size[0] + x as usize])
}

#[test]
fn a_ball_covers_its_disc() {
    // The margin leaves 0.88 of the side.
    for (size, projection) in
        [(200, Projection::Orthographic), (201, Projection::Perspective { degrees: 30.0 })]
    {
        let view = View { projection, ..front(0.0) };
        let part = Part::new(ball(), [0; 3]);
        let picture = render(&[part], &view, &Lighting { key: 0.0, ..lamp() }, [size; 2]);
        let dark = |&c: &[u8; 3]| 1.0 - green(c) / green(PAPER);
        let area: f64 = picture.pixels.iter().map(dark).sum();
        let exact = PI * (0.44 * size as f64).powi(2);
        assert!((area / exact - 1.0).abs() < 0.003, "{projection:?}: {area} {exact}");
        // The disc lies in the middle.
        let middle = |axis: usize| {
            let place = |n: usize| (if axis == 0 { n % size } else { n / size }) as f64 + 0.5;
            let pixels = picture.pixels.iter().enumerate();
            pixels.map(|(n, c)| dark(c) * place(n)).sum::<f64>() / area
        };
        assert!((0..2).all(|axis| (middle(axis) - 0.5 * size as f64).abs() < 0.1));
    }
}

#[test]
fn a_ball_is_shaded_by_the_cosine() {
    let size = 301;
    let mut part = Part::new(ball(), [255; 3]);
    part.paint = Paint::Vertices(vec![[255; 3]; part.mesh.vertices.len()]);
    let picture = render(&[part], &front(0.0), &lamp(), [size; 2]);
    let (a, e) = (-48_f64.to_radians(), 30_f64.to_radians());
    let key = [a.sin() * e.cos(), -a.cos() * e.cos(), e.sin()];
    let radius = 0.44 * size as f64;
    let (mut lit, mut dark) = (0, 0);
    for y in 0..size {
        for x in 0..size {
            let [u, v] = [x as f64, size as f64 - 1.0 - y as f64]
                .map(|c| (c + 0.5 - 0.5 * size as f64) / radius);
            let Some(depth) = Some(1.0 - u * u - v * v).filter(|d| *d > 0.05) else { continue };
            let cosine = u * key[0] - depth.sqrt() * key[1] + v * key[2];
            let found = pixel(&picture, x as f64, y as f64);
            if cosine > 0.05 {
                lit += 1;
                // Half a step of 255, where the curve is steepest, and the mesh's facets.
                assert!((found - cosine).abs() < 0.006, "{x} {y}: {found} {cosine}");
            } else if cosine < -0.01 {
                dark += 1;
                assert!(found < 1e-3, "{x} {y}: {found}");
            }
        }
    }
    assert!(lit > 30_000 && dark > 5_000, "{lit} {dark}");
}

#[test]
fn a_ball_throws_its_shadow_where_the_lamp_sends_it() {
    let size = 500;
    // Specks at the corners widen the picture to [-7, 7].
    let speck = |x: f64, y: f64| TriangleMesh {
        vertices: vec![[x, y, -1.0], [x - 0.01 * x, y, -1.0], [x, y - 0.01 * y, -1.0]],
        triangles: vec![[0, 1, 2]],
    };
    let parts = [ball(), speck(-7.0, -7.0), speck(7.0, 7.0)].map(|m| Part::new(m, [200; 3]));
    let light = Lighting { ground: true, ..lamp() };
    let picture = render(&parts, &front(90.0), &light, [size; 2]);
    // From above: x to the right, y upwards. The lamp stands at azimuth -48 of the front (-y).
    let (sin, cos) = (-48_f64.to_radians()).sin_cos();
    let look = |s: f64, t: f64| {
        // s away from the lamp, t across.
        let (x, y) = (-s * sin + t * cos, s * cos + t * sin);
        let place = |c: f64| 0.5 * size as f64 + c / 7.0 * 0.44 * size as f64;
        pixel(&picture, place(x), size as f64 - place(y)) / green(PAPER)
    };
    // The ellipse has half axes 1 / sin 30 and 1 about s = cot 30, at the height of the ground.
    let middle = 3_f64.sqrt();
    for s in [1.2, 2.0, 3.0, middle + 1.9] {
        assert!(look(s, 0.0) < 0.3, "{s}: {}", look(s, 0.0));
    }
    // Light is averaged over neighbours up to 2.8 pixels away, which is 0.09 here.
    for side in [-1.0, 1.0] {
        assert!(look(middle, 0.9 * side) < 0.3, "{side}");
        assert!(look(middle, 1.1 * side) > 0.98, "{side}: {}", look(middle, 1.1 * side));
    }
    for s in [middle + 2.1, 5.0, -1.2, -4.0] {
        assert!(look(s, 0.0) > 0.98, "{s}: {}", look(s, 0.0));
    }
}

#[test]
fn flat_faces_have_one_colour_at_grazing_light() {
    // Shadow acne and the seams of triangles would show.
    let square = TriangleMesh {
        vertices: vec![[0.0, 0.0, 0.3], [90.0, 0.0, 0.3], [90.0, 90.0, 0.3], [0.0, 90.0, 0.3]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let light = Lighting { direction: [20.0, 4.0], ..Lighting::default() };
    let picture = render(&[Part::new(square, [220; 3])], &front(60.0), &light, [160; 2]);
    let inner: Vec<_> = (60..100).flat_map(|y| &picture.pixels[y * 160 + 40..][..80]).collect();
    assert!(inner.iter().all(|&&c| c == *inner[0] && c != PAPER));
}

#[test]
fn the_inside_has_its_own_colour_and_what_is_near_is_in_front() {
    let mut tube = shapes::frustum([0.0; 3], [0.0, 0.0, 4.0], [1.0, 1.0]);
    // Without its discs.
    tube.triangles.retain(|t| t[0] > 1);
    let mut part = Part::new(tube, [255, 0, 0]);
    part.inside = [0, 255, 0];
    let picture = render(&[part], &front(45.0), &Lighting::default(), [200; 2]);
    let count = |c: usize| picture.pixels.iter().filter(|p| p[c] > 30 && p[1 - c] < 10).count();
    assert!(count(0) > 5000 && count(1) > 800, "{} {}", count(0), count(1));
}

#[test]
fn one_and_two_threads_make_the_same_bytes() {
    let draw = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let parts = [
                Part::new(ball(), [232, 214, 182]),
                Part::new(shapes::arrow([0.5, 0.0, 2.5], [0.0, 0.0, 1.1], 0.1), [200, 30, 30]),
                Part::new(shapes::frame([-1.0; 3], [1.0; 3], 0.02), [90; 3]),
            ];
            let stage = Stage::new(&parts, Up::MinusY);
            let view = View::default();
            let light = Lighting::default();
            (stage.draw(&view, &light, [160, 120]), stage.turn(&view, &light, [40, 40], 3))
        })
    };
    let (one, film) = draw(1);
    assert_eq!((&one, &film), (&draw(2).0, &draw(3).1));
    assert!(film[0] != film[1]);
}

#[test]
fn odd_shapes_are_drawn() {
    let flat = TriangleMesh { vertices: vec![[1.0; 3]; 3], triangles: vec![[0, 1, 2]] };
    let far = TriangleMesh {
        vertices: vec![[1e9, 0.0, 0.0], [1e9, 1.0, f64::NAN], [1e9, 0.0, 1.0]],
        triangles: vec![[0, 1, 2]],
    };
    for mesh in [TriangleMesh::default(), flat, far] {
        let picture =
            render(&[Part::new(mesh, [9; 3])], &View::default(), &Lighting::default(), [20, 30]);
        assert_eq!(picture.pixels.len(), 600);
    }
}
