//! Embree's interface, declared by hand.
//!
//! *How it works.* The library is opened at run time, so that nothing needs it to compile. The declarations follow
//! Embree 4.4's `rtcore.h`; a ray with its hit is 96 bytes, as `RTCRayHit` is in a release with arrays of instances.
//! What leaves this module is safe: a [`Scene`] owns its device and its buffers, and asks about slices of any length.

use boxwood::{Hit, Ray, TriangleMesh};
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering::Relaxed};

/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;
/// `RTC_RAY_QUERY_FLAG_COHERENT`.
const COHERENT: c_uint = 1 << 16;
/// `RTC_FEATURE_FLAGS_ALL`.
const ALL_FEATURES: c_uint = u32::MAX;
/// `RTC_GEOMETRY_TYPE_TRIANGLE`.
const TRIANGLE: c_uint = 0;
/// `RTC_BUFFER_TYPE_INDEX`, `RTC_BUFFER_TYPE_VERTEX`.
const INDEX: c_uint = 0;
const VERTEX: c_uint = 1;
/// `RTC_FORMAT_UINT3`, `RTC_FORMAT_FLOAT3`.
const UINT3: c_uint = 0x5003;
const FLOAT3: c_uint = 0x9003;
/// `RTC_SCENE_FLAG_ROBUST`.
pub const ROBUST: c_uint = 1 << 2;
/// `RTC_SCENE_FLAG_COMPACT`.
pub const COMPACT: c_uint = 1 << 1;

/// What `RTCRay` holds, or `RTCRay16` of `[_; 16]`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Rays<F, U> {
    origin: [F; 3],
    near: F,
    direction: [F; 3],
    time: F,
    far: F,
    mask: U,
    id: U,
    flags: U,
}

/// What `RTCHit` holds, or `RTCHit16` of `[_; 16]`.
#[repr(C)]
#[derive(Clone, Copy)]
struct Hits<F, U> {
    normal: [F; 3],
    u: F,
    v: F,
    primitive: U,
    geometry: U,
    instance: U,
    instance_primitive: U,
}

/// `RTCRay`.
#[repr(C, align(16))]
struct OneRay(Rays<f32, u32>);

/// `RTCRayHit`.
#[repr(C, align(16))]
struct OneRayHit {
    ray: Rays<f32, u32>,
    hit: Hits<f32, u32>,
}

const WIDTH: usize = 16;
type Lanes<T> = [T; WIDTH];

/// `RTCRay16`.
#[repr(C, align(64))]
struct Packet(Rays<Lanes<f32>, Lanes<u32>>);

/// `RTCRayHit16`.
#[repr(C, align(64))]
struct PacketHit {
    rays: Rays<Lanes<f32>, Lanes<u32>>,
    hits: Hits<Lanes<f32>, Lanes<u32>>,
}

const _: () = {
    assert!(size_of::<OneRay>() == 48 && size_of::<OneRayHit>() == 96);
    assert!(std::mem::offset_of!(OneRayHit, hit) == 48);
    assert!(size_of::<Packet>() == 12 * 64 && size_of::<PacketHit>() == 21 * 64);
    assert!(std::mem::offset_of!(PacketHit, hits) == 12 * 64);
};

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which are alike.
#[repr(C)]
struct Arguments {
    flags: c_uint,
    features: c_uint,
    context: *mut c_void,
    filter: *mut c_void,
    function: *mut c_void,
    /// Builds with `RTC_MIN_WIDTH` read one more number; others do not look at it.
    min_width: f32,
}

/// `valid` of the packet functions, which must be aligned to 64 bytes.
#[repr(C, align(64))]
struct Valid(Lanes<c_int>);

type Handle = *mut c_void;
type Monitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// The functions of a loaded library.
pub struct Embree {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: unsafe extern "C" fn(Handle),
    device_error: unsafe extern "C" fn(Handle) -> c_uint,
    device_property: unsafe extern "C" fn(Handle, c_uint) -> isize,
    set_monitor: unsafe extern "C" fn(Handle, Option<Monitor>, *mut c_void),
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    release_scene: unsafe extern "C" fn(Handle),
    set_scene_flags: unsafe extern "C" fn(Handle, c_uint),
    set_scene_quality: unsafe extern "C" fn(Handle, c_uint),
    commit_scene: unsafe extern "C" fn(Handle),
    new_geometry: unsafe extern "C" fn(Handle, c_uint) -> Handle,
    release_geometry: unsafe extern "C" fn(Handle),
    set_geometry_quality: unsafe extern "C" fn(Handle, c_uint),
    new_buffer: unsafe extern "C" fn(Handle, c_uint, c_uint, c_uint, usize, usize) -> *mut c_void,
    commit_geometry: unsafe extern "C" fn(Handle),
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    intersect_1: unsafe extern "C" fn(Handle, *mut OneRayHit, *mut Arguments),
    occluded_1: unsafe extern "C" fn(Handle, *mut OneRay, *mut Arguments),
    intersect_16: unsafe extern "C" fn(*const c_int, Handle, *mut PacketHit, *mut Arguments),
    occluded_16: unsafe extern "C" fn(*const c_int, Handle, *mut Packet, *mut Arguments),
    /// Dropped last, and in this order.
    _embree: Library,
    _tbb: Library,
}

