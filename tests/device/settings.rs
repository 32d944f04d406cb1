//! Techniques opened from code return the same look-ups as those opened from specs, bit for bit, and are refused alike.

use crate::support::alike::assert_alike;
use crate::support::{gpu_test, scenes, spec};
use gobo::Error;
use gobo::gpu::Context;
use gobo::maps::{FilterKind, OpaqueWay};
use gobo::query::Query;
use gobo::scene::Scene;
use gobo::technique::{
    self, Avsm, BeerShadowMap, DeepShadowMap, DensityGrid, Fourier, GridQuery, Layers, Marched, Moments, Opened,
    OpticalDepthGrid, Psm, RayQuery, ShadowMap, Stochastic, Technique, TranslucencyMap, Uncompressed, Unshadowed,
    VoxelGrid, Voxelized, Wavelet, avsm, beer_shadow_map, deep_shadow_map, density_grid, fourier, grid_query, layers,
    marched, moments, none, optical_depth_grid, psm, ray_query, shadow_map, stochastic, translucency_map, uncompressed,
    voxel_grid, voxelized, wavelet,
};
use gobo::world::World;

/// Opens a technique from code.
type Open = fn(&Context, &World) -> gobo::Result<Box<dyn Technique>>;

/// Techniques that shadow with smoke, opened from code, each with the equivalent spec.
const SMOKE: &[(&str, Open)] = &[
    ("avsm:size=24", |context, world| {
        let settings = avsm::Settings { size: 24, ..Default::default() };
        Ok(Box::new(Avsm::new(context, world, &settings)?))
    }),
    ("avsm:nodes=4,curve=linear,path=two-pass,size=24,storage=packed,filter=box,radius=3", |context, world| {
        let settings = avsm::Settings {
            nodes: 4,
            curve: avsm::Interpolated::Transmittance,
            path: Some(avsm::BuildPath::TwoPass),
            size: 24,
            storage: Some(avsm::Storage::Packed),
            filter: FilterKind::Box,
            radius: 3,
            ..Default::default()
        };
        Ok(Box::new(Avsm::new(context, world, &settings)?))
    }),
    ("psm:size=16,slices=32,storage=optical-depth,assign=split,skip=off", |context, world| {
        let settings = psm::Settings {
            size: 16,
            slices: 32,
            storage: psm::Storage::OpticalDepth,
            assign: psm::Assign::Split,
            skip: false,
            ..Default::default()
        };
        Ok(Box::new(Psm::new(context, world, &settings)?))
    }),
    ("beer-shadow-map:size=20,filter=gaussian,opaque=compute", |context, world| {
        let settings = beer_shadow_map::Settings {
            size: 20,
            filter: FilterKind::Gaussian,
            opaque: Some(OpaqueWay::Compute),
            ..Default::default()
        };
        Ok(Box::new(BeerShadowMap::new(context, world, &settings)?))
    }),
    ("translucency-map:size=20,storage=r16f", |context, world| {
        let settings =
            translucency_map::Settings { size: 20, storage: translucency_map::Storage::R16f, ..Default::default() };
        Ok(Box::new(TranslucencyMap::new(context, world, &settings)?))
    }),
    ("layers:size=20,layers=8,range=front,storage=r16f", |context, world| {
        let (range, storage) = (layers::Range::Front, layers::Storage::F16);
        let settings = layers::Settings { size: 20, layers: 8, range, storage, ..Default::default() };
        Ok(Box::new(Layers::new(context, world, &settings)?))
    }),
    ("deep-shadow-map:size=20,error=250,path=binned", |context, world| {
        let path = Some(deep_shadow_map::BuildPath::Binned);
        let settings = deep_shadow_map::Settings { size: 20, error: 250, path, ..Default::default() };
        Ok(Box::new(DeepShadowMap::new(context, world, &settings)?))
    }),
    ("fourier:size=20,coefficients=7,range=scene", |context, world| {
        let range = technique::sums::Range::Scene;
        Ok(Box::new(Fourier::new(
            context,
            world,
            &fourier::Settings { size: 20, coefficients: 7, range, ..Default::default() },
        )?))
    }),
    ("moments:size=20,moments=8,basis=trigonometric,overestimation=25", |context, world| {
        let basis = moments::Basis::Trigonometric;
        let settings = moments::Settings { size: 20, moments: 8, basis, overestimation: 25, ..Default::default() };
        Ok(Box::new(Moments::new(context, world, &settings)?))
    }),
    ("wavelet:size=20,rank=2,storage=r16f", |context, world| {
        let storage = technique::sums::Storage::F16;
        Ok(Box::new(Wavelet::new(
            context,
            world,
            &wavelet::Settings { size: 20, rank: 2, storage, ..Default::default() },
        )?))
    }),
    ("uncompressed:size=20,radius=1", |context, world| {
        let settings = uncompressed::Settings { size: 20, radius: 1, ..Default::default() };
        Ok(Box::new(Uncompressed::new(context, world, &settings)?))
    }),
    ("stochastic:size=20,samples=4,sampling=stratified", |context, world| {
        let sampling = stochastic::Sampling::Stratified;
        let settings = stochastic::Settings { size: 20, samples: 4, sampling, ..Default::default() };
        Ok(Box::new(Stochastic::new(context, world, &settings)?))
    }),
    ("density-grid:size=64,march=steps,steps=20,direction=mean", |context, world| {
        let (march, direction) = (density_grid::March::Steps, density_grid::Direction::Mean);
        let settings = density_grid::Settings { size: 64, march, steps: 20, direction, ..Default::default() };
        Ok(Box::new(DensityGrid::new(context, world, &settings)?))
    }),
    ("optical-depth-grid:cells=32,bake=round-robin,frames=4", |context, world| {
        let bake = optical_depth_grid::Bake::RoundRobin;
        let settings = optical_depth_grid::Settings { cells: 32, bake, frames: 4, ..Default::default() };
        Ok(Box::new(OpticalDepthGrid::new(context, world, &settings)?))
    }),
    ("marched:nodes=4,samples=16,size=20,grid=64,absolute=30", |context, world| {
        let settings =
            marched::Settings { nodes: 4, samples: 16, size: 20, grid: 64, absolute: 30, ..Default::default() };
        Ok(Box::new(Marched::new(context, world, &settings)?))
    }),
    ("grid-query:size=128", |context, world| {
        Ok(Box::new(GridQuery::new(context, world, &grid_query::Settings { size: 128 })?))
    }),
    ("voxel-grid:size=64,march=cone,aperture=4", |context, world| {
        let march = voxel_grid::March::Cone;
        let settings = voxel_grid::Settings { size: 64, march, aperture: 4, ..Default::default() };
        Ok(Box::new(VoxelGrid::new(context, world, &settings)?))
    }),
];

