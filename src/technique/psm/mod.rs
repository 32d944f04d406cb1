//! Particle shadow maps: how much of the light is left behind each slice of a volume. Source: seed 002.
//!
//! - *raster*, the seed's: [`Psm::clear`] the volume, [`Psm::voxelize`] draws each caster into its slice and blends,
//!   [`Psm::propagate`] runs down each ray and multiplies what the slices leave.
//! - *fused*: [`super::bins`] bins casters to tiles, [`Psm::fused`] adds up each tile's in shared memory and writes each
//!   voxel once.
//!
//! A caster's whole optical depth goes to the slice of its centre, or with `assign=split` to the two about it: see
//! glsl/psm/place.glsl; for where the look-up takes the slices to stand, glsl/psm/visibility.glsl. The same input gives the
//! same bytes on the same device.

mod volume;

use self::volume::{COVERAGE_TILES, COVERAGE_VIEWPORT, Volume};
use super::bins::{Bins, Use};
use super::light::{Maps, SceneData};
use super::opaque::OpaqueMap;
use super::{Entry, Key, Path, SKIP, Spec, Technique, Values, Visibility, filter};
use crate::gpu::{
    Bindings, Blend, Border, Commands, Context, Graphics, Image, Layered, PassTime, Pipeline, Requirement, Resource,
    shader,
};
use crate::scene::Scene;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// For the registry.
pub const ENTRY: Entry = Entry {
    name: "psm",
    about: "particle shadow maps: what is left of the light behind each slice of a volume (seed 002)",
    keys: &[
        Key {
            name: "path",
            values: Values::OneOf(&["auto", RASTER, FUSED]),
            default: "auto",
            about: "auto: fused where the device can",
        },
        Key { name: "size", values: Values::Number(8, 512), default: "256", about: "texels a side of a light's map" },
        Key {
            name: "slices",
            values: Values::Multiple(4, 4, 256),
            default: "256",
            about: "slices of the volume, four a texel",
        },
        Key {
            name: "storage",
            values: Values::OneOf(&["rgba8", "rgba16f", OPTICAL_DEPTH]),
            default: "rgba8",
            about: "multiply transmittances in 8 bits (the seed's) or half floats, or add optical depths in half floats",
        },
        Key {
            name: "assign",
            values: Values::OneOf(&["nearest", "split"]),
            default: "nearest",
            about: "a caster goes to its slice (the seed's), or is shared by the two about its centre",
        },
        Key {
            name: "coverage",
            values: Values::OneOf(&["off", "viewport", "tiles"]),
            default: "off",
            about: "rays without casters are not propagated (raster): known from a second viewport (the seed's), from bins",
        },
        Key {
            name: "route",
            values: Values::OneOf(&["auto", "geometry", "vertex"]),
            default: "auto",
            about: "the shader that chooses a caster's layer (raster); auto: vertex where it can, else geometry",
        },
        filter::FILTER,
        filter::RADIUS,
        SKIP,
        super::LIGHTING,
    ],
    paths: &[Path { name: FUSED, requires: &[] }, Path { name: RASTER, requires: &[Requirement::Layers] }],
    open: |context, scene, data, spec| Ok(Box::new(Psm::new(context, scene, data, spec)?)),
};

const RASTER: &str = "raster";
const FUSED: &str = "fused";
const OPTICAL_DEPTH: &str = "optical-depth";

/// Workgroups of glsl/psm/fused.comp: two halves of a tile that has casters, one of a tile to be written over.
const FUSED_PARTS: [u32; 2] = [2, 1];

/// Its shared memory, bytes a slice: half a tile's texels.
const FUSED_SLICE_BYTES: u32 = 32 * 4;

/// Its threads a workgroup, at least and at most; multiples of the former.
const FUSED_THREADS: [u32; 2] = [32, 512];

/// What a path builds with.
enum Build {
    Raster(Box<Raster>),
    Fused { bins: Box<Bins>, pipeline: Pipeline },
}

