//! Signs of life for work that lasts: on stderr, only on a terminal, and only after a second.
//!
//! *How it works.* A thread sleeps for a second; when the work is done before, nothing was ever drawn. After it, the bar
//! draws itself ten times a second until the [`Progress`] is dropped, which wipes it.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Work that lasts less is not worth a word.
const PATIENCE: Duration = Duration::from_secs(1);

/// The sign of life of one piece of work. Dropping it wipes the line.
pub struct Progress {
    /// `None` where nobody watches.
    shown: Option<Shown>,
}

struct Shown {
    bar: ProgressBar,
    /// Dropped to wake the thread.
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Progress {
    /// Work of unknown length.
    pub fn spinner(what: impl Into<String>) -> Self {
        Self::start(what.into(), None)
    }

    /// Work whose steps are counted with [`Progress::at`].
    pub fn bar(what: impl Into<String>) -> Self {
        Self::start(what.into(), Some(1))
    }

    fn start(what: String, steps: Option<u64>) -> Self {
        if !stderr().is_terminal() {
            return Self { shown: None };
        }
        let bar = ProgressBar::with_draw_target(steps, ProgressDrawTarget::hidden());
        let template = match steps {
            None => "{spinner} {msg} {elapsed}",
            Some(_) => "{msg} [{bar:40}] {percent:>3} %  {elapsed}, {eta} left",
        };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what);
        let (done, sleeper) = channel::<()>();
        let thread = std::thread::spawn({
            let bar = bar.clone();
            move || {
                if sleeper.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                    bar.enable_steady_tick(Duration::from_millis(100));
                }
            }
        });
        Self {
            shown: Some(Shown {
                bar,
                done: Some(done),
                thread: Some(thread),
            }),
        }
    }

    /// `done` steps of `of` are behind us. May be called from any thread, often.
    pub fn at(&self, done: usize, of: usize) {
        if let Some(shown) = &self.shown {
            shown.bar.set_length(of as u64);
            shown.bar.set_position(done as u64);
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        drop(self.done.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}