/// The same for techniques that shadow with meshes.
const MESHES: &[(&str, Open)] = &[
    ("shadow-map:size=64,bits=16,filter=3", |context, world| {
        let settings =
            shadow_map::Settings { size: 64, bits: shadow_map::Bits::Sixteen, filter: 3, ..Default::default() };
        Ok(Box::new(ShadowMap::new(context, world, &settings)?))
    }),
    ("voxel-grid:size=64,cell=mask,bias=50", |context, world| {
        let settings = voxel_grid::Settings { size: 64, cell: voxel_grid::Cell::Mask, bias: 50, ..Default::default() };
        Ok(Box::new(VoxelGrid::new(context, world, &settings)?))
    }),
    ("voxel-grid:size=64,march=steps,steps=50,offset=10", |context, world| {
        let march = voxel_grid::March::Steps;
        let settings = voxel_grid::Settings { size: 64, march, steps: 50, offset: 10, ..Default::default() };
        Ok(Box::new(VoxelGrid::new(context, world, &settings)?))
    }),
    ("voxel-grid:size=64,cell=triangles", |context, world| {
        let settings = voxel_grid::Settings { size: 64, cell: voxel_grid::Cell::Triangles, ..Default::default() };
        Ok(Box::new(VoxelGrid::new(context, world, &settings)?))
    }),
    ("voxelized:size=64,structure=svo,coverage=conservative,filter=5", |context, world| {
        let settings = voxelized::Settings {
            size: 64,
            structure: voxelized::Structure::Svo,
            coverage: voxelized::Coverage::Conservative,
            filter: 5,
            ..Default::default()
        };
        Ok(Box::new(Voxelized::new(context, world, &settings)?))
    }),
    ("none", |context, _| Ok(Box::new(Unshadowed::new(context, &none::Settings)?))),
    ("ray-query", |context, world| Ok(Box::new(RayQuery::new(context, world, &ray_query::Settings::default())?))),
];