/// What path=raster builds with.
struct Raster {
    scene: Bindings,
    voxelize: Pipeline,
    /// Vertices a caster.
    vertices: u32,
    /// Texels a side, of the slices and of the coverage.
    viewports: Vec<u32>,
    /// Maps, and counts of the bins where they are the coverage.
    rays: Bindings,
    propagate: Pipeline,
    bins: Option<Box<Bins>>,
}

/// The technique, opened for one scene.
pub struct Psm {
    context: Context,
    /// Four slices a texel, map after map.
    pub volume: Image,
    /// How the volume is laid out.
    layout: Volume,
    map_count: u32,
    caster_count: u32,
    storage: Bindings,
    opaque: OpaqueMap,
    build: Build,
    visibility: Bindings,
    /// SLICES, SPLIT, ADDITIVE, LAYERS, COVERAGE, FILTER, FILTER_RADIUS, STRANDS.
    constants: [u32; 8],
    reason: String,
    /// Whether an unchanged scene is not built again.
    skip: bool,
    built: bool,
}

impl Psm {
    /// Opens the path that `spec` names for `scene`.
    ///
    /// # Errors
    /// [`Error::Refused`] where the device lacks what the path needs, [`Error::Gpu`] where the
    /// volume is past its limits or memory runs out.
    pub fn new(context: &Context, scene: &Scene, data: &SceneData, spec: &Spec) -> Result<Self> {
        let [least, most] = FUSED_THREADS;
        // The threads of a software device do not run at the same time, and each costs it something.
        let cpu = context.features().kind == "cpu";
        let room = context.features().max_compute_workgroup_threads / least * least;
        Self::with_threads(context, scene, data, spec, if cpu { least } else { room.clamp(least, most) })
    }

    /// As [`Psm::new`], with so many threads a workgroup of path=fused, a multiple of 32, instead of what suits the device.
    ///
    /// # Errors
    /// As [`Psm::new`].
    pub fn with_threads(
        context: &Context,
        scene: &Scene,
        data: &SceneData,
        spec: &Spec,
        fused_threads: u32,
    ) -> Result<Self> {
        let layout = Volume::new(spec);
        let (path, reason) = choose(context, spec)?;
        let filter = filter::constants(scene, spec)?;
        let maps = Maps::new(context, scene, layout.size)?;
        let volume = layout.image(context, maps.count(), path == RASTER)?;
        let opaque = OpaqueMap::new(context, data, &maps)?;
        let constants = layout.constants(filter, !scene.strands.is_empty());
        let skip = spec.value("skip") == "on";
        let storage = Bindings::new(context, "psm.volume", &[Resource::StorageImage(volume.clone())])?;
        let build = if path == FUSED {
            let reach = 1 + if filter[0] == 0 { 0 } else { filter[1] };
            let what = Use { entries: true, skip, reach, parts: FUSED_PARTS };
            let bins = Box::new(Bins::new(context, data, &maps, &opaque, what)?);
            let sets = [bins.scene_bindings(), bins.bindings(), &storage];
            let shader = shader(&format!("psm/fused.comp/{}", layout.bits))?;
            let constants = [&constants[..], &[fused_threads, fused_threads]].concat();
            let pipeline = Pipeline::compute(context, shader, &sets, &constants)?;
            Build::Fused { bins, pipeline }
        } else {
            Build::Raster(Box::new(Raster::new(context, data, (&maps, &opaque), spec, &layout, &storage, &constants)?))
        };
        let border = if layout.additive { Border::Zero } else { Border::One };
        let resources = [
            Resource::Buffer(maps.lights.clone()),
            Resource::Sampled(volume.clone(), border),
            Resource::Texture(opaque.image.clone()),
            Resource::Buffer(maps.buffer.clone()),
        ];
        Ok(Self {
            context: context.clone(),
            volume,
            layout,
            map_count: maps.count(),
            caster_count: data.caster_count,
            storage,
            opaque,
            build,
            visibility: Bindings::new(context, "psm.visibility", &resources)?,
            constants,
            reason,
            skip,
            built: false,
        })
    }

