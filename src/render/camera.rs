//! Cameras that see all of a shape.

use super::{
    Projection, Up, View,
    vector::{V, add, along, cross, dot, scale, sub, unit},
};
use solvers::mesh::Ray;

/// Part of the picture's smaller side that stays free around the shape.
const MARGIN: f32 = 0.06;

/// A position and three axes, in the renderer's coordinates: x right, y away, z up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Camera {
    eye: V,
    right: V,
    up: V,
    /// Towards the viewer.
    back: V,
    /// Half the width and height of the picture at distance 1; orthographic: anywhere.
    half: [f32; 2],
    perspective: bool,
    size: [usize; 2],
}

impl Up {
    /// A point of the model in the renderer's axes.
    pub(super) fn turn(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Z => [x, y, z],
            Self::Y => [x, -z, y],
            Self::MinusY => [x, z, -y],
        }
    }
}

impl View {
    /// Towards the viewer.
    pub(super) fn back(&self) -> V {
        direction(self.azimuth, self.elevation)
    }
}

/// Unit vector towards a place right of the front by `azimuth` and above by `elevation` (degrees).
pub(super) fn direction(azimuth: f64, elevation: f64) -> V {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    [a.sin() * e.cos(), -a.cos() * e.cos(), e.sin()].map(|v| v as f32)
}

impl Camera {
    /// The nearest camera that sees all `points`; turned about the middle, if `all_around`,
    /// the nearest that sees them from every azimuth.
    pub(super) fn fit(points: &[V], view: &View, size: [usize; 2], all_around: bool) -> Self {
        let back = view.back();
        // Straight from above or below: the front stays at the bottom.
        let right = direction(view.azimuth + 90.0, 0.0);
        let up = unit(cross(back, right));
        let [w, h] = size.map(|n| n as f32);
        let aspect = [w / w.min(h), h / w.min(h)];
        let inner = 1.0 - 2.0 * MARGIN;
        let tan = match view.projection {
            Projection::Perspective { degrees } => (0.5 * degrees.to_radians()).tan() as f32,
            Projection::Orthographic => 0.0,
        };
        // In the camera's axes a point is seen within the right side if x + t z <= c + t d,
        // with the camera at x = c, z = d; the other sides likewise.
        let mut most = [f32::NEG_INFINITY; 4];
        let mut nearest = f32::NEG_INFINITY;
        let mut see = |p: V| {
            let [x, y, z] = [right, up, back].map(|axis| dot(p, axis));
            let t = aspect.map(|a| a * inner * tan);
            let reach = [x + t[0] * z, -x + t[0] * z, y + t[1] * z, -y + t[1] * z];
            (0..4).for_each(|n| most[n] = most[n].max(reach[n]));
            nearest = nearest.max(z);
        };
        if all_around {
            // Each point as the circle that it runs through.
            for p in points {
                let r = p[0].hypot(p[1]);
                (0..72).for_each(|n| {
                    see(add(scale(direction(5.0 * f64::from(n), 0.0), r), [0.0, 0.0, p[2]]))
                });
            }
        } else {
            points.iter().for_each(|&p| see(p));
        }
        if !nearest.is_finite() {
            (most, nearest) = ([1.0; 4], 1.0);
        }
        let middle = [0.5 * (most[0] - most[1]), 0.5 * (most[2] - most[3])];
        let spread = [0.5 * (most[0] + most[1]), 0.5 * (most[2] + most[3])];
        let perspective = tan > 0.0;
        let [depth, side] = if perspective {
            let d = (spread[0] / aspect[0]).max(spread[1] / aspect[1]) / (inner * tan);
            // Never inside the shape.
            [d.max(nearest + 0.1), tan]
        } else {
            let s = (spread[0] / aspect[0]).max(spread[1] / aspect[1]) / inner;
            [nearest + 1.0, s.max(1e-3)]
        };
        let eye = add(along(scale(right, middle[0]), middle[1], up), scale(back, depth));
        Self { eye, right, up, back, half: aspect.map(|a| a * side), perspective, size }
    }

    /// The ray through a point of the picture, in pixels from its upper left corner; its
    /// direction has length 1.
    pub(super) fn ray(&self, x: f32, y: f32) -> Ray {
        let [w, h] = self.size.map(|n| n as f32);
        let u = (2.0 * x / w - 1.0) * self.half[0];
        let v = (1.0 - 2.0 * y / h) * self.half[1];
        let across = add(scale(self.right, u), scale(self.up, v));
        let (origin, direction) = if self.perspective {
            (self.eye, unit(sub(across, self.back)))
        } else {
            (add(self.eye, across), scale(self.back, -1.0))
        };
        Ray { origin, direction, reach: f32::INFINITY }
    }

    /// Width of a pixel at a distance from the eye.
    pub(super) fn pixel(&self, distance: f32) -> f32 {
        let width = 2.0 * self.half[0] / self.size[0] as f32;
        if self.perspective { width * distance } else { width }
    }
}
