//! Adds the program's own options to library errors, whose texts mention no options.

use crate::{Error, Less, Need, WayOut, one_of};

/// Returns the error, with advice in the program's terms.
pub(crate) fn advised(error: Error) -> Error {
    match error {
        Error::Refused(needs @ Need::VirtualLights) => {
            Error::Refused(format!("{needs} (--vpls N makes them of the scene's)").into())
        }
        error => match error.way_out().and_then(typed) {
            Some(words) => error.with_way_out(words),
            None => error,
        },
    }
}

/// Returns what to type; `None` if the library's own text is enough.
fn typed(way_out: &WayOut) -> Option<String> {
    Some(match way_out {
        WayOut::Less(less) => format!("use {}", one_of(less.iter().map(of_less))),
        WayOut::Loader => "install it (./setup.sh does, with a software driver)".into(),
        WayOut::Driver => "install a Vulkan 1.3 driver (./setup.sh installs lavapipe)".into(),
        WayOut::Layer => "install it (./setup.sh does) or run without --validation".into(),
        WayOut::OtherDevice => "run `gobo devices`, update the driver, or choose another device with --device".into(),
        WayOut::OtherPlace => format!("{way_out} with --out"),
        WayOut::Bake(words) => format!("{words} with gobo bake"),
        WayOut::Each(specs) => {
            let specs = if specs.is_empty() { &vec!["SPEC".into(); 2] } else { specs };
            let each = specs.iter().map(|spec| format!("--technique {spec}")).collect::<Vec<_>>();
            format!("write a --technique for each: {}", each.join(" "))
        }
        WayOut::Words(_) => return None,
    })
}

fn of_less(less: &Less) -> String {
    let key = match less {
        Less::Map => " (size=)",
        Less::Slices => " (slices=)",
        Less::Casters | Less::Lights | Less::MoreMemory | Less::OtherDevice => "",
    };
    format!("{less}{key}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_says_what_to_type() {
        let said = |way_out: WayOut| advised(Error::input("it", "is wrong", way_out)).to_string();
        for (way_out, words) in [
            (WayOut::Words("think".into()), "it: is wrong; think"),
            (
                WayOut::Less(&[Less::Map, Less::Casters, Less::MoreMemory]),
                "a smaller map (size=), fewer casters or a device",
            ),
            (WayOut::Less(&[Less::Slices]), "use fewer slices (slices=)"),
            (WayOut::Loader, "./setup.sh"),
            (WayOut::Driver, "./setup.sh"),
            (WayOut::Layer, "--validation"),
            (WayOut::OtherDevice, "--device"),
            (WayOut::OtherPlace, "--out"),
            (WayOut::Bake("bake it".into()), "bake it with gobo bake"),
            (
                WayOut::Each(vec!["avsm".into(), "psm".into()]),
                "a --technique for each: --technique avsm --technique psm",
            ),
            (WayOut::Each(Vec::new()), "--technique SPEC --technique SPEC"),
        ] {
            // The library's own text mentions no option and no file of the program.
            for typed in ["--", "=", ".sh", "gobo"] {
                assert!(!way_out.to_string().contains(typed), "{way_out}");
            }
            assert!(said(way_out.clone()).contains(words), "{way_out:?}");
        }
        let refused = advised(Error::Refused(Need::VirtualLights)).to_string();
        assert!(refused.contains("--vpls N"), "{refused}");
    }
}
