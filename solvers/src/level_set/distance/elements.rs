//! Pieces of a reconstructed contour: short arcs in the plane, round patches in space.
//!
//! Everything here is in units of the node distance h.

/// Largest half angle of an arc, for which the series of [`square`] were cut off.
pub(super) const HALF_ANGLE: f64 = 0.4;

/// A piece of the contour: its middle, its normal there, its curvature and how far it reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub point: [f64; 3],
    /// Unit vector towards phi > 0; any for a lone point.
    pub normal: [f64; 3],
    /// Curvature div(n) in the plane; see [`Element::in_space`].
    pub curvature: f64,
    /// Half-length along the tangent at the middle; beyond it the end point counts.
    pub extent: f64,
    /// The same for far nodes, that may not know of the next element.
    pub overlap: f64,
    /// Tangent of the largest angle to the normal at which nodes may have their foot point
    /// here; infinite where the contour ends or bends sharply.
    pub fan: f64,
}

/// Symmetric tensor `[xx, yy, zz, xy, xz, yz]`, the derivative of the normal along the surface.
pub(super) type Shape = [f64; 6];

/// Squared distance to an arc from a node at `across` its middle along the normal and
/// `along` its tangent.
///
/// With m = 1 + k across, the foot point on the circle lies along / sqrt(m^2 + (k along)^2)
/// along the tangent; its series in (k along / m)^2, cut to the arc's extent, errs by less
/// than 1e-3 cell at the largest half angle and by its sixth power below. A foot
/// point beside the true one by that much leaves the distance right to its square.
#[inline(always)]
pub(super) fn square(across: f64, along: f64, curvature: f64, extent: f64) -> f64 {
    let m = 1.0 + curvature * across;
    // Past the centre of the circle one of the ends is nearest.
    let m = if m > 1e-3 { m } else { 1e-3 };
    let linear = along / m;
    let u = curvature * linear;
    let u = u * u;
    let foot = linear * (1.0 - u * (0.5 - 0.375 * u));
    let foot = if foot < extent { foot } else { extent };
    let foot = if foot > -extent { foot } else { -extent };
    let bend = curvature * foot;
    let height = -0.5 * bend * foot * (1.0 + bend * bend * (0.25 + 0.125 * bend * bend));
    let (p, q) = (along - foot, across - height);
    p * p + q * q
}

impl Element {
    /// A point without direction.
    pub(super) fn point(point: [f64; 3]) -> Self {
        let normal = [1.0, 0.0, 0.0];
        Self { point, normal, curvature: 0.0, extent: 0.0, overlap: 0.0, fan: f64::INFINITY }
    }

    /// The arc from `a` to `b` in the plane, of a curvature whose positive sense is
    /// that of a normal with a positive component along `towards`. An arc of too
    /// large an angle is replaced by its chord.
    #[inline]
    pub(super) fn arc(a: [f64; 2], b: [f64; 2], curvature: f64, towards: [f64; 2]) -> Self {
        let chord = [b[0] - a[0], b[1] - a[1]];
        let length = (chord[0] * chord[0] + chord[1] * chord[1]).sqrt();
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.0];
        // The direction of a shorter chord is lost in round-off; so is its length.
        if length < 1e-9 {
            return Self::point(middle);
        }
        let mut n = [-chord[1] / length, chord[0] / length];
        if n[0] * towards[0] + n[1] * towards[1] < 0.0 {
            n = [-n[0], -n[1]];
        }
        let extent = 0.5 * length;
        let sine = curvature * extent;
        if sine.abs() > HALF_ANGLE || sine == 0.0 {
            let normal = [n[0], n[1], 0.0];
            return Self { normal, extent, overlap: extent, ..Self::point(middle) };
        }
        // The arc's middle stands off the chord's by its height.
        let height = sine * extent / (1.0 + (1.0 - sine * sine).sqrt());
        let point = [middle[0] + height * n[0], middle[1] + height * n[1], 0.0];
        let normal = [n[0], n[1], 0.0];
        Self { normal, curvature, extent, overlap: extent, ..Self::point(point) }
    }

    /// Leaves nodes beyond the given normals at its ends to the elements next to it,
    /// which share them.
    pub(super) fn between(self, ends: [[f64; 2]; 2]) -> Self {
        let [x, y, _] = self.normal;
        let lean = ends.map(|n| {
            let (sine, cosine) = ((n[0] * y - n[1] * x).abs(), n[0] * x + n[1] * y);
            if cosine > 0.0 { sine / cosine } else { f64::INFINITY }
        });
        let sine = (self.curvature * self.extent).abs();
        let own = sine / (1.0 - sine * sine).sqrt();
        // Round-off may open no gap between neighbours.
        Self { fan: lean[0].max(lean[1]).max(own) + 1e-6, ..self }
    }

    /// Lets far nodes take the element as this long at least (half-length), where the
    /// contour goes on smoothly.
    pub(super) fn overlapping(self, half: f64) -> Self {
        let half = half.min(HALF_ANGLE / self.curvature.abs());
        Self { overlap: self.extent.max(half), ..self }
    }

    /// Squared distance in space to a node at `w = node - point`, with the curvature
    /// that the tensor of its bends has towards the node.
    #[inline(always)]
    pub(super) fn square_in_space(&self, s: &Shape, w: [f64; 3]) -> f64 {
        let [x, y, z] = w;
        let bend = s[0] * x * x
            + s[1] * y * y
            + s[2] * z * z
            + 2.0 * (s[3] * x * y + s[4] * x * z + s[5] * y * z);
        let across = x * self.normal[0] + y * self.normal[1] + z * self.normal[2];
        let rest = x * x + y * y + z * z - across * across;
        let rest = if rest > 0.0 { rest } else { 0.0 };
        let curvature = if rest > 1e-12 { bend / rest } else { 0.0 };
        square(across, rest.sqrt(), curvature, self.extent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_measures_its_circle() {
        // Radius 4 around the origin, between angles 0 and 1/6, seen from inside and outside.
        let at = |r: f64, angle: f64| [r * angle.cos(), r * angle.sin()];
        let arc = Element::arc(at(4.0, 0.0), at(4.0, 1.0 / 6.0), 0.25, [1.0, 0.0]);
        let distance = |p: [f64; 2]| {
            let (x, y) = (p[0] - arc.point[0], p[1] - arc.point[1]);
            let n = arc.normal;
            square(x * n[0] + y * n[1], y * n[0] - x * n[1], arc.curvature, arc.extent).sqrt()
        };
        for (r, angle) in [(6.0, 0.01), (6.0, 0.1), (2.0, 0.16), (4.5, 0.05), (0.5, 0.1)] {
            let found = distance(at(r, angle));
            // Half angle 1/12: the series of the height errs by 5/128 r (1/12)^8 = 3.6e-10.
            assert!((found - (r - 4.0_f64).abs()).abs() < 1e-9, "{found} {r}");
        }
        // Beyond the ends the ends count; the height's series is good to (1/12)^8.
        let (end, p) = (at(4.0, 1.0 / 6.0), at(4.2, 0.3));
        let exact = (p[0] - end[0]).hypot(p[1] - end[1]);
        assert!((distance(p) - exact).abs() < 1e-8, "{} {exact}", distance(p));
    }
}
