//! Surfaces of periodic fields: where they lie, what closes them, and how they hang together.

use solvers::{
    Field, Grid,
    isosurface::{Caps, surface, triangulate},
    mesh::{Bvh, Ray, TriangleMesh},
};
use std::f64::consts::{PI, TAU};

/// `f` of angles, one period along each axis of `n` nodes, with node distance `h`.
fn periodic(n: usize, h: f64, f: impl Fn([f64; 3]) -> f64 + Sync) -> Field {
    let grid = Grid::new(&[n, n, n], h).unwrap();
    Field::from_fn(grid, |p| f(p.map(|c| c * TAU / (n as f64 * h))))
}

fn schwarz_p([x, y, z]: [f64; 3]) -> f64 {
    x.cos() + y.cos() + z.cos()
}

fn gyroid([x, y, z]: [f64; 3]) -> f64 {
    x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
}

/// The surface on the torus.
fn joined(phi: &Field, level: f64) -> TriangleMesh {
    let [nz, ny, nx] = phi.grid().shape();
    let h = phi.grid().spacing();
    let open = triangulate(phi, level, Caps::Periodic).unwrap();
    assert!(open.is_manifold() && !open.is_closed());
    open.on_torus([nx, ny, nz].map(|n| n as f64 * h))
}

#[test]
fn minimal_surfaces_have_their_genus_on_the_torus() {
    // Schoen 1970: P has genus 3 in its primitive cell, which is the cube; the gyroid has 3 in
    // a primitive cell that is half the cube, so that chi = 2 (2 - 2 * 3) in the cube.
    for n in [8, 15, 24] {
        for h in [1.0, 0.3] {
            let p = joined(&periodic(n, h, schwarz_p), 0.0);
            assert_eq!((p.components(), p.genus()), (1, Some(3)), "{n}");
            let g = joined(&periodic(n, h, gyroid), 0.0);
            assert_eq!((g.euler_characteristic(), g.components(), g.genus()), (-8, 1, Some(5)));
        }
    }
    // A plane wave: two flat tori.
    let planes = joined(&periodic(12, 1.0, |[x, _, _]| (x + 0.2).cos()), 0.0);
    assert_eq!((planes.components(), planes.genus()), (2, Some(2)));
    // A ball about the box's corner: eight pieces in space, one on the torus.
    let ball = periodic(16, 1.0, |p| 2.0 - schwarz_p(p));
    assert_eq!(triangulate(&ball, 0.0, Caps::Periodic).unwrap().components(), 8);
    let ball = joined(&ball, 0.0);
    assert_eq!((ball.components(), ball.genus()), (1, Some(0)));
}

#[test]
fn caps_close_the_whole_period() {
    // By symmetry P halves the box, and each face of it: at x = 0 the inside is where
    // cos y + cos z < -1.
    let (n, h) = (32, 0.25);
    let side = n as f64 * h;
    let phi = periodic(n, h, schwarz_p);
    let closed = surface(&phi, 0.0, Caps::PeriodicClosed).unwrap();
    assert!(closed.mesh.is_closed() && closed.mesh.is_manifold());
    let volume = closed.mesh.volume() / side.powi(3);
    // Beyond the box there is the skin, 1e-3 cells thick.
    assert!((volume - 0.5).abs() < 1e-3, "{volume}");
    let open = triangulate(&phi, 0.0, Caps::Periodic).unwrap();
    let capped: Vec<[u32; 3]> = closed
        .mesh
        .triangles
        .iter()
        .zip(&closed.caps)
        .filter(|(_, c)| **c)
        .map(|(t, _)| *t)
        .collect();
    let caps = TriangleMesh { vertices: closed.mesh.vertices.clone(), triangles: capped };
    assert!((closed.mesh.area() - caps.area() - open.area()).abs() < 3e-3 * open.area());
    for v in &closed.mesh.vertices {
        assert!(v.iter().all(|&c| c > -0.002 * h && c < side + 0.002 * h), "{v:?}");
    }
    // Area of cos y + cos z < -1 by midpoints on a fine raster.
    let fine = 1000;
    let cosine = |i: usize| (TAU * (i as f64 + 0.5) / fine as f64).cos();
    let rows = (0..fine).map(|j| (0..fine).filter(|&i| cosine(i) + cosine(j) < -1.0).count());
    let part = rows.sum::<usize>() as f64 / (fine * fine) as f64;
    let area = caps.area() / (6.0 * side * side);
    assert!((area - part).abs() < 0.004, "{area} {part}");
}

