//! Level lines and level surfaces of fields.

/// A line through points of the plane, with the region `phi < level` on its left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// Points `[x, y]` (length); a closed line does not repeat its first point.
    pub points: Vec<[f64; 2]>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}
