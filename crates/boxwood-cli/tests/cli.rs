//! The command as a user meets it: every verb, on tiny files that the tests write.

#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/cache.rs"]
mod cache;
#[path = "cli/cast.rs"]
mod cast;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/explain.rs"]
mod explain;
#[path = "cli/figure.rs"]
mod figure;
#[path = "cli/info.rs"]
mod info;
#[path = "cli/inspect.rs"]
mod inspect;
#[path = "cli/numpy.rs"]
mod numpy;
#[path = "cli/query.rs"]
mod query;
#[path = "cli/render.rs"]
mod render;
#[path = "cli/shell.rs"]
mod shell;
