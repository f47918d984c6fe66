//! The report as comma-separated values (RFC 4180): one line per structure and kind of ray, `all` for their means.

use super::report::{Measured, Report, Structure};

const HEADER: &str = "structure,setting,rays,mrays_per_second,speedup,nodes_per_ray,leaves_per_ray,primitives_per_ray,\
rays_asked,build_seconds,bytes,nodes,leaves,depth,references_per_triangle,sah_cost,failure";

/// All lines with their header. What was not measured is empty.
pub fn lines(report: &Report) -> String {
    let mut text = format!("{HEADER}\r\n");
    for structure in &report.structures {
        add(&mut text, structure, "");
    }
    if let Some(sweep) = &report.sweep {
        for point in sweep.curves.iter().flat_map(|curve| &curve.points) {
            add(&mut text, &point.structure, &point.value.to_string());
        }
    }
    text
}

fn add(text: &mut String, structure: &Structure, setting: &str) {
    let Some(m) = &structure.measured else {
        let failure = structure.failure.as_deref().unwrap_or_default();
        let mut fields = vec![String::new(); 17];
        fields[0] = quoted(&structure.structure);
        fields[1] = setting.to_string();
        fields[16] = quoted(failure);
        *text += &(fields.join(",") + "\r\n");
        return;
    };
    let asked = m.rays.iter().map(|r| r.rays_asked).sum();
    let all = [
        m.mrays_per_second,
        m.speedup,
        m.nodes_per_ray,
        m.leaves_per_ray,
        m.primitives_per_ray,
    ];
    let mut line = |rays: &str, found: [Option<f64>; 5], asked: usize| {
        let mut fields = vec![
            quoted(&structure.structure),
            setting.to_string(),
            rays.to_string(),
        ];
        fields.extend(found.map(number));
        fields.push(asked.to_string());
        fields.extend(built(m));
        fields.push(String::new());
        *text += &(fields.join(",") + "\r\n");
    };
    for r in &m.rays {
        let found = [
            r.mrays_per_second,
            r.speedup,
            r.nodes_per_ray,
            r.leaves_per_ray,
            r.primitives_per_ray,
        ];
        line(r.kind, found, r.rays_asked);
    }
    line("all", all, asked);
}

fn built(m: &Measured) -> [String; 7] {
    [
        m.build_seconds.to_string(),
        m.bytes.to_string(),
        m.nodes.to_string(),
        m.leaves.to_string(),
        m.depth.to_string(),
        number(m.references_per_triangle),
        m.sah_cost.to_string(),
    ]
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |x| x.to_string())
}

/// A field that may hold commas (structures with settings do), quotes or line ends.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must() {
        assert_eq!(quoted("brute"), "brute");
        assert_eq!(quoted("bvh:median,leaf=2"), "\"bvh:median,leaf=2\"");
        assert_eq!(quoted("a \"b\""), "\"a \"\"b\"\"\"");
        assert_eq!(HEADER.split(',').count(), 17);
    }
}
