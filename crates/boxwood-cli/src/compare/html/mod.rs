//! The report as one HTML page: no network, no script, no other file; light and dark as the reader likes it.
//!
//! Every text that comes from outside of this program goes through [`Escaped`].

mod escape;
mod histogram;
mod jobs;
mod pictures;
mod scatter;
mod svg;
mod sweep;
mod table;

use super::frontier::{break_even, frontier, places};
use super::report::{Measured, Report};
use super::text::{all, sampled};
use super::views::Pictures;
use crate::terminal::{counted, grouped, seconds};
use escape::Escaped;
use std::fmt::Write;
use std::path::Path;

/// The whole page.
pub fn page(report: &Report, views: Option<&Pictures>) -> String {
    let scene = Escaped(&report.settings.scene);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
        <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
        <meta name=\"generator\" content=\"boxwood {}\"><title>{scene}: structures compared</title>\
        <style>{}</style></head><body>",
        report.machine.boxwood,
        include_str!("style.css")
    );
    html += &header(report, views);
    if let Some(found) = &report.sweep {
        let _ = write!(
            html,
            "<h2>From one end to the other: {}</h2>{}<div class=\"plots\">{}</div><h2>Every point</h2>{}",
            found.setting,
            sweep::verdicts(found),
            sweep::panels(found),
            table::sweep(found)
        );
    }
    let _ = write!(
        html,
        "<h2>What rays do</h2>{}<p class=\"small\">{}</p>",
        table::rays(report),
        notes(report)
    );
    if report.sweep.is_none() {
        html += "<h2>What structures are</h2>";
        html += &table::structures(report);
        html += &plots(report);
    }
    if let Some(views) = views {
        html += "<h2>Where the work is</h2>";
        html += &pictures::heat_maps(views);
        let differences = pictures::differences(views);
        if !differences.is_empty() {
            html += "<h2>Where two differ</h2>";
            html += &differences;
        }
    }
    html += &again(report);
    html + "</body></html>\n"
}

/// The scene, its picture and the three things to take home.
fn header(report: &Report, views: Option<&Pictures>) -> String {
    let settings = &report.settings;
    let class = if views.is_some() {
        "hero"
    } else {
        "hero plain"
    };
    // The folder is told below.
    let title = Path::new(&settings.scene).file_name();
    let title = title.map_or(settings.scene.clone().into(), |name| name.to_string_lossy());
    let subject = match &report.sweep {
        Some(sweep) => format!("{} of {} structures", sweep.setting, sweep.family),
        None => counted(report.structures.len() as u64, "structure"),
    };
    let mut html = format!(
        "<header class=\"{class}\"><div><h1>{}</h1><p class=\"sub\">{}, {subject}, {} of rays</p>",
        Escaped(&title),
        counted(settings.triangles, "triangle"),
        counted(report.workloads.len() as u64, "kind"),
    );
    let facts: String = facts(report)
        .into_iter()
        .map(|(name, text)| format!("<li><b>{}</b><span>{text}</span></li>", Escaped(&name)))
        .collect();
    if !facts.is_empty() {
        let _ = write!(html, "<ul class=\"facts\">{facts}</ul>");
    }
    html += "</div>";
    if let Some(views) = views {
        let [width, height] = views.size;
        let _ = write!(
            html,
            "<img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"The scene as the rays’ camera sees it\">",
            pictures::data(&views.view)
        );
    }
    html + "</header>"
}

/// Who is best at what matters most, as a name and HTML about it; nobody in a sweep.
fn facts(report: &Report) -> Vec<(String, String)> {
    let best = |column: &str, text: &dyn Fn(&Measured) -> String| {
        let name = report.winners.get(column)?.first()?;
        let found = report.structures.iter().find(|s| s.structure == *name)?;
        Some((name.clone(), text(found.measured.as_ref()?)))
    };
    let tracing = |m: &Measured| {
        let factor = m.speedup.map_or(String::new(), |x| {
            format!(", {} times the exhaustive test", svg::count(x))
        });
        let rate = svg::round(m.mrays_per_second.unwrap_or(0.0));
        format!("traces fastest: {rate} million rays per second{factor}")
    };
    let building = |m: &Measured| {
        format!(
            "builds fastest: {}{}",
            seconds(m.build_seconds),
            overtaken(report)
        )
    };
    let size = |m: &Measured| {
        let bytes = svg::round(m.bytes_per_triangle.unwrap_or(0.0));
        format!("is smallest: {bytes} bytes per triangle")
    };
    let facts = [
        best("mrays_per_second", &tracing),
        best("build_seconds", &building),
        best("bytes", &size),
    ];
    facts.into_iter().flatten().collect()
}

