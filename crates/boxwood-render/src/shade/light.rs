//! Lamps: what shines, from where, and how to aim a shadow ray at it.
//!
//! *How it works.* A lamp with a size is aimed at by well spread points; their mean is a soft shadow. A sphere is sampled by
//! the cone that it fills (nothing is wasted on its far side), a rectangle and triangles by area. Triangles of glowing
//! materials are another matter ([`super::emitters`]). *Source.* Shirley, Wang & Zimmerman 1996, *Monte Carlo Techniques
//! for Direct Lighting Calculations*.

use super::direction::in_cone;
use crate::colour::luminance;
use boxwood::{Ray, Vec3};
use boxwood_scene::LightKind;
use std::f32::consts::{PI, TAU};

/// One aim at a lamp.
pub(crate) struct Aim {
    /// Unit vector to the lamp.
    pub direction: Vec3,
    /// Where a shadow ray ends; nowhere for a lamp that is infinitely far away.
    pub end: Option<Vec3>,
    /// What the surface gets per cosine of its own: radiance by solid angle, or irradiance.
    pub light: Vec3,
    /// The triangle that shines.
    pub triangle: Option<crate::world::Triangle>,
}

/// A lamp that can be aimed at.
pub(crate) enum Lamp {
    Point {
        position: Vec3,
        intensity: Vec3,
        range: f32,
    },
    Spot {
        position: Vec3,
        axis: Vec3,
        intensity: Vec3,
        range: f32,
        scale: f32,
        offset: f32,
    },
    /// `direction` leads to the lamp, which is a disc on the sky of angular radius `radius` (0: a point).
    Far {
        direction: Vec3,
        irradiance: Vec3,
        radius: f32,
    },
    Sphere {
        center: Vec3,
        radius: f32,
        radiance: Vec3,
    },
    Rectangle {
        corner: Vec3,
        u: Vec3,
        v: Vec3,
        normal: Vec3,
        area: f32,
        radiance: Vec3,
    },
}

impl Lamp {
    /// A light of a scene; `None` when it cannot shine (no size, no direction, black or not finite).
    pub fn new(kind: &LightKind) -> Option<Self> {
        let lamp = match *kind {
            LightKind::Point {
                position,
                intensity,
                range,
            } => Self::Point {
                position: position.into(),
                intensity: intensity.into(),
                range,
            },
            LightKind::Directional {
                direction,
                irradiance,
            } => Self::Far {
                direction: -Vec3::from(direction).normalized(),
                irradiance: irradiance.into(),
                radius: 0.0,
            },
            LightKind::Spot {
                position,
                direction,
                intensity,
                inner,
                outer,
                range,
            } => {
                // As KHR_lights_punctual recommends: linear between the cosines, then squared.
                let (full, none) = (libm::cosf(inner.max(0.0)), libm::cosf(outer.clamp(0.0, PI)));
                let scale = 1.0 / (full - none).max(1.0e-3);
                Self::Spot {
                    position: position.into(),
                    axis: Vec3::from(direction).normalized(),
                    intensity: intensity.into(),
                    range,
                    scale,
                    offset: -none * scale,
                }
            }
            LightKind::Sphere {
                center,
                radius,
                radiance,
            } => Self::Sphere {
                center: center.into(),
                radius,
                radiance: radiance.into(),
            },
            LightKind::Rectangle {
                corner,
                edge_u,
                edge_v,
                radiance,
            } => {
                let (u, v) = (Vec3::from(edge_u), Vec3::from(edge_v));
                let normal = u.cross(v);
                Self::Rectangle {
                    corner: corner.into(),
                    u,
                    v,
                    area: normal.length(),
                    normal: normal.normalized(),
                    radiance: radiance.into(),
                }
            }
        };
        let (place, light, extent) = match &lamp {
            Self::Point {
                position,
                intensity,
                range,
            } => (*position, *intensity, *range),
            Self::Spot {
                position,
                axis,
                intensity,
                range,
                ..
            } => (*position, *intensity, range * axis.length()),
            Self::Far {
                direction,
                irradiance,
                ..
            } => (*direction, *irradiance, direction.length()),
            Self::Sphere {
                center,
                radius,
                radiance,
            } => (*center, *radiance, *radius),
            Self::Rectangle {
                corner,
                area,
                radiance,
                ..
            } => (*corner, *radiance, *area),
        };
        (place.is_finite() && light.is_finite() && luminance(light) > 0.0 && extent > 0.0)
            .then_some(lamp)
    }

