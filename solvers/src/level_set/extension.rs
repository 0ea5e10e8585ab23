//! Speeds known on a front, carried off it along its normals.

use crate::{Boundary, Error, Field, Grid, Result};

/// Extends `speed` off the front `phi = 0` so that `grad speed . grad phi = 0`: every
/// node gets the value at the nearest point of the front.
///
/// `phi` is a signed distance (length). Only the values of `speed` at nodes with a
/// neighbour of opposite sign are read; all are overwritten, except where no path
/// along falling |phi| leads to the front. Second order, in linear time: nodes are
/// visited in the order of |phi|, each solving the upwind form of the equation once.
/// Adalsteinsson & Sethian 1999, J. Comput. Phys. 148:2, section 4, here with
/// one-sided differences of second order.
///
/// # Errors
/// If the shapes differ or phi is not finite.
pub fn extend_speed(phi: &Field, speed: &mut Field, boundary: Boundary) -> Result<()> {
    speed.check_shape("speed", phi.grid())?;
    phi.check_finite("phi", 0.0)?;
    if u32::try_from(phi.grid().len()).is_err() {
        return Err(Error::Invalid("velocity extension handles at most 2^32 nodes".into()));
    }
    let known = speed.as_slice().to_vec();
    let mut sweep = Sweep {
        grid: phi.grid(),
        periodic: boundary == Boundary::Periodic,
        phi: phi.as_slice(),
        known: &known,
        speed: speed.as_mut_slice(),
        done: vec![false; known.len()],
    };
    for n in order_by_distance(phi.as_slice()) {
        if let Some(value) = sweep.solve(n as usize) {
            sweep.speed[n as usize] = value;
            sweep.done[n as usize] = true;
        }
    }
    Ok(())
}

struct Sweep<'a> {
    grid: Grid,
    periodic: bool,
    phi: &'a [f64],
    /// The speed as given.
    known: &'a [f64],
    speed: &'a mut [f64],
    /// Whether `speed` is extended there.
    done: Vec<bool>,
}

/// One axis of the upwind equation: `D phi = slope`, `D F = weight F - sum`.
struct Upwind {
    slope: f64,
    weight: f64,
    sum: f64,
}

impl Sweep<'_> {
    /// Solves `sum over axes of (D phi) (D F) = 0` for F at node `n`.
    fn solve(&self, n: usize) -> Option<f64> {
        if self.phi[n] == 0.0 {
            return Some(self.known[n]);
        }
        let (mut weight, mut sum) = (0.0, 0.0);
        for axis in 3 - self.grid.dim()..3 {
            if let Some(upwind) = self.upwind(n, axis) {
                weight += upwind.slope * upwind.weight;
                sum += upwind.slope * upwind.sum;
            }
        }
        (weight > 0.0).then(|| sum / weight)
    }

    /// The differences along an axis towards the front: to the front itself if it
    /// crosses the next edge, else to one or two extended nodes closer to it.
    fn upwind(&self, n: usize, axis: usize) -> Option<Upwind> {
        let distance = |m: usize| self.phi[m].abs();
        let sides = [false, true].map(|up| self.neighbour(n, axis, up).map(|m| (m, up)));
        let crossing = sides
            .into_iter()
            .flatten()
            .filter(|&(m, _)| self.phi[m] == 0.0 || (self.phi[m] < 0.0) != (self.phi[n] < 0.0))
            .map(|(m, _)| (m, distance(n) / (distance(n) + distance(m))))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((m, theta)) = crossing {
            let on_front = self.known[n] + theta * (self.known[m] - self.known[n]);
            let weight = 1.0 / theta;
            return Some(Upwind { slope: distance(n) * weight, weight, sum: on_front * weight });
        }
        let (first, up) = sides
            .into_iter()
            .flatten()
            .filter(|&(m, _)| self.done[m] && distance(m) < distance(n))
            .min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))?;
        let second = self.neighbour(first, axis, up).filter(|&m| {
            self.done[m]
                && distance(m) < distance(first)
                && (self.phi[m] < 0.0) == (self.phi[n] < 0.0)
        });
        let Some(second) = second else {
            let slope = distance(n) - distance(first);
            return Some(Upwind { slope, weight: 1.0, sum: self.speed[first] });
        };
        let slope = 1.5 * distance(n) - 2.0 * distance(first) + 0.5 * distance(second);
        let sum = 2.0 * self.speed[first] - 0.5 * self.speed[second];
        (slope > 0.0).then_some(Upwind { slope, weight: 1.5, sum })
    }

    /// The next node along an axis, if the grid has one.
    fn neighbour(&self, n: usize, axis: usize, up: bool) -> Option<usize> {
        let (count, stride) = (self.grid.shape()[axis], self.grid.strides()[axis]);
        let i = n / stride % count;
        match (up, self.periodic) {
            (true, _) if i + 1 < count => Some(n + stride),
            (false, _) if i > 0 => Some(n - stride),
            (true, true) => Some(n - (count - 1) * stride),
            (false, true) => Some(n + (count - 1) * stride),
            _ => None,
        }
    }
}

/// The nodes by increasing |phi|, to one part in 2^22 of the greatest, by a radix sort.
fn order_by_distance(phi: &[f64]) -> Vec<u32> {
    const BITS: u32 = 11;
    let greatest = phi.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let scale = f64::from((1_u32 << (2 * BITS)) - 1) / greatest;
    let key = |n: u32| (phi[n as usize].abs() * scale) as u32;
    let mut order: Vec<u32> = (0..phi.len() as u32).collect();
    let mut sorted = order.clone();
    for shift in [0, BITS] {
        let digit = |n: u32| (key(n) >> shift & ((1 << BITS) - 1)) as usize;
        let mut starts = vec![0_usize; (1 << BITS) + 1];
        order.iter().for_each(|&n| starts[digit(n) + 1] += 1);
        for d in 0..1 << BITS {
            starts[d + 1] += starts[d];
        }
        for &n in &order {
            let slot = &mut starts[digit(n)];
            sorted[*slot] = n;
            *slot += 1;
        }
        std::mem::swap(&mut order, &mut sorted);
    }
    order
}

#[cfg(test)]
mod tests {
    #[test]
    fn nodes_come_in_the_order_of_distance() {
        let phi: Vec<f64> = (0..2000).map(|n| f64::from(n * 7919 % 2003) - 1000.0).collect();
        let order = super::order_by_distance(&phi);
        assert!(order.windows(2).all(|w| phi[w[0] as usize].abs() <= phi[w[1] as usize].abs()));
        let mut nodes = order.clone();
        nodes.sort_unstable();
        assert!(nodes.into_iter().eq(0..2000));
    }
}
