//! `--picture WIDTHxHEIGHT`: the size of a picture, in every command that draws one.

/// Name of the value in help.
pub(super) const VALUE: &str = "WIDTHxHEIGHT";

/// Maximum number of pixels per side of a picture in a file, and of one in a window or a slice.
const MOST: u32 = 16384;
const MOST_SHOWN: u32 = 8192;

/// Parses width and height of a picture, in pixels.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    sides(text, MOST).ok_or_else(|| format!("give 1280x720, say: 1 to {MOST} per side"))
}

/// Parses width and height of the picture in a window, in pixels.
pub(super) fn shown(text: &str) -> Result<[u32; 2], String> {
    sides(text, MOST_SHOWN).ok_or_else(|| format!("give 960x720, say: 1 to {MOST_SHOWN} per side"))
}

/// Parses the side of a square picture, such as a light's view, in pixels.
pub(super) fn square(text: &str) -> Result<u32, String> {
    let side = sides(text, MOST_SHOWN).filter(|[width, height]| width == height).map(|[side, _]| side);
    side.ok_or_else(|| format!("it is square: give 512x512, say, 1 to {MOST_SHOWN} per side"))
}

fn sides(text: &str, most: u32) -> Option<[u32; 2]> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=most).contains(side));
    let (width, height) = text.split_once('x')?;
    Some([side(width)?, side(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_is_two_sides() {
        assert_eq!((size("1280x720"), size("1x16384")), (Ok([1280, 720]), Ok([1, 16384])));
        assert_eq!((shown("8192x1"), square("360x360")), (Ok([8192, 1]), Ok(360)));
        for wrong in
            ["", "x", "640", "640x", "x360", "0x360", "640x0", "640x16385", "640X360", "640x360x1", "-1x2", "6.5x3"]
        {
            assert!(size(wrong).is_err() && shown(wrong).is_err() && square(wrong).is_err(), "{wrong}");
        }
        assert!(shown("8193x1").is_err() && square("360x361").is_err() && square("8193x8193").is_err());
    }
}
