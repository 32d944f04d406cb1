//! `gobo glsl`

use crate::cli::say;
use crate::glsl::{File, file};
use crate::report::Store;
use crate::{Error, Result};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Args)]
pub struct Arguments {
    /// Techniques: avsm,psm
    #[arg(value_name = "TECHNIQUE[,TECHNIQUE…]")]
    techniques: String,
    /// Folder for one file per technique, such as avsm.glsl; without it, all go to standard output
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> Result<ExitCode> {
    let mut files: Vec<&File> = arguments.techniques.split(',').map(file).collect::<Result<_>>()?;
    files.sort_by_key(|file| file.technique);
    if let Some(twice) = files.windows(2).find(|pair| pair[0].technique == pair[1].technique) {
        return Err(Error::usage(
            arguments.techniques.clone(),
            format!("{} is there twice", twice[0].technique),
            "name it once",
        ));
    }
    let Some(out) = &arguments.out else {
        files.iter().try_for_each(|file| say(file.text.trim_end()))?;
        return Ok(ExitCode::SUCCESS);
    };
    let store = Store::open(out)?;
    let names: Vec<_> = files.iter().map(|file| format!("{}.glsl", file.technique)).collect();
    names.iter().try_for_each(|name| store.check(name))?;
    for (file, name) in files.iter().zip(&names) {
        store.write_file(name, file.text.as_bytes())?;
        say(out.join(name).display())?;
    }
    Ok(ExitCode::SUCCESS)
}