impl Embree {
    /// Opens the library, after the one that it needs.
    ///
    /// # Errors
    /// What the system's loader says.
    pub fn open(tbb: &Path, embree: &Path) -> Result<Self, String> {
        let open = |path: &Path| {
            // SAFETY: the initialisers of TBB and Embree, as released, may run at any time.
            unsafe { Library::new(path) }.map_err(|e| format!("{}: {e}", path.display()))
        };
        let tbb = open(tbb)?;
        let library = open(embree)?;
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type of the field that this goes to is that of `rtcore.h`, and the library stays open as
                // long as the field exists.
                *unsafe { library.get($name) }.map_err(|e| format!("{}: {e}", embree.display()))?
            };
        }
        Ok(Self {
            new_device: function!(b"rtcNewDevice"),
            release_device: function!(b"rtcReleaseDevice"),
            device_error: function!(b"rtcGetDeviceError"),
            device_property: function!(b"rtcGetDeviceProperty"),
            set_monitor: function!(b"rtcSetDeviceMemoryMonitorFunction"),
            new_scene: function!(b"rtcNewScene"),
            release_scene: function!(b"rtcReleaseScene"),
            set_scene_flags: function!(b"rtcSetSceneFlags"),
            set_scene_quality: function!(b"rtcSetSceneBuildQuality"),
            commit_scene: function!(b"rtcCommitScene"),
            new_geometry: function!(b"rtcNewGeometry"),
            release_geometry: function!(b"rtcReleaseGeometry"),
            set_geometry_quality: function!(b"rtcSetGeometryBuildQuality"),
            new_buffer: function!(b"rtcSetNewGeometryBuffer"),
            commit_geometry: function!(b"rtcCommitGeometry"),
            attach_geometry: function!(b"rtcAttachGeometry"),
            intersect_1: function!(b"rtcIntersect1"),
            occluded_1: function!(b"rtcOccluded1"),
            intersect_16: function!(b"rtcIntersect16"),
            occluded_16: function!(b"rtcOccluded16"),
            _embree: library,
            _tbb: tbb,
        })
    }
}

/// A scene of one triangle mesh with its own device.
pub struct Scene {
    embree: Arc<Embree>,
    device: Handle,
    scene: Handle,
    /// What Embree says it has allocated; it is told where to count.
    bytes: Box<AtomicIsize>,
    /// Of the two buffers that Embree keeps instead of the caller.
    buffers: isize,
}

// SAFETY: Embree's documentation allows queries of a committed scene from any number of threads, and its handles belong
// to no thread. Nothing but queries takes `&self`.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

/// Adds to the count of bytes.
unsafe extern "C" fn count_bytes(count: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `count` is the `AtomicIsize` of the scene whose device calls, which outlives the device.
    unsafe { &*count.cast::<AtomicIsize>() }.fetch_add(bytes, Relaxed);
    true
}

