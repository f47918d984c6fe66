//! The machine that measures, in words.

use super::report::Machine;
use std::fs;
use std::process::Command;

/// This machine, building with so many threads.
pub fn describe(threads: usize) -> Machine {
    Machine {
        processor: processor(),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
        threads,
        system: system(),
        architecture: std::env::consts::ARCH,
        boxwood: env!("CARGO_PKG_VERSION"),
    }
}

fn processor() -> String {
    let named = if cfg!(target_os = "macos") {
        said("sysctl", &["-n", "machdep.cpu.brand_string"])
    } else {
        value_of("/proc/cpuinfo", "model name", ':')
            .or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
    };
    named.unwrap_or_else(|| format!("unknown ({})", std::env::consts::ARCH))
}

fn system() -> String {
    let os = std::env::consts::OS;
    let name = match os {
        "macos" => said("sw_vers", &["-productVersion"]).map(|version| format!("macOS {version}")),
        "linux" => {
            value_of("/etc/os-release", "PRETTY_NAME", '=').map(|name| format!("Linux, {name}"))
        }
        _ => None,
    };
    name.unwrap_or_else(|| os.to_string())
}

/// The value of the first line `key = value` of a file, without quotes.
fn value_of(file: &str, key: &str, divider: char) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let value = text.lines().find_map(|line| {
        let (name, value) = line.split_once(divider)?;
        (name.trim() == key).then(|| value.trim().trim_matches('"').to_string())
    });
    value.filter(|value| !value.is_empty())
}

fn said(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.trim().to_string()).filter(|text| !text.is_empty())
}

/// The command line as a shell would take it again.
pub fn command_line() -> String {
    let words = std::env::args_os().enumerate().map(|(i, word)| match i {
        0 => "boxwood".to_string(),
        _ => quoted(&word.to_string_lossy()),
    });
    words.collect::<Vec<_>>().join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:,=+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_string()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(quoted("--rays=ao,random"), "--rays=ao,random");
        assert_eq!(quoted("my scene.obj"), "'my scene.obj'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
