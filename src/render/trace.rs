//! From rays to pixels.

use super::{
    Lighting, PAPER, Picture, View,
    camera::Camera,
    geometry::{Stage, encoded, linear},
    light::{Lamps, Seen},
    sampling::{CLASSES, class, sobol},
    vector::{V, add, along, dot, scale, sub},
};
use rayon::prelude::*;

/// Points of a pixel on an edge.
const POINTS: usize = 16;
/// Sum of the neighbours' weights below which a pixel takes samples of its own, and how many
/// classes of them.
const LONELY: f32 = 4.0;
const MORE: usize = 4;

/// What is seen at a point of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Paper,
    Ground,
    Surface,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    kind: Kind,
    point: V,
    lifted: V,
    normal: V,
    albedo: V,
    /// Width of a pixel there.
    pixel: f32,
}

/// All that does not change while a picture is drawn.
struct Scene<'a> {
    stage: &'a Stage,
    camera: &'a Camera,
    lamps: Lamps,
    ground: bool,
    size: [usize; 2],
}

pub(super) fn draw(
    stage: &Stage,
    camera: &Camera,
    view: &View,
    light: &Lighting,
    size: [usize; 2],
) -> Picture {
    let scene = Scene { stage, camera, lamps: Lamps::new(light, view), ground: light.ground, size };
    let samples = scene.all(|x, y, _| scene.sample(x as f32 + 0.5, y as f32 + 0.5));
    let raw = scene.all(|x, y, n| scene.seen(&samples[n], class(x, y)));
    let seen = scene.all(|x, y, n| scene.smooth(&samples, &raw, [x, y], n));
    let pixels = scene.all(|x, y, n| {
        let color = if scene.is_edge(&samples, [x, y]) {
            scene.edge(&samples, &seen, [x, y])
        } else {
            scene.color(&samples[n], seen[n])
        };
        encoded(color)
    });
    Picture { size, pixels }
}

