# The recipes that people and CI share. `just --list` names them.

# Formatting, lints, the library without threads and without std.
check:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets -- -D warnings
    cargo check -p boxwood --no-default-features

# All tests. BOXWOOD_SCENES=FOLDER adds those on real files.
test:
    cargo test

# The same bits on x86-64, on 64-bit ARM under qemu, and on WebAssembly under node; says what cannot be had.
architectures:
    cargo run --release -p boxwood-testkit --example architectures

# A billion adversarial rays at the wide trees, by every way of asking and every instruction set, against the judge; resumable.
adversary *options:
    cargo run --release -p boxwood-testkit --example adversary -- {{options}}

# Licences, advisories and sources of the dependencies.
deny:
    cargo deny check

# Ten minutes of fuzzing on each target.
fuzz seconds="600":
    for target in structures bxw obj ply stl gltf; do cargo +nightly fuzz run --fuzz-dir fuzz $target -- -max_total_time={{seconds}} -rss_limit_mb=2048 -timeout=10 || exit 1; done

# The pictures of the gallery that need no files.
gallery:
    cargo run --release -- render -o gallery/teapot-in-stadium.png
    cargo run --release -- figure --all --dir gallery/figures

# Every structure over ten million triangles, compared to the bit; needs about 12 GiB of memory and a few minutes.
large:
    cargo run --release --example large
