//! Recording for an adopted device: every path of every technique, and every consumer of their look-ups, gives the same bits as on a device
//! of its own, without a submission.

use crate::gpu::adopt::{adopted, everything};
use crate::support::alike::assert_alike;
use crate::support::foreign::{Foreign, Wanted};
use crate::support::{all_paths, ask, every_third, gpu_test, is_usual, scenes, skipped, spec};
use gobo::animate::{AnimatedScene, Simulation};
use gobo::gpu::{Buffer, Commands, Context, Image, Memory, ReadBack};
use gobo::lights::indirect::{Vpls, light_of};
use gobo::query::{Query, Slice, slice};
use gobo::reference::truth::space_points;
use gobo::scene::{Caster, Fog, Light, LightKind, Scene, View};
use gobo::shading::{Lighting, Renderer, Shading, Tiled};
use gobo::technique::{self, BuildStatus, Name, Spec};
use gobo::world::{LightData, World};
use gobo::{Error, Need};

fn wanted() -> Wanted {
    Wanted { enabled: everything(), frames: 2, allocator: true }
}

/// Large thin smoke with more segments per texel than lists start with, around a box over a ground.
fn scene() -> Scene {
    let mut scene = scenes::crowd();
    scene.meshes = vec![scenes::level(-1.0, 1.5, [0.0; 2]), scenes::cuboid([-0.3; 3], [0.3, 0.2, 0.1])];
    scene
}

/// Returns the scene under a light that the spec's technique supports.
fn lit(spec: &Spec) -> Scene {
    let mut scene = scene();
    let lamp = LightKind::Virtual { position: glam::DVec3::Z * 2.5, normal: glam::DVec3::NEG_Z, nearest: 0.1 };
    match spec.entry.name {
        "ism" => scene.lights[0].kind = lamp,
        // A second light, so that the bake is split into two parts.
        "voxelized" => scene.lights.push(scene.lights[0]),
        _ => {}
    }
    scene
}

/// Returns the look-ups of a spec's technique once it no longer grows, the number of times it grew, and the number of times it had a
/// further part to build.
fn recorded(foreign: &mut Foreign, context: &Context, scene: &Scene, spec: &Spec) -> (Vec<f32>, [usize; 2]) {
    let text = spec.short();
    let points = space_points(scene, 0, 1000);
    let world = World::new(context, scene).expect("room for the scene");
    let mut technique = technique::open(context, &world, spec).expect(&text).technique;
    let query = Query::new(context, 0, &points).expect("room for the points");
    let kernel = query.kernel(&technique.answer()).expect("compiled");
    let answers = ReadBack::new(context, "answers", 4 * points.len() as u64).expect("room");
    let frames = u64::from(context.frames_in_flight());
    let (mut first, mut still, mut again) = (None, 0, [0; 2]);
    loop {
        let frame = foreign.begin();
        let first = *first.get_or_insert(frame);
        assert!(frame < first + 200, "{text}: it grows and grows");
        if frame >= first + frames {
            let settled = technique.settle(frame - frames).expect(&text);
            again[0] += usize::from(settled == BuildStatus::Retry);
            again[1] += usize::from(settled == BuildStatus::Continue);
            still = if settled == BuildStatus::Done { still + 1 } else { 0 };
            // This frame was recorded after the last change, so its look-ups are complete.
            if still > frames + 1 {
                return (answers.read(frame - frames, points.len()).expect("read").expect("asked"), again);
            }
        }
        foreign.record(context, frame, |commands| {
            technique.record(commands, &world).expect(&text);
            query.record(commands, &kernel);
            commands.read_back(query.buffer(), &answers);
        });
    }
}

#[test]
fn every_path_is_only_recorded() {
    if crate::support::is_costly("every_path_is_only_recorded") {
        return;
    }
    const TEST: &str = "every_path_is_only_recorded";
    let mut own = Vec::new();
    gpu_test(TEST, |context| {
        for mut spec in every_third(TEST, all_paths()) {
            if spec.entry.keys.iter().any(|key| key.name == "filter") && spec.entry.name != "voxelized" {
                spec.set(Name::SIZE, "32");
            }
            let scene = lit(&spec);
            let world = World::new(context, &scene).expect("room for the scene");
            match technique::open(context, &world, &spec) {
                Ok(mut opened) => {
                    opened.build(&world).unwrap_or_else(|error| panic!("{}: {error}", spec.short()));
                    let points = space_points(&scene, 0, 1000);
                    own.push((spec, ask(context, opened.technique.as_ref(), 0, &points)));
                }
                Err(Error::Refused(needs)) => skipped(TEST, &format!("{}: needs {needs}", spec.short())),
                Err(error) => panic!("{}: {error}", spec.short()),
            }
        }
    });
    adopted(TEST, &wanted(), |foreign, context| {
        let mut grew = [0; 2];
        for (spec, own) in &own {
            let (answers, again) = recorded(foreign, context, &lit(spec), spec);
            println!("{}: grew {} times, {} parts more", spec.short(), again[0], again[1]);
            let what = format!("{}: on a device of its own", spec.short());
            assert_alike(spec, scene().casters().len(), &answers, own, &what);
            assert!(own.iter().any(|answer| *answer < 0.9), "{}: nothing is in shadow", spec.short());
            grew = [grew[0] + again[0], grew[1] + again[1]];
        }
        // At least one technique grew, and at least one built in several parts.
        assert!(is_usual() || grew[0] > 0 && grew[1] > 0, "nothing has grown, or had parts: {grew:?}");
    });
}