#[test]
fn handles_and_pieces_are_counted() {
    let grid = Grid::new(&[20, 40, 40], 1.0).unwrap();
    let torus =
        Field::from_fn(grid, |[x, y, z]| ((x - 19.3).hypot(y - 19.6) - 11.0).hypot(z - 9.4) - 4.2);
    let torus = triangulate(&torus, 0.0, Caps::Open).unwrap();
    assert_eq!((torus.components(), torus.genus()), (1, Some(1)));
    // Pappus: 4 pi^2 R r and 2 pi^2 R r^2.
    let (area, volume) = (4.0 * PI * PI * 11.0 * 4.2, 2.0 * PI * PI * 11.0 * 4.2 * 4.2);
    assert!(
        (torus.area() / area - 1.0).abs() < 0.02 && (torus.volume() / volume - 1.0).abs() < 0.02
    );
    let mut two = torus.clone();
    let first = two.vertices.len() as u32;
    two.vertices.extend(torus.vertices.iter().map(|v| [v[0], v[1], v[2] + 50.0]));
    two.triangles.extend(torus.triangles.iter().map(|t| t.map(|v| v + first)));
    assert_eq!((two.components(), two.genus()), (2, Some(2)));
    two.triangles.pop();
    assert_eq!(two.genus(), None);
    assert_eq!(TriangleMesh::default().components(), 0);
    // Corners apart, as an STL has them, and joined again.
    let apart = TriangleMesh {
        vertices: torus.triangles.iter().flatten().map(|&v| torus.vertices[v as usize]).collect(),
        triangles: (0..torus.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect(),
    };
    assert_eq!(apart.components(), apart.triangles.len());
    assert_eq!(apart.weld().genus(), Some(1));
}

#[test]
fn corner_normals_keep_creases_and_smooth_the_rest() {
    let grid = Grid::new(&[24, 24, 24], 1.0).unwrap();
    let ball =
        Field::from_fn(grid, |p| p.iter().map(|c| (c - 11.6).powi(2)).sum::<f64>().sqrt() - 8.0);
    let ball = triangulate(&ball, 0.0, Caps::Open).unwrap();
    for (t, normals) in ball.triangles.iter().zip(ball.corner_normals(1.0)) {
        for (&v, n) in t.iter().zip(normals) {
            let exact = ball.vertices[v as usize].map(|c| (c - 11.6) / 8.0);
            let cosine: f64 = (0..3).map(|m| exact[m] * n[m]).sum();
            assert!(cosine > 0.99, "{cosine}");
        }
    }
    // Two squares at a right angle.
    let fold = TriangleMesh {
        vertices: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 3, 1]],
    };
    let [flat, _] = fold.corner_normals(0.5)[..] else { panic!() };
    assert_eq!(flat, [[0.0, 0.0, 1.0]; 3]);
    let [round, _] = fold.corner_normals(2.0)[..] else { panic!() };
    assert!((round[0][1] - 0.5_f64.sqrt()).abs() < 1e-12 && round[2] == [0.0, 0.0, 1.0]);
}

#[test]
fn rays_meet_what_every_triangle_tried_says() {
    let mesh = triangulate(&periodic(14, 1.0, gyroid), 0.1, Caps::PeriodicClosed).unwrap();
    let bvh = Bvh::new(&mesh);
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 40) as f32 / (1 << 24) as f32
    };
    let mut met = 0;
    for _ in 0..2000 {
        let origin = [0; 3].map(|_| 24.0 * random() - 5.0);
        let target = [0; 3].map(|_| 14.0 * random());
        let direction = [0, 1, 2].map(|m| target[m] - origin[m]);
        let ray = Ray { origin, direction, reach: f32::INFINITY };
        let exact = mesh.triangles.iter().filter_map(|t| crossing(&mesh, *t, &ray));
        let exact = exact.min_by(f64::total_cmp);
        let hit = bvh.closest(&ray);
        assert_eq!(bvh.occluded(&ray), hit.is_some());
        match (exact, hit) {
            (Some(t), Some(hit)) => {
                met += 1;
                assert!((t - f64::from(hit.distance)).abs() < 1e-3 * (1.0 + t), "{t} {hit:?}");
                let weights: f32 = hit.weights.iter().sum();
                assert!((weights - 1.0).abs() < 1e-5);
                let short = Ray { reach: 0.99 * hit.distance, ..ray };
                assert!(bvh.closest(&short).is_none() && !bvh.occluded(&short));
            }
            (None, None) => {}
            other => panic!("{other:?} {ray:?}"),
        }
    }
    assert!(met > 1000, "{met}");
    assert!(
        Bvh::new(&TriangleMesh::default())
            .closest(&Ray { origin: [0.0; 3], direction: [1.0; 3], reach: 1.0 })
            .is_none()
    );
}

/// Distance to one triangle (Moeller and Trumbore 1997).
fn crossing(mesh: &TriangleMesh, t: [u32; 3], ray: &Ray) -> Option<f64> {
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|m| a[m] - b[m]);
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|m| a[m] * b[m]).sum::<f64>();
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|m| a[(m + 1) % 3] * b[(m + 2) % 3] - a[(m + 2) % 3] * b[(m + 1) % 3])
    };
    let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
    let (o, d) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let (e, f) = (minus(b, a), minus(c, a));
    let p = cross(d, f);
    let det = dot(e, p);
    let s = minus(o, a);
    let u = dot(s, p) / det;
    let q = cross(s, e);
    let (v, t) = (dot(d, q) / det, dot(f, q) / det);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

#[test]
fn no_ray_slips_through_a_closed_surface() {
    // From the middle of a ball every ray meets it, also through vertices and along edges.
    let grid = Grid::new(&[16, 16, 16], 1.0).unwrap();
    let ball =
        Field::from_fn(grid, |p| p.iter().map(|c| (c - 7.5).powi(2)).sum::<f64>().sqrt() - 5.0);
    let mesh = triangulate(&ball, 0.0, Caps::Open).unwrap();
    let bvh = Bvh::new(&mesh);
    let through = |target: [f64; 3]| {
        let direction = target.map(|c| (c - 7.5) as f32);
        bvh.closest(&Ray { origin: [7.5; 3], direction, reach: 4.0 }).is_some()
    };
    assert!(mesh.vertices.iter().all(|&v| through(v)));
    for t in &mesh.triangles {
        for m in 0..3 {
            let [a, b] = [t[m], t[(m + 1) % 3]].map(|v| mesh.vertices[v as usize]);
            for part in [0.5, 0.123] {
                assert!(through([0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]))));
            }
        }
    }
    let seen = |axis: usize| {
        let mut direction = [0.0; 3];
        direction[axis] = -1.0;
        bvh.occluded(&Ray { origin: [7.5; 3], direction, reach: 9.0 })
    };
    assert!((0..3).all(seen));
}
