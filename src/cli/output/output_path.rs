//! Checks, before anything is measured or drawn, that a file can be written to its place.

use crate::{Error, Result};
use std::path::Path;

/// Checks that the name of a file of this `format` has the right extension, and that its folder exists.
///
/// # Errors
/// [`Error::Usage`] for another extension, [`Error::Output`] if the folder is missing.
pub fn check(out: &Path, format: &str) -> Result<()> {
    if let Some(ending) = out.extension().filter(|ending| !ending.eq_ignore_ascii_case(format)) {
        let cause = format!("it would become a {}, not a {}", format.to_uppercase(), ending.display());
        let way_out = format!("name {}", out.with_extension(format).display());
        return Err(Error::usage(out.display().to_string(), cause, way_out));
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        None => Ok(()),
        Some(folder) => Err(Error::Output {
            path: out.into(),
            cause: format!("there is no folder {}", folder.display()),
            way_out: "make it, or choose another place with --out".into(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::check;
    use std::path::Path;

    #[test]
    fn a_place_is_a_folder_and_an_ending() {
        for (out, words) in [
            ("a.jpg", "a.jpg: it would become a PNG, not a jpg; name a.png"),
            ("a.b.gif", "name a.b.png"),
            ("no/dir/a.png", "cannot write no/dir/a.png: there is no folder no/dir; make it"),
        ] {
            let error = check(Path::new(out), "png").expect_err(out).to_string();
            assert!(error.contains(words), "{error}");
        }
        for out in ["a.png", "a.PNG", "a", "/dev/null", "src/a.png"] {
            check(Path::new(out), "png").expect(out);
        }
        assert!(check(Path::new("a.png"), "svg").is_err());
    }
}