    /// Raster: no caster anywhere.
    pub fn clear(&self, commands: &mut Commands) {
        let empty = if self.layout.additive { 0.0 } else { 1.0 };
        commands.pass("psm.clear", |pass| pass.clear_volume(&self.volume, empty));
    }

    /// Raster: draws all casters into the slices of a map; nothing for path=fused.
    pub fn voxelize(&self, commands: &mut Commands, map: u32) {
        let Build::Raster(raster) = &self.build else { return };
        commands.pass("psm.voxelize", |pass| {
            pass.render_layers(&self.volume, &raster.viewports, |draw| {
                let vertices = raster.vertices * self.caster_count;
                draw.draw(&raster.voxelize, &[&raster.scene], bytemuck::bytes_of(&map), vertices);
            });
        });
    }

    /// Raster: from what the slices of a map leave to what is left behind them; nothing for path=fused.
    pub fn propagate(&self, commands: &mut Commands, map: u32) {
        let Build::Raster(raster) = &self.build else { return };
        commands.pass("psm.propagate", |pass| {
            let sets = [&raster.rays, &self.storage];
            pass.dispatch(&raster.propagate, &sets, bytemuck::bytes_of(&map), self.layout.tiles());
        });
    }

    /// Fused: builds each tile of a map.
    fn fused(&self, commands: &mut Commands, map: u32, bins: &Bins, pipeline: &Pipeline) {
        commands.pass("psm.fused", |pass| {
            bins.per_part(pass, map, pipeline, &[bins.scene_bindings(), bins.bindings(), &self.storage]);
        });
    }
}

impl Raster {
    fn new(
        context: &Context,
        data: &SceneData,
        (maps, opaque): (&Maps, &OpaqueMap),
        spec: &Spec,
        layout: &Volume,
        storage: &Bindings,
        constants: &[u32],
    ) -> Result<Self> {
        let by_geometry = match spec.value("route") {
            "geometry" => true,
            "vertex" => false,
            _ => context.features().lacks(Requirement::VertexLayers).is_some(),
        };
        let needs = if by_geometry { Requirement::GeometryLayers } else { Requirement::VertexLayers };
        super::require(context, &[needs])?;
        let resources = [Resource::Buffer(maps.buffer.clone()), Resource::Buffer(data.casters.clone())];
        let scene = Bindings::new(context, "psm.scene", &resources)?;
        let blend = if layout.additive { Blend::Add } else { Blend::Multiply };
        let state = Graphics {
            vertex: shader(if by_geometry { "psm/caster.vert" } else { "psm/voxelize.vert" })?,
            fragment: shader("psm/voxelize.frag")?,
            colors: &[(layout.format, blend)],
            depth: false,
        };
        let viewports = layout.viewports();
        if viewports.len() > 1 && context.features().max_viewports < 2 {
            return Err(Error::Refused { needs: "multiViewport: coverage=viewport draws to two".into() });
        }
        let geometry = if by_geometry { Some(shader("psm/voxelize.geom")?) } else { None };
        let layered = Layered { geometry, viewports: viewports.len() as u32 };
        let voxelize = Pipeline::layered(context, &state, &layered, &[&scene], constants)?;
        let quads = 1 + u32::from(layout.split) + u32::from(layout.coverage == COVERAGE_VIEWPORT);
        let bins = match layout.coverage {
            COVERAGE_TILES => {
                // All tiles that casters meet, whether light gets there or not.
                let what = Use { entries: false, skip: false, reach: 0, parts: [0, 0] };
                Some(Box::new(Bins::new(context, data, maps, opaque, what)?))
            }
            _ => None,
        };
        let counts = bins.as_ref().map_or(&maps.buffer, |b| &b.counts);
        let resources = [Resource::Buffer(maps.buffer.clone()), Resource::Buffer(counts.clone())];
        let rays = Bindings::new(context, "psm.rays", &resources)?;
        let propagate = shader(&format!("psm/propagate.comp/{}", layout.bits))?;
        let propagate = Pipeline::compute(context, propagate, &[&rays, storage], constants)?;
        let vertices = if by_geometry { 1 } else { 6 * quads };
        Ok(Self { scene, voxelize, vertices, viewports, rays, propagate, bins })
    }
}

