//! Entry point only; everything else is in the library.

fn main() -> std::process::ExitCode {
    gobo::cli::main()
}
