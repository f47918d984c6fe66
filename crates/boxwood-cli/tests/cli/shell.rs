//! Help, completions and manual pages.

use crate::bench::Bench;

#[test]
fn help_has_examples() {
    let bench = Bench::new();
    for words in [
        "",
        "render",
        "info",
        "cast",
        "query",
        "inspect",
        "explain",
        "completions",
        "man",
    ] {
        let help = bench.good(&format!("{words} --help"));
        assert!(
            help.contains("Usage: boxwood") && help.contains("Examples:\n  boxwood"),
            "{help}"
        );
        assert!(!help.contains('\u{1b}'), "colour in a pipe: {help}");
        assert!(
            help.lines().all(|line| line.chars().count() <= 100),
            "{help}"
        );
    }
    assert!(bench.good("--version").starts_with("boxwood "));
    assert!(bench.misused("").contains("Usage: boxwood"));
    assert!(
        bench
            .misused("paint")
            .contains("unrecognized subcommand 'paint'")
    );
}

#[test]
fn completions_for_every_shell() {
    let bench = Bench::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = bench.good(&format!("completions {shell}"));
        assert!(
            script.contains("boxwood") && script.contains("look-at"),
            "{shell}"
        );
    }
    assert!(
        bench
            .misused("completions cmd")
            .contains("invalid value 'cmd'")
    );
}

#[test]
fn manual_pages() {
    let bench = Bench::new();
    assert!(bench.good("man").contains(".TH boxwood 1"));
    assert_eq!(bench.good("man --dir pages"), "wrote 11 pages to pages\n");
    for (page, text) in [
        ("boxwood", "render"),
        ("boxwood-cast", "offsets"),
        ("boxwood-compare", "format_version"),
        ("boxwood-render", "look"),
        ("boxwood-info", "JSON"),
        ("boxwood-inspect", "slice"),
        ("boxwood-explain", "put aside"),
    ] {
        let page = String::from_utf8(bench.read(&format!("pages/{page}.1"))).expect("text");
        assert!(
            page.contains(".TH boxwood") && page.contains(text),
            "{page}"
        );
    }
    let page = String::from_utf8(bench.read("pages/boxwood-cast.1")).expect("text");
    assert!(
        page.contains(".SH NOTES\n.nf\n") && page.contains("\n.fi\n"),
        "{page}"
    );
    bench.write("file", "");
    assert!(
        bench
            .refused("man --dir file")
            .starts_with("file: cannot be made: ")
    );
}