/// Returns the look-ups in the scene, or the reason for a refusal.
fn answers(
    context: &Context,
    scene: &Scene,
    open: impl Fn(&World) -> gobo::Result<Opened>,
) -> Result<Vec<f32>, String> {
    let world = World::new(context, scene).expect("room for the scene");
    let mut opened = match open(&world) {
        Ok(opened) => opened,
        Err(error @ Error::Refused(_)) => return Err(error.to_string()),
        Err(error) => panic!("{error}"),
    };
    opened.build(&world).expect("built");
    let mut random = scenes::Random::new(31);
    let points: Vec<_> = (0..1000).map(|_| [(); 3].map(|()| random.between(-1.5, 1.5))).collect();
    let query = Query::new(context, 0, &points).expect("room for the points");
    Ok(query.ask(&opened.technique.answer()).expect("answered"))
}

#[test]
fn code_and_specs_answer_alike() {
    if crate::support::is_costly("code_and_specs_answer_alike") {
        return;
    }
    gpu_test("code_and_specs_answer_alike", |context| {
        let meshes = Scene::load("houses", 0.0).expect("built in");
        let smoke = scenes::random();
        for (scene, all) in [(&smoke, SMOKE), (&meshes, MESHES)] {
            for (text, open) in all {
                let spec = spec(text);
                let of_spec = answers(context, scene, |world| technique::open(context, world, &spec));
                let of_code = answers(context, scene, |world| Ok(Opened::new(context, open(context, world)?, true)));
                match (of_spec, of_code) {
                    (Ok(of_spec), Ok(of_code)) => {
                        assert_alike(&spec, scene.casters().len(), &of_code, &of_spec, text);
                    }
                    (of_spec, of_code) => assert_eq!(of_spec.err(), of_code.err(), "{text}"),
                }
            }
        }
    });
}

/// Invalid settings are refused by the constructor in one line, whether they come from code or from a spec.
#[test]
fn code_is_refused_as_specs_are() {
    gpu_test("code_is_refused_as_specs_are", |context| {
        let world = World::new(context, &scenes::random()).expect("room for the scene");
        let said = |error: Option<Error>, what: &str| {
            let error = error.unwrap_or_else(|| panic!("{what} must be refused")).to_string();
            assert!(!error.contains('\n'), "{error}");
            error
        };
        let coverage = psm::Coverage::Tiles;
        let settings =
            psm::Settings { path: Some(psm::BuildPath::Fused), size: 16, slices: 16, coverage, ..Default::default() };
        let of_code = said(Psm::new(context, &world, &settings).err(), "tiles of the fused path");
        let text = "psm:path=fused,size=16,slices=16,coverage=tiles";
        assert_eq!(said(technique::open(context, &world, &spec(text)).err(), text), of_code);
        let settings =
            avsm::Settings { path: Some(avsm::BuildPath::Binned), order: avsm::Order::Captured, ..Default::default() };
        let of_code = said(Avsm::new(context, &world, &settings).err(), "casters as drawn in tiles");
        let text = "avsm:path=binned,order=captured";
        assert_eq!(said(technique::open(context, &world, &spec(text)).err(), text), of_code);
        for (error, names) in [
            (Avsm::new(context, &world, &avsm::Settings { nodes: 5, ..Default::default() }).err(), "nodes=5"),
            (Psm::new(context, &world, &psm::Settings { size: 4, ..Default::default() }).err(), "size=4"),
            (
                BeerShadowMap::new(context, &world, &beer_shadow_map::Settings { radius: 9, ..Default::default() })
                    .err(),
                "radius=9",
            ),
            (
                Voxelized::new(
                    context,
                    &world,
                    &voxelized::Settings { file: Some("a.gobo".into()), ..Default::default() },
                )
                .err(),
                "a.gobo",
            ),
        ] {
            assert!(matches!(error, Some(Error::Input { .. })), "{names}");
            assert!(said(error, names).contains(names), "{names}");
        }
    });
}
