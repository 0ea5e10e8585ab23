//! Pictures that no model made, to see that they are told so; seeded.

use crate::Result;
use solvers::random::{Stream, stream, uniform};
use solvers::texture::normalized_convolution;
use solvers::{Field, Grid};

/// Rows of glyphs of 5x7 pixels, a bit per pixel, of the letters P A T E R N S.
const GLYPHS: [[u8; 7]; 7] = [
    [30, 17, 17, 30, 16, 16, 16],
    [14, 17, 17, 31, 17, 17, 17],
    [31, 4, 4, 4, 4, 4, 4],
    [31, 16, 16, 30, 16, 16, 31],
    [30, 17, 17, 30, 20, 18, 17],
    [17, 25, 21, 19, 17, 17, 17],
    [15, 16, 16, 14, 1, 1, 30],
];

/// Names of the pictures.
pub const NAMES: [&str; 20] = [
    "linear gradient",
    "radial gradient",
    "white noise",
    "smooth noise",
    "coloured noise",
    "voronoi edges",
    "voronoi cells",
    "checkerboard",
    "bricks",
    "text",
    "large text",
    "random lines",
    "overlapping disks",
    "random squares",
    "grid of lines",
    "sierpinski carpet",
    "maze",
    "spiral",
    "triangles",
    "clouds",
];

/// The picture `index` of [`NAMES`] (modulo their number), `size` pixels wide and high; grey
/// levels in [0, 1].
///
/// # Errors
/// If the size is 0.
pub fn picture(index: usize, size: usize, seed: u64) -> Result<Field> {
    let grid = Grid::new(&[size, size], 1.0)?;
    let mut random = stream(seed, "foreign", index as u64);
    let values = draw(index % NAMES.len(), size, &mut random);
    Ok(Field::from_vec(grid, values)?)
}

