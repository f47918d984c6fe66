//! Holds the answers on three architectures against each other: this machine's, 64-bit ARM under qemu, WebAssembly under node.
//!
//! `cargo run --release -p boxwood-testkit --example architectures`. On each it runs the tests of the lanes and the example
//! `digest`, and compares all digests. What the machine has no tools for is left out, in a sentence that says what to install.
//! Exit code 1 when a digest differs or a test fails.

use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// A machine to ask.
struct Architecture {
    name: &'static str,
    /// This machine's where there is none.
    target: Option<&'static str>,
    /// Settings of cargo for the target.
    settings: Vec<String>,
    flags: &'static str,
    /// What it takes, and where that comes from.
    tools: &'static [(&'static str, &'static str)],
}

fn architectures() -> [Architecture; 3] {
    let wasi = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/wasi.mjs");
    [
        Architecture {
            name: "this machine",
            target: None,
            settings: Vec::new(),
            flags: "",
            tools: &[],
        },
        Architecture {
            name: "64-bit ARM",
            target: Some("aarch64-unknown-linux-gnu"),
            settings: vec![
                "linker=\"aarch64-linux-gnu-gcc\"".into(),
                "runner=[\"qemu-aarch64\", \"-L\", \"/usr/aarch64-linux-gnu\"]".into(),
            ],
            flags: "",
            tools: &[
                ("qemu-aarch64", "Debian's package qemu-user"),
                (
                    "aarch64-linux-gnu-gcc",
                    "Debian's packages gcc-aarch64-linux-gnu and libc6-dev-arm64-cross",
                ),
            ],
        },
        Architecture {
            name: "WebAssembly",
            target: Some("wasm32-wasip1"),
            settings: vec![format!("runner=[\"node\", \"--no-warnings\", {wasi:?}]")],
            flags: "-C target-feature=+simd128",
            tools: &[("node", "Node.js 20 or later")],
        },
    ]
}

fn main() -> ExitCode {
    let mut reports: Vec<(&str, String)> = Vec::new();
    let mut failed = false;
    for architecture in architectures() {
        let name = architecture.name;
        if let Err(missing) = architecture.is_there() {
            println!("{name} is left out: {missing}.");
            continue;
        }
        let report = architecture.test_lanes().and_then(|passed| {
            println!("{name}: {passed}");
            architecture.digest()
        });
        match report {
            Ok(report) => reports.push((name, report)),
            Err(e) => {
                println!("{name} fails: {e}.");
                failed = true;
            }
        }
    }
    if failed | differ(&reports) {
        return ExitCode::FAILURE;
    }
    println!("The same bits on every machine asked.");
    ExitCode::SUCCESS
}

impl Architecture {
    /// Or what is missing.
    fn is_there(&self) -> Result<(), String> {
        for (tool, from) in self.tools {
            if run(Command::new(tool).arg("--version")).is_err() {
                return Err(format!("`{tool}` does not run (it comes from {from})"));
            }
        }
        let Some(target) = self.target else {
            return Ok(());
        };
        let library =
            run(Command::new("rustc").args(["--print", "target-libdir", "--target", target]))?;
        if Path::new(library.trim()).is_dir() {
            Ok(())
        } else {
            Err(format!("`rustup target add {target}` has not been done"))
        }
    }

    /// Runs the tests of the lanes; what they say in the end.
    fn test_lanes(&self) -> Result<String, String> {
        let text = self.cargo("test", &["-p", "boxwood", "--lib"], &["simd::"])?;
        let closing = text
            .lines()
            .find(|line| line.starts_with("test result: ok"));
        match closing.and_then(|line| line.split(';').next()) {
            Some(passed) if !passed.ends_with(" 0 passed") => Ok(passed.to_string()),
            _ => Err(format!("no test of the lanes ran\n{text}")),
        }
    }

    /// What the example `digest` prints.
    fn digest(&self) -> Result<String, String> {
        self.cargo(
            "run",
            &["-p", "boxwood-testkit", "--example", "digest"],
            &[],
        )
    }

    /// What a command of cargo prints.
    fn cargo(&self, command: &str, what: &[&str], arguments: &[&str]) -> Result<String, String> {
        let mut cargo = Command::new("cargo");
        cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        cargo.args([command, "--quiet", "--release"]).args(what);
        // Not every architecture has threads.
        cargo.args(["--no-default-features", "--features", "boxwood/std"]);
        if let Some(target) = self.target {
            cargo.args(["--target", target]);
            for setting in &self.settings {
                cargo.args(["--config", &format!("target.{target}.{setting}")]);
            }
            cargo.env("RUSTFLAGS", self.flags);
        }
        run(cargo.arg("--").args(arguments))
    }
}

/// What a command prints, if it ends well; its complaints go where ours do.
fn run(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("`{name}`: {e}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("{command:?} ends with {}\n{text}", output.status))
    }
}

/// Whether any digest of any machine differs from the first machine's judge; says so, and what was compared.
fn differ(reports: &[(&str, String)]) -> bool {
    let mut expected = None;
    let mut differ = false;
    for (name, report) in reports {
        let mut lines = report.lines();
        let machine = lines.next().unwrap_or_default();
        let inputs = lines.next().unwrap_or_default();
        let digests: Vec<(&str, &str)> = lines.filter_map(|line| line.split_once(' ')).collect();
        let Some(&(judge, _)) = digests.first() else {
            println!("{name} printed no digest.");
            return true;
        };
        println!(
            "{name} ({machine}): {judge} from {} structures, {inputs}",
            digests.len()
        );
        let (first_inputs, first_judge) = *expected.get_or_insert((inputs, judge));
        if inputs != first_inputs {
            println!("{name} was asked other questions: {inputs} instead of {first_inputs}.");
            differ = true;
        }
        for (digest, structure) in digests.iter().filter(|(digest, _)| *digest != first_judge) {
            println!("{name} differs: {structure} gives {digest} instead of {first_judge}.");
            differ = true;
        }
    }
    differ
}
