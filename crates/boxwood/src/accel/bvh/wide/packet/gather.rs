//! Rays come together: from one after the other to rows of sixteen.

use super::{GROUPS, LANES, Packet, RAYS, ROW};
use crate::accel::bvh::wide::node::Heading;
use crate::geometry::frame::Frame;
use crate::geometry::{PreparedRay, Ray};
use crate::query::Query;
use crate::simd::{F, Floats, Lanes, Mask};

/// Directions that differ by more than this in their reciprocals are not worth a packet: its boxes would be entered by rays
/// that none of its rays is near to.
const SPREAD: f32 = 0.25;

impl Packet {
    /// Takes up to [`RAYS`] rays in; `false` when they are not all tame or run to different octants or axes.
    ///
    /// The same operations as for one ray ([`PreparedRay::tame`]), sixteen at a time.
    #[inline(always)]
    pub fn gather<S: Lanes<LANES>, Q: Query>(
        &mut self,
        s: S,
        rays: &[Ray],
        queries: &[Q],
        frame: &Frame,
    ) -> bool {
        let Some(first) = rays.first() else {
            return false;
        };
        if rays.len() > RAYS || !PreparedRay::is_tame_scene(frame.scale) {
            return false;
        }
        let kz = first.direction.abs().max_axis();
        self.heading = Heading::towards(first.direction);
        // Rays in any order part company here, before all of them are copied.
        let like_first = |ray: &Ray| {
            Heading::towards(ray.direction) == self.heading && ray.direction.abs().max_axis() == kz
        };
        if ![rays.len() / 2, rays.len() - 1]
            .into_iter()
            .all(|i| like_first(&rays[i]))
        {
            return false;
        }
        self.axes = [(kz + 1) % 3, (kz + 2) % 3, kz];
        let (mut origins, mut directions) = ([ROW; 3], [ROW; 3]);
        for i in 0..RAYS {
            // Places without a ray hold the first one, which asks nothing there.
            let ray = rays.get(i).unwrap_or(first);
            let (group, lane) = (i / LANES, i % LANES);
            for k in 0..3 {
                origins[k][group][lane] = ray.origin[k];
                directions[k][group][lane] = ray.direction[k];
            }
            self.t_min[group][lane] = ray.t_min;
            // Written so that a NaN in the ray stays.
            let end = queries.get(i).map_or(f32::INFINITY, Query::t_max);
            self.found.t_max[group][lane] = if end < ray.t_max { end } else { ray.t_max };
        }
        self.found.clear();
        let splat = F::<S, LANES>::splat;
        let load = F::<S, LANES>::load;
        let (zero, one) = (splat(s, 0.0), splat(s, 1.0));
        let (mut least_inverse, mut most_inverse) = (
            [splat(s, f32::INFINITY); 3],
            [splat(s, f32::NEG_INFINITY); 3],
        );
        let (mut least_origin, mut most_origin) = (least_inverse, most_inverse);
        for group in 0..GROUPS {
            let o = [
                load(s, &origins[0][group]),
                load(s, &origins[1][group]),
                load(s, &origins[2][group]),
            ];
            let d = [
                load(s, &directions[0][group]),
                load(s, &directions[1][group]),
                load(s, &directions[2][group]),
            ];
            let size = [d[0].abs(), d[1].abs(), d[2].abs()];
            let distance = [o[0].abs(), o[1].abs(), o[2].abs()];
            let [kx, ky, kz] = self.axes;
            let t_min = zero.max(load(s, &self.t_min[group]));
            // The second one where the ray's is NaN: no comparison then holds.
            let t_max = splat(s, f32::MAX).min(load(s, &self.found.t_max[group]));
            // In one octant, with the same longest axis (the lowest wins a tie), and inside the doors.
            let mut alike = t_min.le(t_max)
                & (distance[0] + distance[1] + distance[2]).lt(splat(s, PreparedRay::DOORS[1]))
                & (size[0] + size[1] + size[2]).lt(splat(s, PreparedRay::DOORS[1]))
                & splat(s, PreparedRay::DOORS[0]).lt(size[kz]);
            for k in [kx, ky] {
                alike = alike
                    & if k < kz {
                        size[k].lt(size[kz])
                    } else {
                        size[k].le(size[kz])
                    };
            }
            for k in 0..3 {
                alike = alike
                    & if self.heading.is_down(k) {
                        d[k].lt(zero)
                    } else {
                        zero.le(d[k])
                    };
            }
            if alike.bits() != u32::MAX >> (32 - LANES) {
                return false;
            }
            let [cx, cy, cz, _] = frame.centre;
            let seen = [
                o[0] - splat(s, cx),
                o[1] - splat(s, cy),
                o[2] - splat(s, cz),
            ];
            let reach = seen[0].abs().max(seen[1].abs()).max(seen[2].abs());
            let slack = splat(s, self.precision.slack()) * (splat(s, frame.reach) + reach);
            let floor = splat(s, PreparedRay::FLOOR) * size[kz];
            for k in 0..3 {
                let raised = if self.heading.is_down(k) {
                    d[k].min(zero - floor)
                } else {
                    d[k].max(floor)
                };
                let inverse = one / raised;
                let pad = inverse.abs() * slack;
                let back = (zero - seen[k]) * inverse;
                self.inverse[k][group] = inverse.to_array();
                self.enter[k][group] = (back - pad).to_array();
                self.leave[k][group] = (back + pad).to_array();
                least_inverse[k] = least_inverse[k].min(inverse);
                most_inverse[k] = most_inverse[k].max(inverse);
                least_origin[k] = least_origin[k].min(seen[k] - slack);
                most_origin[k] = most_origin[k].max(seen[k] + slack);
            }
            self.shear[0][group] = (d[kx] / d[kz]).to_array();
            self.shear[1][group] = (d[ky] / d[kz]).to_array();
            self.shear[2][group] = (one / d[kz]).to_array();
            self.t_min[group] = t_min.to_array();
            self.found.t_max[group] = t_max.to_array();
        }
        for k in 0..3 {
            self.origin[k] = origins[self.axes[k]];
            self.least_inverse[k] = least(least_inverse[k].to_array());
            self.most_inverse[k] = most(most_inverse[k].to_array());
            self.least_origin[k] = least(least_origin[k].to_array());
            self.most_origin[k] = most(most_origin[k].to_array());
        }
        for i in rays.len()..RAYS {
            self.found.t_max[i / LANES][i % LANES] = f32::NEG_INFINITY;
        }
        self.is_narrow()
    }

    /// Whether the directions are alike. The longest axis says by how much the others may differ.
    fn is_narrow(&self) -> bool {
        let [_, _, kz] = self.axes;
        let unit = self.least_inverse[kz]
            .abs()
            .min(self.most_inverse[kz].abs());
        (0..3).all(|k| {
            // In slopes, not in reciprocals, which grow without bound as a direction turns away from an axis.
            let slope = |inverse: f32| unit / inverse;
            (slope(self.least_inverse[k]) - slope(self.most_inverse[k])).abs() < SPREAD
        })
    }
}

#[inline(always)]
fn least(row: [f32; LANES]) -> f32 {
    halved(row, |a, b| if a < b { a } else { b })
}

/// The largest of a row.
#[inline(always)]
pub fn most(row: [f32; LANES]) -> f32 {
    halved(row, |a, b| if a > b { a } else { b })
}

/// One number of a row, by halves: four steps, one after the other, instead of fifteen.
#[inline(always)]
fn halved(mut row: [f32; LANES], better: impl Fn(f32, f32) -> f32) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            row[i] = better(row[i], row[i + half]);
        }
        half /= 2;
    }
    row[0]
}