fn draw(index: usize, size: usize, random: &mut Stream) -> Vec<f64> {
    let n = size as f64;
    let fill = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..size * size).map(|m| f((m % size) as f64, (m / size) as f64)).collect()
    };
    let bit = |b: bool| f64::from(u8::from(b));
    match index {
        0 => fill(&|x, y| (0.7 * x + 0.3 * y) / n),
        1 => fill(&|x, y| ((x / n - 0.5).hypot(y / n - 0.4)).min(1.0)),
        2 => noise(size, random),
        3 => binary(blurred(size, 2.5, random)),
        4 => {
            let parts: Vec<Vec<f64>> = [1.0, 2.0, 4.0, 8.0, 16.0]
                .iter()
                .map(|&s| scaled(blurred(size, s, random), s))
                .collect();
            binary((0..size * size).map(|m| parts.iter().map(|p| p[m]).sum()).collect())
        }
        5 | 6 => {
            let seeds = points(60, n, random);
            let shade: Vec<f64> = seeds.iter().map(|_| bit(uniform(random) < 0.5)).collect();
            fill(&|x, y| {
                let mut order: Vec<(f64, usize)> = (seeds.iter().enumerate())
                    .map(|(i, s)| ((s[0] - x).hypot(s[1] - y), i))
                    .collect();
                order.sort_by(|a, b| a.0.total_cmp(&b.0));
                if index == 5 { bit(order[1].0 - order[0].0 > 2.0) } else { shade[order[0].1] }
            })
        }
        7 => fill(&|x, y| bit(((x / 8.0) as usize + (y / 8.0) as usize).is_multiple_of(2))),
        8 => fill(&|x, y| {
            let row = (y / 10.0) as usize;
            let shift = if row.is_multiple_of(2) { 0.0 } else { 10.0 };
            bit(y % 10.0 > 1.5 && (x + shift) % 20.0 > 1.5)
        }),
        9 => text(size, 1, random),
        10 => text(size, 3, random),
        11 => {
            let lines: Vec<[f64; 2]> = points(24, n, random);
            fill(&|x, y| {
                bit(!lines.iter().any(|&[a, b]| {
                    let angle = a / n * std::f64::consts::PI;
                    let d = libm::cos(angle) * (x - n / 2.0) + libm::sin(angle) * (y - n / 2.0);
                    (d - (b - n / 2.0)).abs() < 1.2
                }))
            })
        }
        12 => {
            let disks: Vec<([f64; 2], f64)> = points(45, n, random)
                .into_iter()
                .map(|p| (p, 3.0 + 9.0 * uniform(random)))
                .collect();
            fill(&|x, y| bit(!disks.iter().any(|(p, r)| (p[0] - x).hypot(p[1] - y) < *r)))
        }
        13 => {
            let squares: Vec<([f64; 2], f64)> = points(40, n, random)
                .into_iter()
                .map(|p| (p, 3.0 + 8.0 * uniform(random)))
                .collect();
            fill(&|x, y| {
                bit(!squares.iter().any(|(p, r)| (p[0] - x).abs() < *r && (p[1] - y).abs() < *r))
            })
        }
        14 => fill(&|x, y| bit(x % 11.0 > 2.0 && y % 11.0 > 2.0)),
        15 => fill(&|x, y| {
            let (mut a, mut b) = (x as usize, y as usize);
            let mut hole = false;
            while a > 0 || b > 0 {
                hole |= a % 3 == 1 && b % 3 == 1;
                (a, b) = (a / 3, b / 3);
            }
            bit(hole)
        }),
        16 => {
            let cells: Vec<bool> = (0..size * size).map(|_| uniform(random) < 0.5).collect();
            fill(&|x, y| {
                let (i, j) = ((x / 8.0) as usize, (y / 8.0) as usize);
                let (u, v) = (x % 8.0, y % 8.0);
                let across = if cells[j * size + i] { u } else { v };
                bit(across > 2.5)
            })
        }
        17 => fill(&|x, y| {
            let (dx, dy) = (x - n / 2.0, y - n / 2.0);
            let phase = dx.hypot(dy) / 9.0 - libm::atan2(dy, dx) / std::f64::consts::TAU;
            bit(phase.rem_euclid(1.0) > 0.3)
        }),
        18 => fill(&|x, y| {
            let (u, v) = (x / 14.0, y / 14.0);
            bit((u.fract() > v.fract()) != (v as usize).is_multiple_of(2))
        }),
        _ => {
            let (a, b) = (blurred(size, 3.0, random), blurred(size, 12.0, random));
            let (a, b) = (scaled(a, 1.0), scaled(b, 2.0));
            a.iter().zip(&b).map(|(a, b)| 0.5 + 0.1 * a + 0.1 * b).collect()
        }
    }
}

fn points(count: usize, n: f64, random: &mut Stream) -> Vec<[f64; 2]> {
    (0..count).map(|_| [n * uniform(random), n * uniform(random)]).collect()
}

fn noise(size: usize, random: &mut Stream) -> Vec<f64> {
    (0..size * size).map(|_| uniform(random)).collect()
}

fn blurred(size: usize, sigma: f64, random: &mut Stream) -> Vec<f64> {
    let values = noise(size, random);
    normalized_convolution([size, size], &values, &vec![1.0; values.len()], sigma).0
}

/// Mean 0 and standard deviation `scale`.
fn scaled(values: Vec<f64>, scale: f64) -> Vec<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
    values.into_iter().map(|v| scale * (v - mean) / deviation).collect()
}

/// 0 and 1 on the two sides of the mean.
fn binary(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.into_iter().map(|v| f64::from(u8::from(v > mean))).collect()
}

/// Lines of random letters, each of its pixels `scale` pixels wide.
fn text(size: usize, scale: usize, random: &mut Stream) -> Vec<f64> {
    let mut values = vec![1.0; size * size];
    let (width, height) = (6 * scale, 10 * scale);
    for row in 0..size / height {
        for column in 0..size / width {
            if uniform(random) < 0.15 {
                continue;
            }
            let glyph = GLYPHS[(uniform(random) * 7.0) as usize];
            for m in 0..(5 * scale) * (7 * scale) {
                let (v, u) = (m / (5 * scale), m % (5 * scale));
                if glyph[v / scale] >> (4 - u / scale) & 1 == 1 {
                    values[(row * height + v) * size + column * width + u] = 0.0;
                }
            }
        }
    }
    values
}