/// When the fastest to build is overtaken.
fn overtaken(report: &Report) -> String {
    let places = places(&report.structures);
    match frontier(&places)[..] {
        [first, .., last] => {
            format!(
                "; {} is done before it from {} rays on",
                Escaped(&last.name),
                svg::count(break_even(first, last).ceil())
            )
        }
        _ => String::new(),
    }
}

fn notes(report: &Report) -> String {
    let mut text =
        "Single rays on one thread, median of the rounds; the mean over the kinds is geometric. "
            .to_string();
    if report.sweep.is_none() {
        text += "The best of each column is marked; the exhaustive test (brute), and what is a hundred times slower than the fastest, takes no part. ";
    }
    let sampled = sampled(report);
    if sampled.is_empty() {
        let _ = write!(text, "{} gave the same bits for every ray.", all(report));
    } else {
        let _ = write!(
            text,
            "{} gave the same bits for every ray they were asked; slow ones were asked an even sample: {}.",
            all(report),
            Escaped(&sampled.join(", "))
        );
    }
    text
}

fn plots(report: &Report) -> String {
    let places = places(&report.structures);
    if places.is_empty() {
        return String::new();
    }
    let histogram = histogram::plot(&report.structures);
    format!(
        "<h2>When is which worth it?</h2><div class=\"plots\"><figure class=\"plot\"><figcaption>Build time against trace \
        time</figcaption>{}<p class=\"small\">Down and left is better; the dotted line joins what nothing beats in both. \
        Building included, the one to take is:</p>{}</figure><figure class=\"plot\"><figcaption>What rays cost</figcaption>{}\
        <p class=\"small\">Shares of all rays by the steps they take, each kind counting the same. The prediction is for long \
        random lines that meet the scene’s box; rays that start inside and stop early take fewer.</p></figure>{}</div>",
        scatter::plot(&places),
        scatter::advice(&places),
        histogram,
        jobs::figure(report, &places)
    )
}

/// What somebody else needs to repeat it.
fn again(report: &Report) -> String {
    let (s, m) = (&report.settings, &report.machine);
    let point = |p: [f32; 3]| format!("{}, {}, {}", p[0], p[1], p[2]);
    let workloads = report.workloads.iter().map(|w| {
        let question = match w.question {
            "occluded" => "is anything in the way?",
            _ => "nearest hit",
        };
        format!(
            "{}: {} rays, {} hit ({question})",
            w.kind,
            grouped(w.rays as u64),
            grouped(w.hits as u64)
        )
    });
    let camera = s.camera.as_deref().unwrap_or("described or found");
    let rows = [
        ("Boxwood", m.boxwood.to_string()),
        ("Processor", format!("{} ({})", m.processor, m.architecture)),
        (
            "Cores",
            format!(
                "{}; built with {}, timed on one",
                m.cores,
                counted(m.threads as u64, "thread")
            ),
        ),
        ("System", m.system.clone()),
        (
            "Scene",
            format!(
                "{} ({}), {}",
                s.scene,
                s.format,
                counted(s.triangles, "triangle")
            ),
        ),
        (
            "Camera",
            format!(
                "{camera}: eye {}, forward {}",
                point(s.eye),
                point(s.forward)
            ),
        ),
        (
            "Primary rays",
            format!("{} × {} pixels", s.image[0], s.image[1]),
        ),
        ("Rays", workloads.collect::<Vec<_>>().join("; ")),
        ("Rounds", s.rounds.to_string()),
        (
            "Memory cap",
            s.memory_bytes
                .map_or("none".to_string(), |n| crate::terminal::bytes(n as u64)),
        ),
    ];
    let rows: String = rows
        .iter()
        .map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>", Escaped(value)))
        .collect();
    format!(
        "<h2>Do it again</h2><pre>{}</pre><dl>{rows}</dl><footer>Made by boxwood compare.</footer>",
        Escaped(&s.command)
    )
}
