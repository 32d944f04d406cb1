//! path=raster: clears the volume, draws and blends each caster into its slice, then multiplies the slices' transmittances along each ray.
//! Source: Bavoil and Jansen 2013, Steps 1 to 3 and Coverage Optimization.

use super::volume::{Coverage, Volume};
use crate::Result;
use crate::gpu::{Commands, Constants, Context, Graphics, Image, Kernel, Layered, Requirement, push_struct};
use crate::maps::{Bins, Entries, Maps, Use};
use crate::shaders;
use crate::shaders::constant::MAP_PUSHED;
use crate::shaders::set;
use crate::technique::keys::words;
use crate::world::World;

words! {
    /// The shader that chooses a caster's layer.
    pub enum Route {
        /// The geometry shader.
        Geometry = "geometry",
        /// The vertex shader.
        Vertex = "vertex",
    }
}

push_struct! {
    /// Twin: VoxelizePush in glsl/technique/psm/push.glsl.
    struct VoxelizePush {
        /// Index of the map among the maps of all lights, if each map has its own draw.
        pushed_map: u32,
    }
}

/// The build state of this path.
pub struct Raster {
    volume: Image,
    empty: f32,
    voxelize: Kernel<VoxelizePush>,
    /// Whether each map has its own draw: see glsl/technique/psm/push.glsl.
    map_pushed: bool,
    /// Vertices per caster.
    vertices: u32,
    /// Viewport sides of the slices and of the coverage, in texels.
    viewports: Vec<u32>,
    propagate: Kernel,
    /// Bins for `coverage=tiles`.
    pub bins: Option<Bins>,
    caster_count: u32,
}

impl Raster {
    pub fn new(
        context: &Context,
        world: &World,
        maps: &Maps,
        route: Option<Route>,
        layout: &Volume,
        volume: &Image,
        constants: &Constants,
    ) -> Result<Self> {
        let features = context.features();
        let route = route.unwrap_or(match features.lacks(Requirement::VertexLayers) {
            Some(_) => Route::Geometry,
            None => Route::Vertex,
        });
        let (needs, vertex, geometry) = match route {
            Route::Geometry => {
                (Requirement::GeometryLayers, &shaders::psm::CASTER_VERT, Some(&shaders::psm::VOXELIZE_GEOM))
            }
            Route::Vertex => (Requirement::VertexLayers, &shaders::psm::VOXELIZE_VERT, None),
        };
        features.require(&[needs])?;
        let viewports = layout.viewports();
        if viewports.len() > 1 {
            features.require(&[Requirement::Viewports])?;
        }
        let colors = [(layout.format(), layout.blend())];
        let state = Graphics { vertex, fragment: &shaders::psm::VOXELIZE_FRAG, colors: &colors, depth: None };
        let layered = Layered { geometry, viewports: viewports.len() as u32 };
        let map_pushed = features.is_software();
        let drawing = maps.colored(constants).set(MAP_PUSHED, map_pushed);
        let voxelize = Kernel::layered(context, &state, &layered, &[maps.scene()], &drawing)?;
        let quads = 1 + u32::from(layout.split) + u32::from(layout.coverage == Coverage::Viewport);
        let bins = match layout.coverage {
            Coverage::Tiles => {
                // Lists all tiles that casters touch, whether or not light reaches them: nothing is skipped.
                let what =
                    Use { entries: Entries::None, skip: false, reach: 0, parts: [0, 0], area: false, blocks: None };
                Some(Bins::new(context, world, maps, what)?)
            }
            _ => None,
        };
        let counts = bins.as_ref().map_or(&world.lights, |b| &b.counts);
        let rays = set::PsmRays { counts }.bind(context, "psm.rays")?;
        let storage = set::PsmVolume { volume }.bind(context, "psm.volume")?;
        let propagate =
            if layout.is_8_bit() { &shaders::psm::PROPAGATE_BITS_8 } else { &shaders::psm::PROPAGATE_BITS_16 };
        let propagate = Kernel::compute(context, propagate, &[maps.scene(), &rays, &storage], constants)?;
        Ok(Self {
            volume: volume.clone(),
            empty: layout.empty().0,
            voxelize,
            map_pushed,
            vertices: if route == Route::Geometry { 1 } else { 6 * quads },
            viewports,
            propagate,
            bins,
            caster_count: world.caster_count(),
        })
    }

    pub fn record(&mut self, commands: &mut Commands, world: &World, maps: &Maps) {
        self.caster_count = world.caster_count();
        if let Some(bins) = &mut self.bins {
            bins.record(commands, world);
        }
        self.clear(commands);
        self.voxelize(commands, maps);
        self.propagate(commands, maps);
    }

    /// Empties all slices.
    pub fn clear(&self, commands: &mut Commands) {
        commands.pass("psm.clear", |pass| pass.clear_volume(&self.volume, self.empty));
    }

    /// Draws all casters into the slices of all maps in one render.
    pub fn voxelize(&self, commands: &mut Commands, maps: &Maps) {
        commands.pass("psm.voxelize", |pass| {
            pass.render_layers(&self.volume, &self.viewports, |draw| {
                let (draws, instances) = if self.map_pushed { (maps.count(), 1) } else { (1, maps.count()) };
                for pushed_map in 0..draws {
                    draw.draw(
                        &self.voxelize,
                        &VoxelizePush { pushed_map },
                        self.vertices * self.caster_count,
                        instances,
                    );
                }
            });
        });
    }

    /// Turns the slices' own transmittances into the light left behind each slice.
    pub fn propagate(&self, commands: &mut Commands, maps: &Maps) {
        let [x, y] = maps.tiles();
        commands.pass("psm.propagate", |pass| pass.dispatch(&self.propagate, &(), [x, y, maps.count()]));
    }
}
