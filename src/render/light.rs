//! How much light reaches a point, and what colour that makes.

use super::{
    Lighting, View,
    camera::direction,
    geometry::Stage,
    sampling::{SAMPLES, Samples},
    vector::{V, dot},
};
use solvers::mesh::Ray;

/// Farther things take no light of the sky away (half diagonals of the box).
const REACH: f32 = 0.9;

/// The lamps of a picture.
#[derive(Debug)]
pub(super) struct Lamps {
    pub(super) key: V,
    tan: f32,
    fill: V,
    light: Lighting,
    samples: Samples,
}

/// Parts of the key lamp and of the sky that are seen from a point, in [0, 1].
pub(super) type Seen = [f32; 2];

impl Lamps {
    pub(super) fn new(light: &Lighting, view: &View) -> Self {
        let [azimuth, elevation] = light.direction;
        Self {
            key: direction(view.azimuth + azimuth, elevation),
            tan: light.radius.to_radians().tan() as f32,
            fill: direction(view.azimuth + 20.0, 15.0),
            light: *light,
            samples: Samples::new(),
        }
    }

    /// What is seen from a point, by the samples of one class.
    pub(super) fn seen(&self, stage: &Stage, from: V, normal: V, class: usize) -> Seen {
        let ray = |direction, reach| Ray { origin: from, direction, reach };
        let mut seen = [0.0; 2];
        // Behind the horizon the lamp's light is zero anyway.
        if dot(normal, self.key) > 0.0 {
            for d in self.samples.lamp(class, self.key, self.tan) {
                seen[0] += f32::from(u8::from(!stage.bvh.occluded(&ray(d, f32::INFINITY))));
            }
        }
        if self.light.sky > 0.0 {
            for (d, part) in self.samples.sky(class, normal) {
                // Reaches of all lengths: far things count less, without a border.
                let reach = REACH * (0.1 + 0.9 * part);
                seen[1] += f32::from(u8::from(!stage.bvh.occluded(&ray(d, reach))));
            }
        }
        seen.map(|s| s / SAMPLES as f32)
    }

    /// The light that a surface sends to the viewer.
    pub(super) fn shade(&self, normal: V, albedo: V, [key, sky]: Seen) -> V {
        let lamp = self.light.key as f32 * key * dot(normal, self.key).max(0.0);
        let fill = self.light.fill as f32 * dot(normal, self.fill).max(0.0);
        let above = (self.light.sky as f32) * (0.75 + 0.25 * normal[2]);
        // The lamp is warm, the sky cool.
        const WARM: V = [1.03, 1.0, 0.95];
        const COOL: V = [0.97, 1.0, 1.05];
        [0, 1, 2].map(|c| {
            let open = several(sky, albedo[c]);
            albedo[c] * (lamp * WARM[c] + open * (above * COOL[c] + fill))
        })
    }

    /// How much darker the ground is than without shadows, in [0, 1].
    pub(super) fn ground(&self, [key, sky]: Seen) -> f32 {
        let lamp = self.light.key as f32 * self.key[2].max(0.0);
        let above = self.light.sky as f32;
        (lamp * key + above * sky) / (lamp + above).max(f32::MIN_POSITIVE)
    }
}

/// Openness to the sky with the light that the neighbourhood, of the same colour, sends back
/// (Jimenez et al. 2016, "Practical real-time strategies for accurate indirect occlusion").
fn several(open: f32, albedo: f32) -> f32 {
    let a = 2.0404 * albedo - 0.3324;
    let b = -4.7951 * albedo + 0.6417;
    let c = 2.7552 * albedo + 0.6903;
    open.max(((open * a + b) * open + c) * open)
}
