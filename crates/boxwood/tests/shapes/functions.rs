//! Functions of space with simple, double and many roots.

use crate::sampling::dot;
use boxwood::{Aabb, Enclosure, Formula, Implicit, Real, Segment, Torus, Vec3};

pub fn ball(p: [f64; 3]) -> f64 {
    dot(p, p) - 1.0
}

/// A tilted ring.
pub fn ring() -> Torus {
    Torus::new([0.1, -0.2, 0.05], [1.0, 2.0, -0.5], 0.7, 0.25)
}

pub fn ring_function<T: Real>(p: [T; 3]) -> T {
    let torus = ring();
    let [x, y, z] = [0, 1, 2].map(|k| p[k] - f64::from(torus.centre.to_array()[k]));
    let [a, b, c] = torus.axis.to_array().map(f64::from);
    let l = (a * a + b * b + c * c).sqrt();
    let height = (x * a + y * b + z * c) / l;
    let (major, minor) = (f64::from(torus.major), f64::from(torus.minor));
    let square = x.square() + y.square() + z.square();
    (square + (major * major - minor * minor)).square()
        - (square - height.square()) * (4.0 * major * major)
}

pub const AROUND: Aabb = Aabb {
    lower: Vec3::splat(-1.25),
    upper: Vec3::splat(1.25),
};

macro_rules! formula {
    ($name:ident, $p:ident => $value:expr) => {
        #[derive(Clone, Copy)]
        pub struct $name;
        impl Formula for $name {
            fn bounds(&self) -> Aabb {
                AROUND
            }
            fn at<T: Real>(&self, $p: [T; 3]) -> T {
                $value
            }
        }
    };
}
formula!(Ball, p => p[0].square() + p[1].square() + p[2].square() - 1.0);
formula!(Ring, p => ring_function(p));
formula!(Gyroid, p => {
    let [x, y, z] = p.map(|x| x * 5.0);
    x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
});
formula!(Metaballs, p => {
    let [x, y, z] = p;
    let blob = |cx: f64, cy: f64, cz: f64| {
        (-((x - cx).square() + (y - cy).square() + (z - cz).square()) * 9.0).exp()
    };
    T::from(0.3) - blob(0.4, 0.0, 0.0) - blob(-0.3, 0.3, 0.1) - blob(0.0, -0.5, -0.2)
});
// Touches zero on the whole sphere and never crosses it.
formula!(Touching, p => (p[0].square() + p[1].square() + p[2].square() - 1.0).square());

// Goursat's quartic with four double points; several sheets.
formula!(Tangled, p => {
    let [x, y, z] = p.map(|x| x * 2.6);
    let quartic = |x: T| x.powi(4) - x.square() * 5.0;
    quartic(x) + quartic(y) + quartic(z) + 11.8
});

/// A ball by its distance alone.
#[derive(Clone, Copy)]
pub struct Distance;
impl Implicit for Distance {
    fn bounds(&self) -> Aabb {
        AROUND
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        dot(p, p).sqrt() - 1.0
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        part.lipschitz(self.value(part.middle()), 1.0)
    }
}

/// The gyroid by constants: its gradient has no more than √3 · 2 · 5 and changes by no more than 3 · 25 (each second
/// derivative is at most 2 · 25, most are 25).
#[derive(Clone, Copy)]
pub struct SmoothGyroid;
impl Implicit for SmoothGyroid {
    fn bounds(&self) -> Aabb {
        AROUND
    }
    fn value(&self, p: [f64; 3]) -> f64 {
        Gyroid.at(p)
    }
    fn gradient(&self, p: [f64; 3]) -> [f64; 3] {
        Gyroid.gradient(p)
    }
    fn enclose(&self, part: &Segment) -> Enclosure {
        let m = part.middle();
        part.smooth(self.value(m), self.gradient(m), 100.0)
    }
}