impl Scene {
    /// A scene that holds a copy of the mesh and is not committed yet. `config` is that of `rtcNewDevice`; `flags` are any of
    /// [`ROBUST`] and [`COMPACT`]; `quality` is 0, 1 or 2 for low, medium or high.
    ///
    /// # Errors
    /// When Embree cannot make a device or has no memory.
    pub fn new(
        embree: &Arc<Embree>,
        config: &str,
        flags: c_uint,
        quality: u32,
        mesh: &TriangleMesh,
    ) -> Result<Self, String> {
        let config = CString::new(config).map_err(|e| e.to_string())?;
        let bytes = Box::new(AtomicIsize::new(0));
        // SAFETY: a string that ends in zero, read during the call.
        let device = unsafe { (embree.new_device)(config.as_ptr()) };
        if device.is_null() {
            // SAFETY: a null device asks why the last one could not be made.
            let code = unsafe { (embree.device_error)(ptr::null_mut()) };
            return Err(format!("rtcNewDevice failed with error {code}"));
        }
        let count = (&raw const *bytes).cast_mut().cast();
        // SAFETY: the device was just made; `count_bytes` gets the address of a counter that lives in its box until
        // `drop` has released the device.
        let scene = unsafe {
            (embree.set_monitor)(device, Some(count_bytes), count);
            (embree.new_scene)(device)
        };
        let (positions, triangles) = (mesh.positions(), mesh.triangles());
        let made = Self {
            embree: Arc::clone(embree),
            device,
            scene,
            bytes,
            buffers: (size_of_val(positions) + size_of_val(triangles)) as isize,
        };
        // SAFETY: all handles are fresh. Each buffer has room for as many elements as are asked for, each of 12 bytes,
        // which is how large a position (three floats, `repr(C)`) and a triangle (three indices) are; the copies do not
        // overlap, and a null pointer is not written to. The scene keeps the geometry alive.
        unsafe {
            (embree.set_scene_quality)(scene, quality);
            (embree.set_scene_flags)(scene, flags);
            let geometry = (embree.new_geometry)(device, TRIANGLE);
            (embree.set_geometry_quality)(geometry, quality);
            let vertices = (embree.new_buffer)(geometry, VERTEX, 0, FLOAT3, 12, positions.len());
            let indices = (embree.new_buffer)(geometry, INDEX, 0, UINT3, 12, triangles.len());
            if !vertices.is_null() && !indices.is_null() {
                let from = positions.as_ptr().cast::<u8>();
                ptr::copy_nonoverlapping(from, vertices.cast(), size_of_val(positions));
                let from = triangles.as_ptr().cast::<u8>();
                ptr::copy_nonoverlapping(from, indices.cast(), size_of_val(triangles));
                (embree.commit_geometry)(geometry);
                (embree.attach_geometry)(scene, geometry);
            }
            (embree.release_geometry)(geometry);
        }
        made.checked()
    }

    /// Builds the tree.
    ///
    /// # Errors
    /// When Embree does, by number.
    pub fn commit(self) -> Result<Self, String> {
        // SAFETY: the scene lives, and nobody asks it yet: `self` is owned.
        unsafe { (self.embree.commit_scene)(self.scene) };
        self.checked()
    }

    fn checked(self) -> Result<Self, String> {
        // SAFETY: the device lives as long as `self`.
        match unsafe { (self.embree.device_error)(self.device) } {
            0 => Ok(self),
            4 => Err("Embree is out of memory".to_string()),
            code => Err(format!("Embree reports error {code}")),
        }
    }

    /// `4.4.0`.
    pub fn version(&self) -> String {
        // SAFETY: the device lives; 1 to 3 are the numbers of the version's parts.
        let part = |i| unsafe { (self.embree.device_property)(self.device, i) };
        format!("{}.{}.{}", part(1), part(2), part(3))
    }

    /// What Embree holds for the tree, without the copies of the caller's arrays.
    pub fn bytes(&self) -> usize {
        (self.bytes.load(Relaxed) - self.buffers).max(0) as usize
    }

