//! Alpha of triangles in the caller's buffers: what follows the triangles is what a scene's meshes give, and holes let light through.

use super::buffers::{buffer, record};
use crate::support::{ask, built, gpu_test, opened, scenes, spec};
use gobo::gpu::Context;
use gobo::scene::{Alpha, AlphaMode, AlphaTexture, Mesh, Scene, Wrap};
use gobo::technique;
use gobo::world::{AlphaAt, Capacity, Corners, Count, Number, TextureAt, World};
use std::sync::Arc;

/// Words per vertex in the caller's buffer: position, place in the texture, factor, and one that is unused.
const STRIDE: usize = 7;

/// Returns one card with holes above a point, and its vertices in a buffer.
fn card(context: &Context, factors: [f32; 4], wrap: Wrap) -> (Mesh, Corners) {
    let corner = |x: f32, y: f32| [x, y, 1.0];
    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mut mesh = scenes::card(corners, 0.5, scenes::leaf(18, wrap));
    mesh.albedo = [0.5; 3];
    let alpha = mesh.alpha.as_mut().expect("a card");
    alpha.factors = factors.to_vec();
    let Alpha { uvs, texture, .. } = alpha.clone();
    let texture = texture.expect("a leaf");
    let mut words = vec![u32::MAX; 3];
    for i in 0..4 {
        let vertex = [&mesh.positions[i][..], &uvs[i], &factors[i..=i], &[f32::NAN]].concat();
        words.extend(vertex.iter().map(|number| number.to_bits()));
    }
    let word = |four: &[u8]| four.iter().rev().fold(0, |word, alpha| word << 8 | u32::from(*alpha));
    let texels: Vec<u32> = texture.texels.chunks(4).map(word).collect();
    let at = AlphaAt {
        mode: AlphaMode::Cut(0.5),
        factor: Number::At(20),
        texture: Some(TextureAt {
            uv: 12,
            texels: buffer(context, &[&[u32::MAX; 2], &texels[..]].concat()),
            offset: 8,
            size: texture.size,
            wrap: texture.wrap,
        }),
    };
    let corners = Corners {
        vertices: buffer(context, &words),
        offset: 12,
        stride: 4 * STRIDE as u32,
        indices: Some((buffer(context, mesh.triangles.as_flattened()), 0)),
        count: Count::Host(2),
        albedo: [0.5; 3],
        alpha: Some(at),
    };
    (mesh, corners)
}

fn scene(mesh: &Mesh) -> Scene {
    Scene { meshes: vec![mesh.clone()], ..scenes::directional("card", [0.0, 0.0, -1.0], Vec::new()) }
}

fn world(context: &Context, corners: &Corners, scene: &Scene, alpha_texels: Option<u32>) -> gobo::Result<World> {
    world_for(context, corners, scene, (2, alpha_texels))
}

/// Like [`world`], with room for this many triangles and texels.
fn world_for(
    context: &Context,
    corners: &Corners,
    scene: &Scene,
    (triangles, alpha_texels): (u32, Option<u32>),
) -> gobo::Result<World> {
    let see_through = scene.sheet_count() > 0;
    let capacity = Capacity { triangles, alpha_texels, see_through, lights: 1, ..Capacity::default() };
    let mut world = World::of(context, capacity)?;
    world.set_box([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0])?;
    let mut updated = Ok(());
    record(context, |commands| {
        world.update_lights(commands, &scene.lights)?;
        updated = world.update_triangles(commands, corners);
        Ok(())
    });
    updated.map(|()| world)
}

/// The words behind the triangles equal those of the same mesh in a scene; every look-up is the same, holes among them.
#[test]
fn alpha_of_buffers_is_that_of_a_scene() {
    gpu_test("alpha_of_buffers_is_that_of_a_scene", |context| {
        for (factors, wrap) in [([1.0; 4], Wrap::Clamp), ([1.0, 0.2, 0.6, 0.9], Wrap::Mirror)] {
            let (mesh, corners) = card(context, factors, wrap);
            let scene = scene(&mesh);
            let theirs = world(context, &corners, &scene, Some(18 * 18)).expect("room");
            let ours = World::new(context, &scene).expect("room");
            // Records begin at a multiple of their size; the words before them, and the last three, belong to nothing.
            let words = |world: &World| {
                let triangles = world.buffers().triangles;
                let mut all = triangles.read::<u32>(triangles.bytes() as usize / 4).expect("read");
                all.truncate(all.len() - 3);
                all.drain(26..36);
                all
            };
            // A scene has levels of its textures behind them.
            let (theirs_words, ours_words) = (words(&theirs), words(&ours));
            assert_eq!(theirs_words, ours_words[..theirs_words.len()]);
            let points: Vec<[f32; 3]> =
                (0..400).map(|i| [(i % 20) as f32 * 0.09 - 0.87, (i / 20) as f32 * 0.09 - 0.87, 0.2]).collect();
            for text in ["shadow-map:opaque=compute", "grid-query"] {
                let expected = ask(context, built(context, &scene, text).as_ref(), 0, &points);
                let mut technique = opened(technique::open(context, &theirs, &spec(text)), text);
                technique.build(&theirs).expect("built");
                let found = ask(context, technique.technique.as_ref(), 0, &points);
                assert_eq!(found, expected, "{text}");
                let lit = found.iter().filter(|answer| **answer > 0.5).count();
                println!("{text}: {lit} of 400 are lit");
                assert!((60..340).contains(&lit), "{text}: {lit} of 400 are lit");
            }
        }
    });
}