/// Results of the consumers, as bits.
#[derive(Default, PartialEq)]
struct Consumed {
    /// Pictures by shading, then with fog.
    pictures: Vec<Vec<u32>>,
    slice: Vec<f32>,
    lights: Vec<Light>,
    casters: Vec<Caster>,
}

const SIZE: [u32; 2] = [48, 32];
const FOG: Fog = Fog { extinction: 0.2, steps: 4 };
const SHADINGS: [fn() -> Shading; 4] =
    [|| Shading::Forward, || Shading::Deferred, || Shading::Tiled(Tiled::default()), || Shading::Interleaved];

/// Returns the number of words in a picture's texel.
fn words(context: &Context) -> usize {
    if context.features().float32_blend { 4 } else { 2 }
}

fn picture(context: &Context, image: &Image) -> Vec<u32> {
    if words(context) == 4 {
        return image.read::<[u32; 4]>().expect("read").concat();
    }
    image.read::<[u32; 2]>().expect("read").concat()
}

/// Runs the consumers on a device of Gobo's own, with a submission each.
fn submitted(context: &Context) -> Consumed {
    let (mut all, scene) = (Consumed::default(), scene());
    let world = World::new(context, &scene).expect("room");
    let mut avsm = technique::open(context, &world, &spec("avsm:size=32")).expect("avsm");
    avsm.build(&world).expect("built");
    let answer = avsm.technique.answer();
    let camera = View::camera(&scene.camera, &scene, SIZE);
    let renderer = Renderer::new(context, &world, &camera).expect("room");
    for shading in SHADINGS {
        renderer.picture(&answer, shading(), Lighting::Fragment).expect("drawn");
        all.pictures.push(picture(context, renderer.image()));
    }
    renderer.fog(&answer, &FOG).expect("drawn");
    all.pictures.push(picture(context, renderer.image()));
    let view = avsm.technique.inspect().maps()[0].caster_view;
    all.slice = slice(context, 0, &view, &answer, 0.5, SIZE).expect("asked");
    let mut vpls = Vpls::new(context, &world, 64).expect("room");
    vpls.make(&world).expect("made");
    all.lights = vpls.read().expect("read");
    let (mut world, mut simulation) = fountain(context);
    for time_s in TIMES {
        simulation.move_to(&mut world, time_s).expect("moved");
    }
    all.casters = world.buffers().casters.read(world.caster_count() as usize).expect("read");
    all
}

fn fountain(context: &Context) -> (World, Simulation) {
    let animated = AnimatedScene::load("fountain:particles=200", 0.0).expect("built in");
    let world = World::new(context, &animated.scene).expect("room");
    let simulation = Simulation::new(context, &world, animated.fountain().expect("a fountain")).expect("room");
    (world, simulation)
}

const TIMES: [f64; 3] = [3.0, 3.1, 3.1];

/// Runs a frame and waits for it.
fn frame(foreign: &mut Foreign, context: &Context, record: impl FnOnce(&mut Commands)) -> u64 {
    let frame = foreign.begin();
    foreign.record(context, frame, record);
    foreign.wait();
    frame
}

