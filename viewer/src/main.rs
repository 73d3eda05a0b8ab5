//! The program sheen.

fn main() -> std::process::ExitCode {
    sheen_viewer::cli::run()
}