/// See-through triangles in the caller's buffers cast what those of a scene cast; other alpha in the same world does too, and a triangle
/// whose place in the texture is not finite casts nothing.
#[test]
fn sheets_of_buffers_are_those_of_a_scene() {
    gpu_test("sheets_of_buffers_are_those_of_a_scene", |context| {
        let (mesh, cut) = card(context, [1.0, 0.2, 0.6, 0.9], Wrap::Mirror);
        let mut glass = mesh.clone();
        glass.alpha.as_mut().expect("a card").mode = AlphaMode::SeeThrough;
        let scene = scene(&glass);
        let through = |change: &dyn Fn(&mut AlphaAt)| {
            let mut corners = cut.clone();
            let at = corners.alpha.as_mut().expect("alpha");
            at.mode = AlphaMode::SeeThrough;
            change(at);
            corners
        };
        let points: Vec<[f32; 3]> =
            (0..400).map(|i| [(i % 20) as f32 * 0.09 - 0.87, (i / 20) as f32 * 0.09 - 0.87, 0.2]).collect();
        for text in ["grid-query", "layers:size=64", "density-grid:size=64"] {
            // More room than triangles.
            let mut world = world_for(context, &through(&|_| {}), &scene, (70, Some(18 * 18))).expect("room");
            let mut technique = opened(technique::open(context, &world, &spec(text)), text);
            let mut answers = |world: &World| {
                technique.build(world).expect("built");
                ask(context, technique.technique.as_ref(), 0, &points)
            };
            let expected = ask(context, built(context, &scene, text).as_ref(), 0, &points);
            let found = answers(&world);
            // The host knows the texture's greatest alpha, by which optical depth is scaled, and grids may be placed otherwise.
            let most = if text == "grid-query" { 1e-5 } else { 0.05 };
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            println!("{text}: off by {off} at most");
            assert!(off <= most, "{text}: {off}");
            let dim = found.iter().filter(|answer| (0.05..0.95).contains(*answer)).count();
            assert!(dim > 50, "{text}: {dim} of 400 are dim");
            record(context, |commands| {
                world.update_triangles(commands, &through(&|at| at.texture.as_mut().expect("one").uv = 24))
            });
            assert!(answers(&world).iter().all(|answer| *answer > 0.99999), "{text}: places that are NaN");
            if text == "grid-query" {
                record(context, |commands| world.update_triangles(commands, &cut));
                let holes = Scene { meshes: vec![mesh.clone()], ..scene.clone() };
                let expected = ask(context, built(context, &holes, text).as_ref(), 0, &points);
                assert_eq!(answers(&world), expected, "{text}: holes");
            }
        }
        let refused = world_for(context, &through(&|_| {}), &Scene { meshes: vec![mesh], ..scene }, (2, Some(400)));
        let told = refused.err().expect("no room for sheets").to_string();
        assert!(told.contains("see-through ones, and the world was made without"), "{told}");
    });
}

