//! The scene: a column that twists, a floor, and balls.

use boxwood::{
    Affine, BinnedSah, Committed, Handle, Hit, Instance, InstanceError, MeshError, Object, Ray,
    Surface, Surfaces, TopLevel, TriangleMesh, Updated, Upkeep, Vec3, WideBvh, WideSah,
};
use std::f32::consts::TAU;
use std::sync::Arc;

/// All that moves.
pub struct Stage {
    column: Upkeep<TriangleMesh, 8>,
    /// The column's vertices when it is not twisted.
    straight: Vec<Vec3>,
    /// Those of the next frame.
    next: Vec<Vec3>,
    objects: TopLevel,
    meshes: [Arc<TriangleMesh>; 2],
    balls: Vec<Handle>,
}

const BALL: u32 = 0;
const FLOOR: u32 = 1;

/// A surface over two parameters from 0 to 1.
fn surface(
    across: usize,
    along: usize,
    at: impl Fn(f32, f32) -> Vec3,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let share = |i: usize, of: usize| i as f32 / of as f32;
    let rows = (0..=along).map(|j| share(j, along));
    let point = |v: f32| (0..=across).map(move |i| (share(i, across), v));
    let points = rows.flat_map(point).map(|(u, v)| at(u, v)).collect();
    let mut triangles = Vec::with_capacity(2 * across * along);
    for j in 0..along {
        for i in 0..across {
            let a = (j * (across + 1) + i) as u32;
            let c = a + across as u32 + 1;
            triangles.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
        }
    }
    (points, triangles)
}

fn turned(p: Vec3, angle: f32) -> Vec3 {
    let (sine, cosine) = (libm::sinf(angle), libm::cosf(angle));
    Vec3::new(cosine * p.x - sine * p.z, p.y, sine * p.x + cosine * p.z)
}

/// A column with four ribs, 3 high.
fn column(u: f32, v: f32) -> Vec3 {
    let width = 0.45 + 0.3 * libm::cosf(4.0 * TAU * u);
    turned(Vec3::new(width, 3.0 * v, 0.0), TAU * u)
}

fn ball(u: f32, v: f32) -> Vec3 {
    let polar = 0.5 * TAU * v;
    let ring = turned(Vec3::new(libm::sinf(polar), 0.0, 0.0), TAU * u);
    ring + Vec3::new(0.0, libm::cosf(polar), 0.0)
}

fn object(mesh: &Arc<TriangleMesh>, number: u32) -> Object {
    let tree = BinnedSah::default().build(mesh);
    let structure = WideBvh::<_, 8>::new(mesh.clone(), &tree);
    Object::new(mesh, Arc::new(structure)).numbered(number)
}

impl Stage {
    /// A column of about so many triangles and so many balls, for so many rays a frame.
    pub fn new(
        triangles: usize,
        balls: usize,
        rays: f64,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let side = libm::sqrt(triangles as f64 / 2.0).max(4.0) as usize;
        let (straight, faces) = surface(side, side, column);
        let mesh = TriangleMesh::new(straight.iter().copied(), faces)?;
        let (points, faces) = surface(32, 16, ball);
        let ball = Arc::new(TriangleMesh::new(points, faces)?);
        let (points, faces) = surface(1, 1, |u, v| Vec3::new(16.0 * u - 8.0, 0.0, 16.0 * v - 8.0));
        let floor = Arc::new(TriangleMesh::new(points, faces)?);
        let objects = TopLevel::new([object(&ball, BALL), object(&floor, FLOOR)])?;
        let mut stage = Self {
            column: Upkeep::new(mesh, WideSah::default(), rays),
            next: straight.clone(),
            straight,
            objects: objects.for_rays(rays),
            meshes: [ball, floor],
            balls: Vec::new(),
        };
        stage
            .objects
            .insert(Instance::new(FLOOR, Affine::IDENTITY))?;
        for number in 0..balls {
            stage.add(number, 0.0)?;
        }
        stage.commit();
        Ok(stage)
    }

    /// The column and its tree.
    pub fn column(&self) -> &Upkeep<TriangleMesh, 8> {
        &self.column
    }
    /// Everything else.
    pub fn objects(&self) -> &TopLevel {
        &self.objects
    }

    /// Works out where the column's vertices go at a moment from 0 to 1: it is twisted and untwisted twice.
    pub fn bend(&mut self, moment: f32) {
        let twist = 4.0 * libm::sinf(2.0 * TAU * moment);
        let lean = libm::sinf(3.0 * TAU * moment);
        for (next, &p) in self.next.iter_mut().zip(&self.straight) {
            let aside = 0.12 * lean * p.y * p.y;
            *next = turned(p, twist * p.y) + Vec3::new(aside, 0.0, 0.0);
        }
    }

    /// The column follows.
    pub fn update(&mut self) -> Result<Updated, MeshError> {
        let (moved, updated) = self
            .column
            .update(|mesh| mesh.swap_vertices(&mut self.next));
        moved.map(|()| updated)
    }

    /// Moves all balls; every eighth frame one of them goes and another one comes.
    pub fn rearrange(&mut self, frame: usize, moment: f32) -> Result<(), InstanceError> {
        if frame.is_multiple_of(8) {
            let first = self.balls.remove(0);
            self.objects.remove(first);
            self.add(self.balls.len() + frame, moment)?;
        }
        for (number, &handle) in self.balls.iter().enumerate() {
            self.objects.move_to(handle, path(number, moment))?;
        }
        Ok(())
    }

    /// Shows rays what has happened to the objects.
    pub fn commit(&mut self) -> Committed {
        self.objects.commit()
    }

    fn add(&mut self, number: usize, moment: f32) -> Result<(), InstanceError> {
        let ball = Instance::new(BALL, path(number, moment));
        self.balls.push(self.objects.insert(ball)?);
        Ok(())
    }

    /// The surface at a hit of the objects, and whether it is the floor's.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (Surface, bool) {
        let set = self.objects.instances();
        let number = set.object_of(hit.instance).map_or(FLOOR, Object::number);
        let mesh = &self.meshes[number as usize];
        let surface = set.surface(ray, hit, |_, ray, hit| mesh.surface(ray, hit));
        (surface, number == FLOOR)
    }
}

/// Where a ball is: on its way around the column, up and down.
fn path(number: usize, moment: f32) -> Affine {
    // Numbers that look like chance: multiples of irrational ones.
    let share = |by: f32| (number as f32 * by).fract();
    let (radius, height) = (1.2 + 1.8 * share(0.618_034), 0.3 + 2.2 * share(0.754_878));
    let laps = 1.0 + (number % 3) as f32;
    let angle = TAU * (share(0.569_84) + laps * moment);
    let bounce = 0.2 * libm::sinf(angle * 2.0);
    let at = turned(Vec3::new(radius, height + bounce, 0.0), angle);
    let size = 0.06 + 0.12 * share(0.324_718);
    Affine::scale([size; 3]).then(&Affine::translation(at))
}
