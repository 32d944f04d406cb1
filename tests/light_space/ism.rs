//! Imperfect shadow maps: points, splatting and filling against their twins; paths against each other; closed forms; refusals.

mod adaptive;
mod answers;
mod culls;
mod errors;
mod maps;
mod points;
mod scenes;

use crate::support::{opened, spec};
use gobo::gpu::Context;
use gobo::scene::Scene;
use gobo::technique::{Ism, Opened};
use gobo::world::World;
use gobo::{Error, Need};

/// Every path.
const PATHS: [&str; 4] = ["tiled", "atomic", "quads", "triangles"];

/// Builds the technique for `scene`.
fn built(context: &Context, scene: &Scene, text: &str) -> Box<Ism> {
    let world = World::new(context, scene).expect("room for the scene");
    let ism = opened(Ism::new(context, &world, &spec(text).settings()), text);
    let mut opened = Opened::new(context, Box::new(ism), true);
    opened.build(&world).expect(text);
    opened.technique
}

/// Returns why a spec is refused for a scene, or `None` if it is accepted.
fn refusal(context: &Context, scene: &Scene, text: &str) -> Option<Need> {
    let world = World::new(context, scene).expect("room for the scene");
    match Ism::new(context, &world, &spec(text).settings()) {
        Ok(_) => None,
        Err(Error::Refused(needs)) => Some(needs),
        Err(error) => panic!("{text}: {error}"),
    }
}