    /// A disc on the sky.
    pub fn sun(direction: Vec3, irradiance: Vec3, radius: f32) -> Self {
        Self::Far {
            direction,
            irradiance,
            radius,
        }
    }

    /// Whether shadows have soft edges, so that several rays are worth while.
    pub fn is_soft(&self) -> bool {
        match self {
            Self::Point { .. } | Self::Spot { .. } => false,
            Self::Far { radius, .. } => *radius > 0.0,
            Self::Sphere { .. } | Self::Rectangle { .. } => true,
        }
    }

    /// Aims from a place by a point of the unit square; `None` where no light comes from there.
    pub fn aim(&self, from: Vec3, sample: [f32; 2]) -> Option<Aim> {
        match *self {
            Self::Point {
                position,
                intensity,
                range,
            } => {
                let (direction, distance) = towards(from, position)?;
                Some(Aim {
                    direction,
                    end: Some(position),
                    light: intensity * falloff(distance, range),
                    triangle: None,
                })
            }
            Self::Spot {
                position,
                axis,
                intensity,
                range,
                scale,
                offset,
            } => {
                let (direction, distance) = towards(from, position)?;
                let edge = (-direction.dot(axis) * scale + offset).clamp(0.0, 1.0);
                (edge > 0.0).then_some(Aim {
                    direction,
                    end: Some(position),
                    light: intensity * (falloff(distance, range) * edge * edge),
                    triangle: None,
                })
            }
            Self::Far {
                direction,
                irradiance,
                radius,
            } => {
                let direction = if radius > 0.0 {
                    in_cone(direction, 1.0 - libm::cosf(radius), sample)
                } else {
                    direction
                };
                Some(Aim {
                    direction,
                    end: None,
                    light: irradiance,
                    triangle: None,
                })
            }
            Self::Sphere {
                center,
                radius,
                radiance,
            } => {
                let (axis, distance) = towards(from, center)?;
                if distance <= radius {
                    return None;
                }
                let sin2 = (radius / distance) * (radius / distance);
                // 1 − cos without the cancellation for small spheres.
                let gap = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
                let direction = in_cone(axis, gap, sample);
                let along = direction.dot(center - from);
                let across2 = (distance * distance - along * along).max(0.0);
                let reach = along - (radius * radius - across2).max(0.0).sqrt();
                Some(Aim {
                    direction,
                    end: Some(from + direction * reach),
                    light: radiance * (TAU * gap),
                    triangle: None,
                })
            }
            Self::Rectangle {
                corner,
                u,
                v,
                normal,
                area,
                radiance,
            } => {
                let end = corner + u * sample[0] + v * sample[1];
                let (direction, distance) = towards(from, end)?;
                let cos = -direction.dot(normal);
                (cos > 0.0).then_some(Aim {
                    direction,
                    end: Some(end),
                    light: radiance * solid_angle(area, cos, distance),
                    triangle: None,
                })
            }
        }
    }

    /// Where a ray meets the lamp itself before `t_max`, and how it shines there. Lamps without size are not met.
    pub fn meet(&self, ray: &Ray, t_max: f32) -> Option<(f32, Vec3)> {
        match *self {
            Self::Sphere {
                center,
                radius,
                radiance,
            } => {
                let to = center - ray.origin;
                let along = to.dot(ray.direction);
                let across = to - ray.direction * along;
                let inside = radius * radius - across.length_squared();
                let t = along - inside.max(0.0).sqrt();
                (inside > 0.0 && t > 0.0 && t < t_max).then_some((t, radiance))
            }
            Self::Rectangle {
                corner,
                u,
                v,
                normal,
                area,
                radiance,
            } => {
                let slope = ray.direction.dot(normal);
                let t = (corner - ray.origin).dot(normal) / slope;
                if !(slope < 0.0 && t > 0.0 && t < t_max) {
                    return None;
                }
                let p = ray.at(t) - corner;
                let (a, b) = (p.cross(v).dot(normal) / area, u.cross(p).dot(normal) / area);
                ((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b)).then_some((t, radiance))
            }
            _ => None,
        }
    }
}

pub(crate) fn towards(from: Vec3, to: Vec3) -> Option<(Vec3, f32)> {
    let way = to - from;
    let distance = way.length();
    (distance > 0.0 && distance.is_finite()).then(|| (way.normalized(), distance))
}

