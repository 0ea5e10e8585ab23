//! A speed field of one's own: the front climbs a ramp, fast on the right, slow on the left.
//!
//! Run: `cargo run --release --example custom_speed`
#![allow(clippy::print_stdout, reason = "an example prints")]

use solvers::{
    Boundary, Field, Grid, Result,
    level_set::{LevelSet, Measures, Scheme, Speed, Terms},
};

/// `beta = slope * x`.
struct Ramp {
    slope: f64,
}

impl Speed for Ramp {
    fn add(&mut self, phi: &Field, _t: f64, terms: &mut Terms) -> Result<()> {
        let grid = phi.grid();
        for (n, beta) in terms.normal().as_mut_slice().iter_mut().enumerate() {
            *beta += self.slope * grid.position(n)[0];
        }
        Ok(())
    }
}

fn main() -> Result<()> {
    let grid = Grid::new(&[101, 101], 1.0)?;
    let disk = Field::from_fn(grid, |[x, y, _]| (x - 50.0).hypot(y - 50.0) - 15.0);
    let mut front = LevelSet::new(disk, Scheme::default())?;
    let mut speed = Ramp { slope: 0.02 };
    while front.time() < 15.0 {
        front.advance(&mut speed, 15.0 - front.time())?;
    }
    let phi = front.phi();
    let middle = |i: usize| phi.at(0, 50, i) < 0.0;
    let (left, right) = ((0..50).find(|&i| middle(i)), (50..101).rfind(|&i| middle(i)));
    println!("the disk grew from 35..65 to {left:?}..{right:?} on the middle row");
    println!("area {:.1} cells^2", Measures::of(phi, Boundary::Neumann).area);
    // Along the middle row dx/dt = slope x: the right end is at 65 exp(0.3) = 87.7,
    // the left end, where the front moves against x, at 35 exp(-0.3) = 25.9.
    assert_eq!((left, right), (Some(26), Some(87)));
    Ok(())
}