impl Scene<'_> {
    /// A value for each pixel, from x, y and its number.
    fn all<T: Send>(&self, f: impl Fn(usize, usize, usize) -> T + Sync) -> Vec<T> {
        let [w, h] = self.size;
        (0..w * h).into_par_iter().with_min_len(64).map(|n| f(n % w, n / w, n)).collect()
    }

    /// What is seen at a point (pixels).
    fn sample(&self, x: f32, y: f32) -> Sample {
        let ray = self.camera.ray(x, y);
        if let Some(hit) = self.stage.bvh.closest(&ray) {
            let spot = self.stage.spot(&ray, &hit);
            return Sample {
                kind: Kind::Surface,
                point: spot.point,
                lifted: spot.lifted,
                normal: spot.normal,
                albedo: spot.albedo,
                pixel: self.camera.pixel(hit.distance),
            };
        }
        let up = [0.0, 0.0, 1.0];
        let distance = (self.stage.floor - ray.origin[2]) / ray.direction[2];
        let on_ground = self.ground && ray.direction[2] < 0.0 && distance > 0.0;
        let point = along(ray.origin, if on_ground { distance } else { 0.0 }, ray.direction);
        Sample {
            kind: if on_ground { Kind::Ground } else { Kind::Paper },
            point,
            lifted: point,
            normal: up,
            albedo: [0.0; 3],
            pixel: self.camera.pixel(distance),
        }
    }

    /// The light there, by the samples of one class.
    fn seen(&self, sample: &Sample, class: usize) -> Seen {
        match sample.kind {
            Kind::Paper => [1.0; 2],
            _ => self.lamps.seen(self.stage, sample.lifted, sample.normal, class),
        }
    }

    /// The light there, averaged over 4 x 4 pixels where they see the same surface.
    fn smooth(&self, samples: &[Sample], raw: &[Seen], [x, y]: [usize; 2], n: usize) -> Seen {
        let sample = &samples[n];
        if sample.kind == Kind::Paper {
            return [1.0; 2];
        }
        let mut sum = [0.0; 3];
        for v in (y.max(1) - 1)..(y + 3).min(self.size[1]) {
            for u in (x.max(1) - 1)..(x + 3).min(self.size[0]) {
                let m = v * self.size[0] + u;
                gather(&mut sum, likeness(sample, &samples[m]), raw[m]);
            }
        }
        if sum[2] < LONELY {
            let first = class(x, y) + 1;
            (first..first + MORE)
                .for_each(|c| gather(&mut sum, 1.0, self.seen(sample, c % CLASSES)));
        }
        [sum[0] / sum[2], sum[1] / sum[2]]
    }

    /// Whether the picture jumps between a pixel and its neighbours.
    fn is_edge(&self, samples: &[Sample], [x, y]: [usize; 2]) -> bool {
        let sample = &samples[y * self.size[0] + x];
        let rows = y.max(1) - 1..(y + 2).min(self.size[1]);
        rows.into_iter().any(|v| {
            let columns = x.max(1) - 1..(x + 2).min(self.size[0]);
            columns.into_iter().any(|u| {
                let other = &samples[v * self.size[0] + u];
                let off = dot(sub(other.point, sample.point), sample.normal).abs();
                let colors = sub(other.albedo, sample.albedo);
                other.kind != sample.kind
                    || sample.kind == Kind::Surface
                        && (dot(other.normal, sample.normal) < 0.9
                            || off > 2.0 * sample.pixel
                            || dot(colors, colors) > 1e-3)
            })
        })
    }

    /// The mean colour of several points of a pixel, with the light of the pixels around.
    fn edge(&self, samples: &[Sample], seen: &[Seen], [x, y]: [usize; 2]) -> V {
        let mut sum = [0.0; 3];
        for n in 0..POINTS {
            let [u, v] = sobol(n);
            let sample = self.sample(x as f32 + u, y as f32 + v);
            let mut light = [0.0; 3];
            for v in (y.max(1) - 1)..(y + 2).min(self.size[1]) {
                for u in (x.max(1) - 1)..(x + 2).min(self.size[0]) {
                    let m = v * self.size[0] + u;
                    gather(&mut light, likeness(&sample, &samples[m]), seen[m]);
                }
            }
            if light[2] < 0.05 {
                // No pixel's middle sees this surface.
                let first = class(x, y) + n;
                (first..first + 2)
                    .for_each(|c| gather(&mut light, 1.0, self.seen(&sample, c % CLASSES)));
            }
            let light = [light[0] / light[2], light[1] / light[2]];
            sum = add(sum, self.color(&sample, light).map(|c| c.min(1.0)));
        }
        scale(sum, 1.0 / POINTS as f32)
    }

    fn color(&self, sample: &Sample, seen: Seen) -> V {
        match sample.kind {
            Kind::Paper => linear(PAPER),
            Kind::Ground => {
                // Fades where the ground ends.
                let far = sample.point[0].hypot(sample.point[1]);
                let fade = (1.0 - (far - 1.0) / 3.0).clamp(0.0, 1.0);
                let dark = 1.0 - self.lamps.ground(seen);
                scale(linear(PAPER), 1.0 - 0.75 * fade * dark)
            }
            Kind::Surface => self.lamps.shade(sample.normal, sample.albedo, seen),
        }
    }
}

fn gather(sum: &mut [f32; 3], weight: f32, seen: Seen) {
    sum[0] += weight * seen[0];
    sum[1] += weight * seen[1];
    sum[2] += weight;
}

/// How much the light at `b` tells of that at `a`, in [0, 1]: whether they are on one smooth
/// surface.
fn likeness(a: &Sample, b: &Sample) -> f32 {
    if a.kind != b.kind {
        return 0.0;
    }
    if a.kind == Kind::Ground {
        return 1.0;
    }
    let turned = dot(a.normal, b.normal).max(0.0).powi(24);
    let off = dot(sub(b.point, a.point), a.normal) / (1.5 * a.pixel);
    turned / (1.0 + off.powi(4))
}