/// Runs the consumers in recorded command buffers.
fn only_recorded(foreign: &mut Foreign, context: &Context) -> Consumed {
    let (mut all, scene) = (Consumed::default(), scene());
    let world = World::new(context, &scene).expect("room");
    let mut avsm = technique::open(context, &world, &spec("avsm:size=32")).expect("avsm").technique;
    loop {
        let built = frame(foreign, context, |commands| avsm.record(commands, &world).expect("recorded"));
        if avsm.settle(built).expect("settled") == BuildStatus::Done {
            break;
        }
    }
    let answer = avsm.answer();
    let camera = View::camera(&scene.camera, &scene, SIZE);
    let renderer = Renderer::new(context, &world, &camera).expect("room");
    let words = words(context) * (SIZE[0] * SIZE[1]) as usize;
    let copy = Buffer::new(context, "copy", 4 * words as u64, Memory::Device).expect("room");
    let read = ReadBack::new(context, "picture", 4 * words as u64).expect("room");
    let copied = |commands: &mut Commands| {
        commands.pass("copy", |pass| pass.copy_image(renderer.image(), &copy));
        commands.read_back(&copy, &read);
    };
    for shading in SHADINGS {
        let kernels = renderer.kernels(&answer, shading(), Lighting::Fragment).expect("compiled");
        let mut last = 0;
        for _ in 0..shading().frames_to_settle() {
            last = frame(foreign, context, |commands| {
                renderer.record(commands, &kernels).expect("recorded");
                copied(commands);
            });
        }
        all.pictures.push(read.read(last, words).expect("read").expect("copied"));
    }
    let fog = renderer.fog_kernel(&answer).expect("compiled");
    let last = frame(foreign, context, |commands| {
        renderer.record_fog(commands, &fog, &FOG);
        copied(commands);
    });
    all.pictures.push(read.read(last, words).expect("read").expect("copied"));

    let slice = Slice::new(context, 0, &avsm.inspect().maps()[0].caster_view, &answer, 0.5, SIZE).expect("room");
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let read = ReadBack::new(context, "slice", 4 * pixels as u64).expect("room");
    let last = frame(foreign, context, |commands| {
        slice.record(commands);
        commands.read_back(slice.buffer(), &read);
    });
    all.slice = read.read(last, pixels).expect("read").expect("copied");

    let mut vpls = Vpls::new(context, &world, 64).expect("room");
    let read = ReadBack::new(context, "lights", vpls.lights().bytes()).expect("room");
    let last = frame(foreign, context, |commands| {
        vpls.record(commands, &world).expect("recorded");
        commands.read_back(vpls.lights(), &read);
    });
    vpls.settle(last).expect("settled");
    let lights = read.read::<LightData>(last, 64).expect("read").expect("copied");
    all.lights = lights.iter().map(light_of).collect();

    let (mut world, mut simulation) = fountain(context);
    let read = ReadBack::new(context, "casters", world.buffers().casters.bytes()).expect("room");
    let mut last = 0;
    for time_s in TIMES {
        last = frame(foreign, context, |commands| {
            simulation.record(commands, &mut world, time_s).expect("recorded");
            commands.read_back(world.buffers().casters, &read);
        });
    }
    all.casters = read.read(last, world.caster_count() as usize).expect("read").expect("copied");
    all
}

/// Asserts that immediate reads are refused with advice.
fn refused(context: &Context) {
    let world = World::new(context, &scene()).expect("room");
    let voxels = technique::open(context, &world, &spec("voxelized:size=64")).expect("voxelized").technique;
    let camera = View::camera(&scene().camera, &scene(), SIZE);
    let renderer = Renderer::new(context, &world, &camera).expect("room");
    let results = [
        ("steps", renderer.steps(&voxels.answer()).map(|_| ())),
        ("read", renderer.read().map(|_| ())),
        ("picture", renderer.picture(&voxels.answer(), Shading::Forward, Lighting::Fragment).map(|_| ())),
        ("casters", world.buffers().casters.read::<Caster>(1).map(|_| ())),
    ];
    for (what, result) in results {
        let Err(Error::Refused(needs)) = result else { panic!("{what}: {result:?}") };
        assert_eq!(needs, Need::Queue, "{what}");
    }
}

#[test]
fn consumers_are_only_recorded() {
    if crate::support::is_costly("consumers_are_only_recorded") {
        return;
    }
    const TEST: &str = "consumers_are_only_recorded";
    let mut own = Consumed::default();
    gpu_test(TEST, |context| own = submitted(context));
    adopted(TEST, &wanted(), |foreign, context| {
        let recorded = only_recorded(foreign, context);
        for (i, (is, own)) in recorded.pictures.iter().zip(&own.pictures).enumerate() {
            assert!(is == own && is.windows(8).any(|pixel| pixel[..4] != pixel[4..]), "picture {i}");
        }
        assert!(recorded.slice == own.slice && own.slice.iter().any(|answer| *answer < 0.9), "slice");
        assert!(recorded.lights == own.lights && own.lights.len() == 64, "virtual lights");
        assert!(recorded.casters == own.casters && own.casters.iter().any(|c| c.position != [0.0; 3]), "particles");
        assert!(recorded == own);
        refused(context);
    });
}
