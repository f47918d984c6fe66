//! Embree 4.4: Intel's ray tracing kernels in C++, the fastest on processors and the one to be measured by.
//!
//! *Where it comes from.* The Python package `embreex` ships the released library. `pip` fetches it, once, into
//! `target/peers`; without a network, or without `pip`, the peer is absent.
//!
//! *How it is asked.* One triangle geometry, quality the same for geometry and scene, `rtcIntersect1` and `rtcOccluded1`
//! without arguments; where neighbouring rays go the same way also `rtcIntersect16` and `rtcOccluded16` with the coherent
//! flag (medium quality only). Flush-to-zero is on, as Embree's documentation recommends.

use super::ffi::embree::{self as ffi, Embree};
use super::{Built, Finished, Way};
use boxwood::{Hit, Ray, TriangleMesh};
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::FromStr;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

/// The package that holds the library; its folder has the same name.
const PACKAGE: &str = "embreex==4.4.0.post1";

/// How a scene is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    quality: Quality,
    robust: bool,
    /// Leaves of indices instead of corners.
    compact: bool,
    avx2: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quality {
    Low,
    Medium,
    High,
}

impl Variant {
    /// What `embree` alone means: medium quality, fast, the best instruction set.
    pub const FAST: Self = Self {
        quality: Quality::Medium,
        robust: false,
        compact: false,
        avx2: false,
    };
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quality = match self.quality {
            Quality::Low => Some("low"),
            Quality::Medium => None,
            Quality::High => Some("high"),
        };
        let parts = [
            quality,
            self.robust.then_some("robust"),
            self.compact.then_some("compact"),
            self.avx2.then_some("avx2"),
        ];
        let parts: Vec<&str> = parts.into_iter().flatten().collect();
        f.write_str("embree")?;
        if !parts.is_empty() {
            write!(f, ":{}", parts.join(","))?;
        }
        Ok(())
    }
}

impl FromStr for Variant {
    type Err = String;

    /// What stands behind `embree:`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut variant = Self::FAST;
        for setting in text.split(',').filter(|s| !s.is_empty()) {
            match setting {
                "low" => variant.quality = Quality::Low,
                "medium" => variant.quality = Quality::Medium,
                "high" => variant.quality = Quality::High,
                "fast" => variant.robust = false,
                "robust" => variant.robust = true,
                "compact" => variant.compact = true,
                "avx2" | "isa=avx2" => variant.avx2 = true,
                _ => {
                    return Err(format!(
                        "`embree` has no setting `{setting}`; it has low, medium, high, robust, compact and avx2"
                    ));
                }
            }
        }
        Ok(variant)
    }
}

struct Scene {
    scene: ffi::Scene,
    quality: Quality,
}

impl Built for Scene {
    fn ways(&self) -> &'static [Way] {
        match self.quality {
            Quality::Medium => &[Way::Single, Way::Packet],
            // Packets know no other order of qualities than single rays do.
            Quality::Low | Quality::High => &[Way::Single],
        }
    }
    fn bytes(&self) -> Option<usize> {
        Some(self.scene.bytes())
    }
    fn note(&self) -> Option<String> {
        Some(format!(
            "embree: version {}; `packet` is rtcIntersect16 and rtcOccluded16 with the coherent flag",
            self.scene.version()
        ))
    }
    fn closest(&self, way: Way, rays: &[Ray], hits: &mut [Option<Hit>]) {
        match way {
            Way::Packet => self.scene.intersect_16(rays, hits),
            Way::Single | Way::Batch => self.scene.intersect_1(rays, hits),
        }
    }
    fn occluded(&self, way: Way, rays: &[Ray], occluded: &mut [bool]) {
        match way {
            Way::Packet => self.scene.occluded_16(rays, occluded),
            Way::Single | Way::Batch => self.scene.occluded_1(rays, occluded),
        }
    }
}