/// The square law, fading out to nothing at the range as KHR_lights_punctual recommends.
fn falloff(distance: f32, range: f32) -> f32 {
    let share = distance / range;
    let window = 1.0 - share * share * share * share;
    window.clamp(0.0, 1.0) / (distance * distance)
}

/// The solid angle of a small area, at most the half sphere: nearness must not make fireflies.
pub(crate) fn solid_angle(area: f32, cos: f32, distance: f32) -> f32 {
    (area * cos / (distance * distance)).min(TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean over aims is the irradiance that a formula gives.
    fn irradiance(lamp: &Lamp, from: Vec3, normal: Vec3) -> f32 {
        let n = 64;
        let mut sum = 0.0;
        for i in 0..n * n {
            let sample = [(i % n) as f32 + 0.5, (i / n) as f32 + 0.5].map(|x| x / n as f32);
            if let Some(aim) = lamp.aim(from, sample) {
                sum += aim.light.x * aim.direction.dot(normal).max(0.0);
            }
        }
        sum / (n * n) as f32
    }

    const UP: Vec3 = Vec3::new(0.0, 1.0, 0.0);

    #[test]
    fn a_sphere_lights_as_its_view_factor_says() {
        let kind = LightKind::Sphere {
            center: [0.0, 3.0, 0.0],
            radius: 1.0,
            radiance: [2.0; 3],
        };
        let lamp = Lamp::new(&kind).expect("it shines");
        let found = irradiance(&lamp, Vec3::ZERO, UP);
        let exact = 2.0 * PI / 9.0;
        assert!((found - exact).abs() < 0.01 * exact, "{found} {exact}");
    }

    #[test]
    fn a_small_rectangle_lights_like_a_point_and_only_in_front() {
        let rectangle = |v: f32| LightKind::Rectangle {
            corner: [-0.05, 5.0, -0.05 * v],
            edge_u: [0.1, 0.0, 0.0],
            edge_v: [0.0, 0.0, 0.1 * v],
            radiance: [3.0; 3],
        };
        let down = Lamp::new(&rectangle(1.0)).expect("it shines");
        let found = irradiance(&down, Vec3::ZERO, UP);
        let exact = 3.0 * 0.01 / 25.0;
        assert!((found - exact).abs() < 0.01 * exact, "{found} {exact}");
        let up = Lamp::new(&rectangle(-1.0)).expect("it shines");
        assert_eq!(irradiance(&up, Vec3::ZERO, UP), 0.0);
        let ray = Ray::new([0.0; 3], UP);
        assert_eq!(down.meet(&ray, 9.0).map(|(t, _)| t), Some(5.0));
        assert!(down.meet(&ray, 4.0).is_none() && up.meet(&ray, 9.0).is_none());
    }

    #[test]
    fn spots_are_full_inside_and_dark_outside() {
        let kind = LightKind::Spot {
            position: [0.0, 2.0, 0.0],
            direction: [0.0, -1.0, 0.0],
            intensity: [8.0; 3],
            inner: 0.2,
            outer: 0.6,
            range: f32::INFINITY,
        };
        let lamp = Lamp::new(&kind).expect("it shines");
        let at = |x: f32| {
            lamp.aim(Vec3::new(x, 0.0, 0.0), [0.5; 2])
                .map_or(0.0, |aim| aim.light.x)
        };
        assert_eq!(at(0.0), 2.0);
        assert!(at(0.8) > 0.0 && at(0.8) < at(0.3));
        assert_eq!(at(2.0 * 0.61_f32.tan()), 0.0);
    }

    #[test]
    fn what_cannot_shine_is_left_out() {
        let point = |intensity: f32, x: f32| LightKind::Point {
            position: [x, 0.0, 0.0],
            intensity: [intensity; 3],
            range: f32::INFINITY,
        };
        assert!(Lamp::new(&point(1.0, 0.0)).is_some());
        assert!(Lamp::new(&point(0.0, 0.0)).is_none());
        assert!(Lamp::new(&point(f32::NAN, 0.0)).is_none());
        assert!(Lamp::new(&point(1.0, f32::INFINITY)).is_none());
        let still = LightKind::Directional {
            direction: [0.0; 3],
            irradiance: [1.0; 3],
        };
        assert!(Lamp::new(&still).is_none());
    }
}
