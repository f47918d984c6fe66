//! Builds every structure over ten million triangles within a memory cap and compares their answers to the bit.
//!
//! `cargo run --release --example large -- [TRIANGLES [CAP_IN_GIB [KIND…]]]`: hills of so many triangles (10
//! million), at most so much memory for a structure (8), all structures or those named. Every answer is compared with that
//! of `bvh:binned`, and a few with the judge's. Exit code 1 when an answer differs.

use boxwood::{Hit, Intersect, Limits, Ray, StructureKind};
use boxwood_testkit::{Random, shapes};
use std::ops::ControlFlow::Continue;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::time::Instant;

const RAYS: usize = 20_000;
/// So many are also asked of the judge.
const JUDGED: usize = 20;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let number = |text: Option<String>, default: usize| {
        text.map_or(Ok(default), |t| t.parse().map_err(|_| t))
    };
    let numbers = number(arguments.next(), 10_000_000)
        .and_then(|triangles| Ok((triangles, number(arguments.next(), 8)?)));
    let (triangles, gibibytes) = match numbers {
        Ok(numbers) => numbers,
        Err(text) => {
            eprintln!("`{text}` is not a whole number");
            return ExitCode::from(2);
        }
    };
    let kinds: Result<Vec<StructureKind>, _> = arguments.map(|text| text.parse()).collect();
    let kinds = match kinds {
        Ok(kinds) if kinds.is_empty() => StructureKind::all().collect(),
        Ok(kinds) => kinds,
        Err(e) => {
            eprintln!("{e}");
            return ExitCode::from(2);
        }
    };
    let mut random = Random::new(1);
    let side = (triangles as f64 / 2.0).sqrt() as u32;
    let mesh = shapes::terrain(side, &mut random).mesh();
    println!("{} triangles", mesh.triangles().len());
    let rays: Vec<Ray> = (0..RAYS)
        .map(|_| Ray::between(random.in_cube() * 1.5, random.in_cube() * 1.5))
        .collect();

    let closest = |s: &dyn Intersect, rays: &[Ray]| -> Vec<Option<Hit>> {
        rays.iter().map(|ray| s.closest_hit(ray)).collect()
    };
    let expected = closest(&*StructureKind::default().build(&mesh), &rays);
    let hits = expected.iter().flatten().count();
    println!("{hits} of {RAYS} rays hit");
    let mut differing = 0;
    for kind in kinds {
        // Those without a tree take a second for a few rays.
        let some = match kind.name() {
            "brute" | "boxes" => JUDGED,
            _ => RAYS,
        };
        let told = AtomicU32::new(0);
        let watch = |_: f32| {
            told.fetch_add(1, Relaxed);
            Continue(())
        };
        let limits = Limits {
            memory: Some(gibibytes << 30),
            watch: Some(&watch),
        };
        let start = Instant::now();
        let structure = match kind.build_within(&mesh, &limits) {
            Ok(structure) => structure,
            Err(e) => {
                println!("{kind}: {e}");
                continue;
            }
        };
        let built = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let found = closest(&*structure, &rays[..some]);
        let traced = start.elapsed().as_secs_f64();
        let bits = |hit: &Option<Hit>| {
            hit.map(|h| (h.t.to_bits(), h.u.to_bits(), h.v.to_bits(), h.primitive))
        };
        let wrong = (0..some)
            .filter(|&i| bits(&found[i]) != bits(&expected[i]))
            .count();
        differing += wrong;
        let statistics = structure.statistics();
        println!(
            "{kind}: built in {built:.1} s, {:.1} bytes per triangle, {:.3} Mrays/s, progress told {} times, \
             {wrong} of {some} answers differ",
            statistics.bytes as f64 / statistics.primitives.max(1) as f64,
            some as f64 / traced / 1e6,
            told.load(Relaxed),
        );
    }
    ExitCode::from(u8::from(differing > 0))
}