/// The path and why. `auto` is fused wherever it runs: it writes each voxel once and blends nothing.
fn choose(context: &Context, spec: &Spec) -> Result<(&'static str, String)> {
    let (has, wants) = (context.features().max_compute_shared_memory_bytes, spec.number("slices") * FUSED_SLICE_BYTES);
    let lacks_room = (has < wants)
        .then(|| format!("maxComputeSharedMemorySize of at least {wants} for as many slices (this device has {has})"));
    let wants_raster = [("coverage", "off"), ("route", "auto")].into_iter().find(|(k, v)| spec.value(k) != *v);
    let (path, reason) = match (spec.value("path"), &lacks_room, wants_raster) {
        (RASTER, ..) => (RASTER, "asked for".to_owned()),
        (FUSED, Some(missing), _) => return Err(Error::Refused { needs: missing.clone() }),
        (FUSED, _, Some((key, _))) => {
            let needs = format!("path=raster: {key}={} has no meaning for path=fused", spec.value(key));
            return Err(Error::Refused { needs });
        }
        (FUSED, ..) => (FUSED, "asked for".to_owned()),
        (_, _, Some((key, _))) => (RASTER, format!("auto: {key}={}", spec.value(key))),
        (_, Some(missing), _) => (RASTER, format!("auto: fused needs {missing}")),
        _ => (FUSED, format!("auto: {} device", context.features().kind)),
    };
    for known in ENTRY.paths.iter().filter(|p| p.name == path) {
        super::require(context, known.requires)?;
    }
    Ok((path, reason))
}

impl Technique for Psm {
    fn changed(&mut self) {
        self.built = false;
    }

    fn build(&mut self) -> Result<Vec<PassTime>> {
        if self.built && self.skip {
            return Ok(Vec::new());
        }
        loop {
            let passes = self.context.submit(|commands| {
                self.opaque.depth(commands);
                match &self.build {
                    Build::Raster(raster) => {
                        self.clear(commands);
                        if let Some(bins) = &raster.bins {
                            bins.clear(commands);
                        }
                        for map in 0..self.map_count {
                            if let Some(bins) = &raster.bins {
                                bins.count(commands, map);
                            }
                            self.voxelize(commands, map);
                            self.propagate(commands, map);
                        }
                    }
                    Build::Fused { bins, pipeline } => {
                        bins.clear(commands);
                        for map in 0..self.map_count {
                            bins.horizon(commands, map);
                            bins.count(commands, map);
                            bins.place(commands, map);
                            bins.scatter(commands, map);
                            self.fused(commands, map, bins, pipeline);
                        }
                    }
                }
            })?;
            let again = match &mut self.build {
                Build::Fused { bins, .. } => bins.grow()?,
                Build::Raster(_) => false,
            };
            if !again {
                self.built = true;
                return Ok(passes);
            }
        }
    }

    fn visibility(&self) -> Visibility<'_> {
        Visibility { folder: ENTRY.name, bindings: &self.visibility, constants: &self.constants }
    }

    fn path(&self) -> &'static str {
        match self.build {
            Build::Raster(_) => RASTER,
            Build::Fused { .. } => FUSED,
        }
    }

    fn reason(&self) -> String {
        self.reason.clone()
    }

    fn bytes_resident(&self) -> u64 {
        self.volume.bytes() + self.opaque.image.bytes()
    }

    fn bytes_transient(&self) -> u64 {
        match &self.build {
            Build::Raster(raster) => raster.bins.as_ref().map_or(0, |b| b.counts.bytes() + b.bytes_transient()),
            Build::Fused { bins, .. } => bins.counts.bytes() + bins.bytes_transient(),
        }
    }

    fn counters(&self) -> Result<BTreeMap<String, u64>> {
        Ok(match &self.build {
            Build::Fused { bins, .. } => bins.counters().into(),
            Build::Raster(_) => BTreeMap::new(),
        })
    }
}