/// Builds a scene over the mesh with so many threads.
///
/// # Errors
/// Why Embree is absent, or what it reports.
pub fn build(
    variant: Variant,
    mesh: &TriangleMesh,
    threads: usize,
) -> Result<Finished<'static>, String> {
    let embree = library()?;
    let isa = if variant.avx2 { ",isa=avx2" } else { "" };
    let config = format!("threads={threads}{isa}");
    let quality = variant.quality as u32;
    let robust = if variant.robust { ffi::ROBUST } else { 0 };
    let compact = if variant.compact { ffi::COMPACT } else { 0 };
    let flags = robust | compact;
    let scene = ffi::Scene::new(embree, &config, flags, quality, mesh)?;
    let start = Instant::now();
    let scene = scene.commit()?;
    Ok(Finished {
        seconds: start.elapsed().as_secs_f64(),
        built: Box::new(Scene {
            scene,
            quality: variant.quality,
        }),
    })
}

/// The library, fetched and opened once.
fn library() -> Result<&'static Arc<Embree>, String> {
    static LIBRARY: OnceLock<Result<Arc<Embree>, String>> = OnceLock::new();
    let library = LIBRARY.get_or_init(|| {
        if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
            return Err("it is only looked for on Linux on x86-64".to_string());
        }
        let folder = target().join("peers").join(PACKAGE.replace("==", "-"));
        if !folder.is_dir() {
            fetch(&folder)?;
        }
        let find = |name: &str| {
            let found = files(&folder).ok().into_iter().flatten();
            found
                .into_iter()
                .find(|path| {
                    path.file_name()
                        .is_some_and(|f| f.to_string_lossy().starts_with(name))
                })
                .ok_or_else(|| {
                    format!(
                        "{}: holds no {name}; remove the folder to fetch it again",
                        folder.display()
                    )
                })
        };
        Embree::open(&find("libtbb")?, &find("libembree4")?).map(Arc::new)
    });
    library.as_ref().map_err(String::clone)
}

/// The build folder of the workspace.
fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => folder.into(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target"),
    }
}

fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<io::Result<_>>()?;
    files.sort();
    Ok(files)
}

/// Downloads the package and lays its libraries into the folder, which appears whole or not at all.
fn fetch(folder: &Path) -> Result<(), String> {
    eprintln!("fetching {PACKAGE} with pip …");
    let parent = folder.parent().unwrap_or(folder);
    let io = |what: &Path| {
        let what = what.display().to_string();
        move |e: io::Error| format!("{what}: {e}")
    };
    fs::create_dir_all(parent).map_err(io(parent))?;
    let temporary = tempfile::tempdir_in(parent).map_err(io(parent))?;
    let output = Command::new("pip")
        .args([
            "download",
            "--quiet",
            "--no-deps",
            "--only-binary=:all:",
            "--python-version=3.11",
            "--dest",
        ])
        .arg(temporary.path())
        .arg(PACKAGE)
        .output()
        .map_err(|e| format!("pip cannot be run: {e}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let reason = said.lines().rfind(|line| line.starts_with("ERROR"));
        return Err(format!(
            "pip cannot download {PACKAGE}: {}",
            reason.unwrap_or("it does not say why")
        ));
    }
    let wheel = files(temporary.path()).map_err(io(parent))?;
    let wheel = wheel.first().ok_or("pip downloaded nothing")?;
    let unpacked = temporary.path().join("libraries");
    fs::create_dir(&unpacked).map_err(io(&unpacked))?;
    unpack(wheel, &unpacked).map_err(io(wheel))?;
    fs::rename(&unpacked, folder).map_err(io(folder))
}

/// The libraries of a wheel, which is a ZIP archive, without their folders.
fn unpack(wheel: &Path, folder: &Path) -> io::Result<()> {
    let mut archive = zip::ZipArchive::new(fs::File::open(wheel)?)?;
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i)?;
        // `enclosed_name` refuses names that lead elsewhere.
        let name = entry.enclosed_name();
        let name = name
            .as_deref()
            .and_then(Path::file_name)
            .map(ToOwned::to_owned);
        if let Some(name) = name.filter(|n| n.to_string_lossy().starts_with("lib")) {
            io::copy(&mut entry, &mut fs::File::create(folder.join(name))?)?;
        }
    }
    Ok(())
}
