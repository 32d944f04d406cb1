//! Imperfect shadow maps: points, splatting and filling against their twins; paths against each other; closed forms; what is refused.

#![cfg(feature = "program")]

mod support;

#[path = "ism/adaptive.rs"]
mod adaptive;
#[path = "ism/answers.rs"]
mod answers;
#[path = "ism/culls.rs"]
mod culls;
#[path = "ism/errors.rs"]
mod errors;
#[path = "ism/maps.rs"]
mod maps;
#[path = "ism/points.rs"]
mod points;
#[path = "ism/scenes.rs"]
mod scenes;

use gobo::gpu::Context;
use gobo::scene::Scene;
use gobo::technique::{Ism, Opened};
use gobo::world::World;
use gobo::{Error, Need};
use support::{opened, spec};

/// Every path.
const PATHS: [&str; 4] = ["tiled", "atomic", "quads", "triangles"];

/// The technique, built for `scene`.
fn built(context: &Context, scene: &Scene, text: &str) -> Box<Ism> {
    let world = World::new(context, scene).expect("room for the scene");
    let ism = opened(Ism::new(context, &world, &spec(text).settings()), text);
    let mut opened = Opened::new(context, Box::new(ism), true);
    opened.build(&world).expect(text);
    opened.technique
}

/// Why a spec is refused for a scene; nothing where it is not.
fn refusal(context: &Context, scene: &Scene, text: &str) -> Option<Need> {
    let world = World::new(context, scene).expect("room for the scene");
    match Ism::new(context, &world, &spec(text).settings()) {
        Ok(_) => None,
        Err(Error::Refused(needs)) => Some(needs),
        Err(error) => panic!("{text}: {error}"),
    }
}
