use super::*;
use crate::random::{stream, uniform};
use proptest::prelude::*;

/// Gray-Scott, as two species and two parameters of the usual kind.
struct GrayScott;

impl Cell<2, 2> for GrayScott {
    #[inline(always)]
    fn rates<T: Real>([u, v]: [T; 2], [feed, kill]: [T; 2]) -> [T; 2] {
        let reaction = u * v * v;
        [feed * (T::from_f64(1.0) - u) - reaction, reaction - (feed + kill) * v]
    }
}

/// No reaction.
struct Inert;

impl Cell<1, 0> for Inert {
    #[inline(always)]
    fn rates<T: Real>(_: [T; 1], []: [T; 0]) -> [T; 1] {
        [T::from_f64(0.0)]
    }
}

fn random_state<T: Real>(n: usize, index: u64) -> Vec<T> {
    let mut stream = stream(3, "state", index);
    (0..n).map(|_| T::from_f64(uniform(&mut stream))).collect()
}

fn gray_scott<T: Real>(
    shape: &[usize],
    boundary: Boundary,
    stencil: Stencil,
    map: bool,
) -> Explicit<T, CellKernel<T, GrayScott, 2, 2>> {
    let grid = Grid::new(shape, 1.0).unwrap();
    let feed = Field::from_vec(grid, random_state(grid.len(), 9)).unwrap();
    let feed = if map { Parameter::Map(feed) } else { Parameter::Uniform(0.04) };
    let parameters = [feed, Parameter::Uniform(0.06)];
    let kernel = CellKernel::new(grid, stencil, 0.5, [0.2, 0.1], &parameters, true).unwrap();
    let mut state = Explicit::new(grid, boundary, kernel).unwrap();
    for s in 0..2 {
        state.set(s, &random_state::<T>(grid.len(), s as u64));
    }
    state
}

fn bits<T: Real, K: Kernel<T>>(state: &Explicit<T, K>) -> Vec<u64> {
    let all = (0..state.kernel().species()).flat_map(|s| state.values(s));
    all.map(|v| v.to_f64().to_bits()).collect()
}

/// One step of the definition, node by node.
fn reference_step(u: &[Field; 2], boundary: Boundary, stencil: Stencil) -> [Field; 2] {
    let grid = u[0].grid();
    let shape = grid.shape();
    let lap = |f: &Field, n: usize| {
        let node = grid.node(n);
        let at = |d: [isize; 3]| {
            let m: Vec<usize> =
                (0..3).map(|a| boundary.wrap(node[a] as isize + d[a], shape[a])).collect();
            f.at(m[0], m[1], m[2])
        };
        let mut edges = 0.0;
        let mut corners = 0.0;
        for axis in (0..3).filter(|&a| stencil == Stencil::Axes || a > 0) {
            for side in [-1, 1] {
                let mut d = [0; 3];
                d[axis] = side;
                edges += at(d);
            }
        }
        for (dy, dx) in [(-1, -1), (-1, 1), (1, -1), (1, 1)] {
            corners += at([0, dy, dx]);
        }
        match stencil {
            Stencil::Axes => edges - 6.0 * at([0; 3]),
            Stencil::NinePoint => (4.0 * edges + corners - 20.0 * at([0; 3])) / 6.0,
        }
    };
    let mut next = u.clone();
    for n in 0..grid.len() {
        let (a, b) = (u[0].as_slice()[n], u[1].as_slice()[n]);
        let [f, g] = GrayScott::rates([a, b], [0.04, 0.06]);
        next[0].as_mut_slice()[n] = (a + 0.5 * (f + 0.2 * lap(&u[0], n))).max(0.0);
        next[1].as_mut_slice()[n] = (b + 0.5 * (g + 0.1 * lap(&u[1], n))).max(0.0);
    }
    next
}