    /// `rtcIntersect1` for each ray.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn intersect_1(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        for (ray, hit) in rays.iter().zip(hits) {
            let mut record = OneRayHit {
                ray: single(ray),
                hit: Hits {
                    normal: [0.0; 3],
                    u: 0.0,
                    v: 0.0,
                    primitive: INVALID,
                    geometry: INVALID,
                    instance: INVALID,
                    instance_primitive: INVALID,
                },
            };
            // SAFETY: the scene is committed and lives; the record is a whole `RTCRayHit`, aligned; null arguments are
            // the defaults.
            unsafe { (self.embree.intersect_1)(self.scene, &raw mut record, ptr::null_mut()) };
            *hit = (record.hit.geometry != INVALID).then_some(Hit {
                t: record.ray.far,
                u: record.hit.u,
                v: record.hit.v,
                primitive: record.hit.primitive,
                instance: 0,
            });
        }
    }

    /// `rtcOccluded1` for each ray.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn occluded_1(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer per ray");
        for (ray, occluded) in rays.iter().zip(occluded) {
            let mut record = OneRay(single(ray));
            // SAFETY: as in `intersect_1`, with a whole `RTCRay`.
            unsafe { (self.embree.occluded_1)(self.scene, &raw mut record, ptr::null_mut()) };
            // Embree says so with an end before everything.
            *occluded = record.0.far < 0.0;
        }
    }

    /// `rtcIntersect16` with the coherent flag for each sixteen rays.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn intersect_16(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        assert_eq!(rays.len(), hits.len(), "one hit per ray");
        for (rays, hits) in rays.chunks(WIDTH).zip(hits.chunks_mut(WIDTH)) {
            let mut packet = PacketHit {
                rays: gathered(rays),
                hits: Hits {
                    normal: [[0.0; WIDTH]; 3],
                    u: [0.0; WIDTH],
                    v: [0.0; WIDTH],
                    primitive: [INVALID; WIDTH],
                    geometry: [INVALID; WIDTH],
                    instance: [INVALID; WIDTH],
                    instance_primitive: [INVALID; WIDTH],
                },
            };
            let (valid, mut arguments) = (valid(rays.len()), coherent());
            // SAFETY: as in `intersect_1`; packet and mask are aligned to 64 bytes and whole.
            unsafe {
                (self.embree.intersect_16)(
                    valid.0.as_ptr(),
                    self.scene,
                    &raw mut packet,
                    &raw mut arguments,
                );
            }
            for (i, hit) in hits.iter_mut().enumerate() {
                *hit = (packet.hits.geometry[i] != INVALID).then_some(Hit {
                    t: packet.rays.far[i],
                    u: packet.hits.u[i],
                    v: packet.hits.v[i],
                    primitive: packet.hits.primitive[i],
                    instance: 0,
                });
            }
        }
    }

    /// `rtcOccluded16` with the coherent flag for each sixteen rays.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn occluded_16(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "one answer per ray");
        for (rays, occluded) in rays.chunks(WIDTH).zip(occluded.chunks_mut(WIDTH)) {
            let mut packet = Packet(gathered(rays));
            let (valid, mut arguments) = (valid(rays.len()), coherent());
            // SAFETY: as in `intersect_16`, with a whole `RTCRay16`.
            unsafe {
                (self.embree.occluded_16)(
                    valid.0.as_ptr(),
                    self.scene,
                    &raw mut packet,
                    &raw mut arguments,
                );
            }
            for (occluded, far) in occluded.iter_mut().zip(packet.0.far) {
                *occluded = far < 0.0;
            }
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: both handles are ours, and nobody can ask any more. The counter outlives this call.
        unsafe {
            (self.embree.release_scene)(self.scene);
            (self.embree.release_device)(self.device);
        }
    }
}

#[inline]
fn single(ray: &Ray) -> Rays<f32, u32> {
    Rays {
        origin: ray.origin.to_array(),
        near: ray.t_min,
        direction: ray.direction.to_array(),
        time: 0.0,
        far: ray.t_max,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    }
}

/// At most sixteen rays, lane by lane.
#[inline]
fn gathered(rays: &[Ray]) -> Rays<Lanes<f32>, Lanes<u32>> {
    let mut packet = Rays {
        origin: [[0.0; WIDTH]; 3],
        near: [0.0; WIDTH],
        direction: [[0.0; WIDTH]; 3],
        time: [0.0; WIDTH],
        far: [0.0; WIDTH],
        mask: [u32::MAX; WIDTH],
        id: [0; WIDTH],
        flags: [0; WIDTH],
    };
    for (i, ray) in rays.iter().take(WIDTH).enumerate() {
        for axis in 0..3 {
            packet.origin[axis][i] = ray.origin[axis];
            packet.direction[axis][i] = ray.direction[axis];
        }
        packet.near[i] = ray.t_min;
        packet.far[i] = ray.t_max;
    }
    packet
}

#[inline]
fn valid(rays: usize) -> Valid {
    let mut valid = Valid([0; WIDTH]);
    valid.0.iter_mut().take(rays).for_each(|lane| *lane = -1);
    valid
}

#[inline]
fn coherent() -> Arguments {
    Arguments {
        flags: COHERENT,
        features: ALL_FEATURES,
        context: ptr::null_mut(),
        filter: ptr::null_mut(),
        function: ptr::null_mut(),
        min_width: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_beyond_the_rays_are_not_valid() {
        assert_eq!(valid(3).0[..4], [-1, -1, -1, 0]);
        let rays = [Ray::new([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).until(7.0)];
        let packet = gathered(&rays);
        assert_eq!(
            (packet.origin[2][0], packet.direction[1][0], packet.far[0]),
            (3.0, 5.0, 7.0)
        );
    }
}
