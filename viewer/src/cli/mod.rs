//! The command line: one subcommand a file, as typed → as used → run.
//!
//! Results go to stdout, progress and notes to stderr. Exit status 0, 1 (input) or 2 (usage).

mod bench;
mod compare;
mod info;
mod input;
mod process;
mod progress;
mod render;
mod solve;
mod values;
mod verify;
mod walk;

use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Precomputed directional global illumination that one can walk through.
#[derive(Debug, Parser)]
#[command(name = "sheen", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Solve a scene and write the solution.
    Solve(solve::Args),
    /// Render a picture of a solution, or of a scene that is solved first.
    Render(render::Args),
    /// Walk through a solution, or through a scene that is solved first.
    Walk(walk::Args),
    /// Say what a scene or a solution holds.
    Info(info::Args),
    /// Measure the error of a solution over all surfaces, with intervals.
    Verify(verify::Args),
    /// Measure time, memory and error.
    Bench(bench::Args),
    /// Compare an image with a reference.
    Compare(compare::Args),
}

/// Parses the command line, does what it says, and reports failures as one line on stderr.
pub fn run() -> ExitCode {
    report_panics_in_one_line();
    let command = Cli::parse().command;
    match std::panic::catch_unwind(|| dispatch(&command)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        // The hook has said what happened.
        Err(_) => ExitCode::FAILURE,
        Ok(Err(error)) => {
            let text = format!("{error:#}");
            note(&text.split_whitespace().collect::<Vec<_>>().join(" "));
            ExitCode::FAILURE
        }
    }
}

fn dispatch(command: &Command) -> anyhow::Result<()> {
    match command {
        Command::Solve(args) => solve::run(args),
        Command::Render(args) => render::run(args),
        Command::Walk(args) => walk::run(args),
        Command::Info(args) => info::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Compare(args) => compare::run(args),
    }
}

/// A panic is a bug of ours: the first one is named in one line. With `RUST_BACKTRACE` set, all of it is shown.
fn report_panics_in_one_line() {
    if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
        return;
    }
    let is_first = AtomicBool::new(true);
    std::panic::set_hook(Box::new(move |info| {
        if !crate::window::is_opening() && is_first.swap(false, Ordering::Relaxed) {
            let place = info
                .location()
                .map_or_else(String::new, |place| format!(" at {place}"));
            let text = info.payload_as_str().unwrap_or("no message");
            let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
            note(&format!(
                "internal error{place}: {text} (a bug; RUST_BACKTRACE=1 shows more)"
            ));
        }
    }));
}

/// A line for the person at the terminal.
fn note(text: &str) {
    // Nobody reads stderr any more: nothing to be done about it.
    let _ = writeln!(std::io::stderr().lock(), "sheen: {text}");
}

/// Results to stdout. A reader that has gone away, as `head` does, is no error.
fn print(text: &str) -> anyhow::Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