#[test]
fn steps_follow_the_definition_on_every_axis_stencil_and_boundary() {
    for shape in [&[7][..], &[40], &[5, 6], &[9, 33], &[1, 20], &[4, 5, 18]] {
        for stencil in [Stencil::NinePoint, Stencil::Axes] {
            if shape.len() == 3 && stencil == Stencil::NinePoint {
                continue;
            }
            for boundary in [Boundary::Neumann, Boundary::Periodic] {
                let mut state = gray_scott::<f64>(shape, boundary, stencil, false);
                let field = |s: usize, state: &Explicit<f64, _>| {
                    Field::from_vec(state.grid(), state.values(s)).unwrap()
                };
                let mut expected = [field(0, &state), field(1, &state)];
                state.advance(11);
                for _ in 0..11 {
                    expected = reference_step(&expected, boundary, stencil);
                }
                for (s, expected) in expected.iter().enumerate() {
                    for (a, b) in state.values(s).iter().zip(expected.as_slice()) {
                        // Eleven steps of sums of nine terms of order one, in another order.
                        assert!((a - b).abs() < 1e-13, "{shape:?} {stencil:?} {boundary:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn mass_is_conserved_and_a_cosine_decays_by_the_symbol() {
    let grid = Grid::new(&[24, 32], 0.5).unwrap();
    let kernel =
        CellKernel::<f64, Inert, 1, 0>::new(grid, Stencil::NinePoint, 0.05, [0.7], &[], false);
    let mut state = Explicit::new(grid, Boundary::Neumann, kernel.unwrap()).unwrap();
    let (kx, ky) = (3.0 * std::f64::consts::PI / 32.0, 2.0 * std::f64::consts::PI / 24.0);
    // Eigenvectors of the mirror boundary are cosines about the cell faces.
    let mode = |n: usize| {
        let [_, j, i] = grid.node(n);
        (kx * (i as f64 + 0.5)).cos() * (ky * (j as f64 + 0.5)).cos()
    };
    let start: Vec<f64> = (0..grid.len()).map(|n| 2.0 + mode(n)).collect();
    state.set(0, &start);
    state.advance(37);
    let symbol = (8.0 * (kx.cos() + ky.cos()) + 4.0 * kx.cos() * ky.cos() - 20.0) / 6.0 / 0.25;
    let decay = (1.0 + 0.05 * 0.7 * symbol).powi(37);
    for (n, value) in state.values(0).into_iter().enumerate() {
        // Round-off of 37 steps.
        assert!((value - 2.0 - decay * mode(n)).abs() < 1e-13);
    }
}

#[test]
fn mirrored_and_transposed_states_have_mirrored_and_transposed_successors() {
    let n = 18;
    let run = |turn: &dyn Fn(usize, usize) -> (usize, usize)| {
        let mut state = gray_scott::<f64>(&[n, n], Boundary::Neumann, Stencil::NinePoint, false);
        for s in 0..2 {
            let from = random_state::<f64>(n * n, s as u64);
            let mut to = from.clone();
            for (index, value) in from.iter().enumerate() {
                let (j, i) = turn(index / n, index % n);
                to[j * n + i] = *value;
            }
            state.set(s, &to);
        }
        state.advance(20);
        let values = state.values(1);
        let turned = (0..n * n).map(|m| turn(m / n, m % n));
        turned.map(|(j, i)| values[j * n + i].to_bits()).collect::<Vec<_>>()
    };
    let plain = run(&|j, i| (j, i));
    assert_eq!(plain, run(&|j, i| (i, j)));
    assert_eq!(plain, run(&|j, i| (j, n - 1 - i)));
    assert_eq!(plain, run(&|j, i| (n - 1 - j, i)));
}

#[test]
fn threads_do_not_change_a_byte() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut state = gray_scott::<f32>(&[300, 130], Boundary::Periodic, Stencil::Axes, true);
        pool.install(|| state.advance(19));
        bits(&state)
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
}

fn blocked_equals_plain<T: Real>(
    shape: &[usize],
    boundary: Boundary,
    stencil: Stencil,
    map: bool,
    depth: usize,
    steps: u64,
) {
    let mut plain = gray_scott::<T>(shape, boundary, stencil, map).with_depth(1);
    let mut blocked = gray_scott::<T>(shape, boundary, stencil, map).with_depth(depth);
    for _ in 0..steps {
        plain.advance(1);
    }
    blocked.advance(steps);
    assert_eq!(bits(&plain), bits(&blocked));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn blocked_steps_are_plain_steps_to_the_last_bit(
        ny in 1..90_usize,
        nx in 1..60_usize,
        periodic: bool,
        nine: bool,
        map: bool,
        depth in 2..12_usize,
        steps in 1..30_u64,
    ) {
        let boundary = if periodic { Boundary::Periodic } else { Boundary::Neumann };
        let stencil = if nine { Stencil::NinePoint } else { Stencil::Axes };
        blocked_equals_plain::<f64>(&[ny, nx], boundary, stencil, map, depth, steps);
        blocked_equals_plain::<f32>(&[ny, nx], boundary, stencil, map, depth, steps);
    }
}
