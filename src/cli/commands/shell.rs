//! `gobo completions` and `gobo man`

use crate::Result;
use crate::cli::{Cli, say};
use crate::report::Store;
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

#[derive(Args)]
pub struct Man {
    /// Folder for gobo.1, gobo-compare.1 and the others
    #[arg(long, short, default_value = "gobo-man", value_name = "DIR")]
    out: PathBuf,
}

pub fn completions(arguments: &Completions) -> Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "gobo", &mut script);
    say(String::from_utf8_lossy(&script).trim_end())?;
    Ok(ExitCode::SUCCESS)
}

pub fn man(arguments: &Man) -> Result<ExitCode> {
    let store = Store::open(&arguments.out)?;
    let mut cli = Cli::command();
    cli.build();
    let commands: Vec<_> =
        std::iter::once(&cli).chain(cli.get_subcommands().filter(|c| c.get_name() != "help")).collect();
    for command in commands {
        let name = if std::ptr::eq(command, &cli) { "gobo".to_owned() } else { format!("gobo-{}", command.get_name()) };
        let mut page = Vec::new();
        // Writing to memory does not fail.
        let _ = clap_mangen::Man::new(command.clone().name(name.clone())).render(&mut page);
        store.write_text(&format!("{name}.1"), &String::from_utf8_lossy(&page))?;
    }
    Ok(ExitCode::SUCCESS)
}