/// Alpha that does not fit is refused with its reason; triangles without alpha block all light, in a world that had some before.
#[test]
fn alpha_of_buffers_is_checked() {
    gpu_test("alpha_of_buffers_is_checked", |context| {
        let (mesh, corners) = card(context, [1.0; 4], Wrap::Repeat);
        let scene = scene(&mesh);
        let refused = |corners: &Corners, room| {
            let error = world(context, corners, &scene, room).err().expect("refused").to_string();
            assert_eq!(error.lines().count(), 1, "{error}");
            error
        };
        assert!(refused(&corners, None).contains("the world was made without"));
        assert!(refused(&corners, Some(100)).contains("18 × 18 texels, and the world has room for 100"));
        let with = |change: &dyn Fn(&mut AlphaAt)| {
            let mut other = corners.clone();
            change(other.alpha.as_mut().expect("alpha"));
            other
        };
        assert!(refused(&with(&|at| at.mode = AlphaMode::Cut(0.0)), Some(400)).contains("a cutoff of 0"));
        assert!(refused(&with(&|at| at.mode = AlphaMode::Cut(f32::NAN)), Some(400)).contains("a cutoff of NaN"));
        let large = with(&|at| at.texture.as_mut().expect("one").size = [40, 40]);
        assert!(refused(&large, Some(4000)).contains("40 × 40 texels in a buffer of"));

        // More room than triangles: nothing is read behind the caller's indices.
        let points = [[0.0, 0.0, 0.2], [0.95, 0.95, 0.2], [0.5, 0.0, 0.2]];
        for text in ["grid-query", "voxelized:size=64"] {
            let mut world = world_for(context, &corners, &scene, (500, Some(400))).expect("room");
            let mut technique = opened(technique::open(context, &world, &spec(text)), text);
            technique.build(&world).expect("built");
            assert_eq!(ask(context, technique.technique.as_ref(), 0, &points), [1.0, 1.0, 0.0], "{text}");
            record(context, |commands| world.update_triangles(commands, &Corners { alpha: None, ..corners.clone() }));
            technique.build(&world).expect("built");
            assert_eq!(ask(context, technique.technique.as_ref(), 0, &points), [0.0; 3], "{text}, whole");
            let nowhere = with(&|at| at.texture.as_mut().expect("one").uv = 24);
            record(context, |commands| world.update_triangles(commands, &nowhere));
            technique.build(&world).expect("built");
            assert_eq!(ask(context, technique.technique.as_ref(), 0, &points), [1.0; 3], "{text}, places that are NaN");
        }
    });
}

/// Cards that move keep their holes; other alpha needs a new world.
#[test]
fn cards_move_with_their_holes() {
    gpu_test("cards_move_with_their_holes", |context| {
        let scene = scenes::cards(2);
        let text = "voxel-grid:cell=triangles,size=64";
        let mut world = World::new(context, &scene).expect("room");
        let mut technique = opened(technique::open(context, &world, &spec(text)), text);
        technique.build(&world).expect("built");
        let mut random = scenes::Random::new(4);
        let points: Vec<_> = (0..2000).map(|_| random.point(-0.9, 0.9)).collect();
        let before = ask(context, technique.technique.as_ref(), 0, &points);
        let mut moved = scene.clone();
        moved.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|corner| corner[0] += 0.3);
        world.replace(&moved).expect("it moved alone");
        technique.build(&world).expect("built");
        let after = ask(context, technique.technique.as_ref(), 0, &points);
        assert_eq!(after, ask(context, built(context, &moved, text).as_ref(), 0, &points));
        assert!(before.iter().zip(&after).filter(|(before, after)| before != after).count() > 100);

        let mut refused = |change: &dyn Fn(&mut Scene)| {
            let mut other = moved.clone();
            change(&mut other);
            let error = world.replace(&other).expect_err("it has other alpha").to_string();
            assert!(error.contains("other alpha") && error.lines().count() == 1, "{error}");
        };
        refused(&|scene| scene.meshes[3].alpha = None);
        refused(&|scene| scene.meshes.swap(3, 4));
        refused(&|scene| scene.meshes[3].triangles.swap(0, 1));
        world.replace(&scene).expect("back again");
    });
}

/// Alpha made by hand is checked: nothing on the device reads what is not there.
#[test]
fn alpha_made_by_hand_is_checked() {
    gpu_test("alpha_made_by_hand_is_checked", |context| {
        let (mesh, _) = card(context, [1.0; 4], Wrap::Repeat);
        let refused = |words: &str, change: &dyn Fn(&mut Alpha)| {
            let mut mesh = mesh.clone();
            change(mesh.alpha.as_mut().expect("a card"));
            let error = World::new(context, &scene(&mesh)).err().expect(words).to_string();
            assert!(error.contains("mesh quad") && error.contains(words) && error.lines().count() == 1, "{error}");
        };
        let texture = |change: &dyn Fn(&mut AlphaTexture)| {
            let mut texture = scenes::leaf(18, Wrap::Clamp);
            change(&mut texture);
            Some(Arc::new(texture))
        };
        refused("a cutoff of 0", &|alpha| alpha.mode = AlphaMode::Cut(0.0));
        refused("a cutoff of NaN", &|alpha| alpha.mode = AlphaMode::Cut(f32::NAN));
        refused("3 factors in [0, 1] for 4 vertices", &|alpha| alpha.factors.truncate(3));
        refused("4 factors in [0, 1] for 4 vertices", &|alpha| alpha.factors[1] = 1.5);
        refused("0 finite places in a texture for 4 vertices", &|alpha| alpha.uvs.clear());
        refused("4 finite places", &|alpha| alpha.uvs[2][0] = f32::INFINITY);
        refused("a texture of 18 × 19 texels that has 324", &|alpha| alpha.texture = texture(&|t| t.size[1] = 19));
        refused("a texture of 0 × 18 texels", &|alpha| alpha.texture = texture(&|t| t.size[0] = 0));
        refused("a texture of 18 × 18 texels that has 323", &|alpha| {
            alpha.texture = texture(&|t| t.texels.truncate(323))
        });
    });
}
