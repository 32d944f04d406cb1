//! Volumes in a picture: the densities of their fields on the device, marched along each pixel's ray. Twin: reference::truth::picture.

use super::Renderer;
use crate::gpu::{Bindings, Blend, Buffer, Constants, Context, Draw, Graphics, Kernel, Memory, push_struct};
use crate::scene::{Blended, CORNERS, SIDE, Volume};
use crate::shaders::{set, shading as shaders};
use crate::technique::Answer;
use crate::world::World;
use crate::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// Placement and appearance of a volume's field, and the location of its data. Twin: FieldPlace in glsl/world/field.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FieldData {
    /// Position of the lowest sample, in world units.
    pub origin: [f32; 3],
    /// Extinction at density 1, in 1 / world unit.
    pub extinction: f32,
    /// For each axis of the field, the vector whose dot product with a world offset gives samples along that axis.
    pub rows: [[f32; 3]; 3],
    /// Distance from the lowest to the highest sample along each axis, in samples.
    pub size: [f32; 3],
    /// Index of the field's first slot among the slots of all fields.
    pub first_slot: u32,
    /// Albedo.
    pub color: [f32; 3],
    /// Number of slots minus 1. The number of slots is a power of 2.
    pub last_slot: u32,
    /// Index of the field's first block among the blocks of all fields.
    pub first_block: u32,
}

/// A slot of the hash table that finds a block by its position. Twin: FieldSlot in glsl/world/field.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SlotData {
    /// Position of the block, in blocks from the field's lowest.
    pub block: [u32; 3],
    /// Number of the block among the blocks of its field, counted from 1; 0 for an empty slot.
    pub number: u32,
}

/// The data of all fields, in the device's layout.
#[derive(Default)]
struct Fields {
    places: Vec<FieldData>,
    slots: Vec<SlotData>,
    samples: Vec<f32>,
}

/// The volumes of a picture, with their data on the device.
pub(super) struct Volumes {
    volumes: Vec<Volume>,
    /// Extinction ratio of each volume if casters have several ratios; otherwise 1.
    pub(super) ratios: Vec<[f32; 3]>,
    places: Buffer,
    slots: Buffer,
    samples: Buffer,
    pub(super) bindings: Bindings,
}

push_struct! {
    /// Twin: VolumePush in glsl/shading/volume.glsl.
    pub(super) struct VolumePush {
        volume: u32,
        /// The volume's own extinction ratio if the scene's casters have several; otherwise 1.
        ratio: [f32; 3],
    }
}

/// Marches volumes, lit by one technique: one kernel, or one per channel.
pub(super) struct VolumeKernel(Vec<Kernel<VolumePush>>);

/// Twin: `field_hash`.
fn hash([x, y, z]: [u32; 3]) -> u32 {
    x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791)
}

impl Fields {
    fn of(volumes: &[Volume]) -> Self {
        let mut all = Self::default();
        volumes.iter().for_each(|volume| all.add(volume));
        all
    }

    fn add(&mut self, volume: &Volume) {
        let (field, placed) = (volume.field(), volume.placed());
        let [low, high] = field.range();
        let first = |axis: usize| placed.steps[axis] * f64::from(low[axis]);
        let row = |step: DVec3| (step / step.length_squared()).as_vec3().into();
        let count = slots_of(field.blocks().len()) as u32;
        self.places.push(FieldData {
            origin: (placed.origin + first(0) + first(1) + first(2)).as_vec3().into(),
            extinction: placed.extinction as f32,
            rows: placed.steps.map(row),
            size: [0, 1, 2].map(|axis| (high[axis] - low[axis]) as f32),
            first_slot: self.slots.len() as u32,
            color: placed.color,
            last_slot: count - 1,
            first_block: (self.samples.len() / CORNERS.pow(3)) as u32,
        });
        let mut slots = vec![SlotData::default(); count as usize];
        for (number, (at, samples)) in (1..).zip(field.blocks()) {
            let block = [0, 1, 2].map(|axis| ((at[axis] - low[axis]) / SIDE as i32) as u32);
            let mut slot = hash(block) & (count - 1);
            // Linear probing terminates, because at least half of the slots are free.
            while slots[slot as usize].number != 0 {
                slot = (slot + 1) & (count - 1);
            }
            slots[slot as usize] = SlotData { block, number };
            self.samples.extend_from_slice(samples);
        }
        self.slots.extend(slots);
    }
}

impl Volumes {
    /// Uploads the world's volumes, if there are any.
    pub(super) fn new(context: &Context, world: &World) -> Result<Option<Self>> {
        if !world.kinds().volumes {
            return Ok(None);
        }
        let scene = world.scene()?;
        let volumes = scene.volumes.clone();
        let Fields { places, slots, samples } = Fields::of(&volumes);
        // Volumes from a sequence of files may have more blocks at other times.
        let most = scene.most_blocks();
        let (most_slots, most_samples) =
            (most.iter().map(|blocks| slots_of(*blocks)).sum(), most.iter().sum::<usize>() * CORNERS.pow(3));
        let places = filled(context, "picture.field_places", &places, most.len())?;
        let slots = filled(context, "picture.field_slots", &slots, most_slots)?;
        let samples = filled(context, "picture.field_samples", &samples, most_samples)?;
        let sets = set::PictureFields { field_places: &places, field_slots: &slots, field_samples: &samples };
        let bindings = sets.bind(context, "picture.fields")?;
        let ratios = scene.volume_ratios();
        Ok(Some(Self { volumes, ratios, places, slots, samples, bindings }))
    }

    /// Writes the current volumes, with no more blocks than the buffer's capacity. Unchanged volumes are not written again.
    pub(super) fn look(&mut self, world: &World) -> Result<()> {
        let scene = world.scene()?;
        if scene.volumes == self.volumes {
            return Ok(());
        }
        let Fields { places, slots, samples } = Fields::of(&scene.volumes);
        let fits = size_of_val(&*places) as u64 <= self.places.bytes()
            && size_of_val(&*slots) as u64 <= self.slots.bytes()
            && size_of_val(&*samples) as u64 <= self.samples.bytes();
        if !fits {
            return Err(Error::input(
                world.name(),
                "its volumes have more blocks than a renderer was made for",
                "make a new one",
            ));
        }
        self.places.write(&places)?;
        self.slots.write(&slots)?;
        self.samples.write(&samples)?;
        self.volumes.clone_from(&scene.volumes);
        self.ratios = scene.volume_ratios();
        Ok(())
    }
}

/// Returns the number of slots for `blocks` blocks; at least half of the slots stay free.
fn slots_of(blocks: usize) -> usize {
    (2 * blocks).next_power_of_two()
}

/// Creates a buffer that contains `data` and has a capacity of `most` elements.
fn filled<T: Pod>(context: &Context, name: &str, data: &[T], most: usize) -> Result<Buffer> {
    let bytes = size_of::<T>() * most.max(data.len());
    let buffer = Buffer::new(context, name, bytes as u64, Memory::Device)?;
    buffer.write(data).map(|()| buffer)
}

impl Renderer {
    /// Creates the kernel that marches volumes, lit by `answer`; `None` if there are no volumes.
    pub(super) fn volume_kernel(&self, answer: &Answer) -> Result<Option<VolumeKernel>> {
        let Some(volumes) = &self.volumes else { return Ok(None) };
        let sets = [&self.scene.set, answer.bindings, &self.targets.distances, &volumes.bindings];
        let kernel = |(blend, constants): (Blend, Constants)| {
            let state = Graphics {
                vertex: &shaders::FULLSCREEN_VERT,
                fragment: shaders::VOLUME_FRAG.of(answer.folder),
                colors: &[(self.targets.format, blend)],
                depth: None,
            };
            Kernel::graphics(&self.context, &state, &sets, &constants)
        };
        let channels = self.channels(answer.constants).into_iter().map(kernel);
        Ok(Some(VolumeKernel(channels.collect::<Result<_>>()?)))
    }

    /// Draws casters and volumes from far to near, into one channel or all channels at once: the casters at positions `part` of the order,
    /// and the volumes among them. `casters` draws a range of casters, given by their positions in the order.
    pub(super) fn draw_blended<'a>(
        &self,
        draw: &mut Draw<'_, '_, 'a>,
        part: &std::ops::Range<u32>,
        volumes: Option<&VolumeKernel>,
        channel: usize,
        mut casters: impl FnMut(&mut Draw<'_, '_, 'a>, std::ops::Range<u32>),
    ) {
        for next in self.blending.within(part) {
            match next {
                Blended::Casters(places) => casters(draw, places),
                Blended::Volume(volume) => {
                    if let Some((kernel, volumes)) = volumes.zip(self.volumes.as_ref()) {
                        let ratio = volumes.ratios[volume as usize];
                        draw.draw(&kernel.0[channel], &VolumePush { volume, ratio }, 3, 1);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Field, Placed};
    use std::sync::Arc;

    /// Stores the same field twice. In both copies, linear probing from a block's hash must find the block, with the field's samples. The
    /// copies must not share blocks.
    #[test]
    fn blocks_are_found() {
        let samples = (0..400).map(|i: i32| ([i * 37 % 211 - 100, i * 53 % 97, i * 71 % 131 - 7], 1.0 + i as f32));
        let field = Arc::new(Field::new(samples).expect("a field"));
        let steps = [0.5 * DVec3::X, DVec3::Y, 0.25 * DVec3::Z];
        let placed = Placed { origin: DVec3::ONE, steps, extinction: 2.0, color: [0.5; 3], side: 8 };
        let volume = Volume::new(field.clone(), placed).expect("a volume");
        let all = Fields::of(&[volume.clone(), volume]);
        let [low, _] = field.range();
        for place in &all.places {
            let origin = [1.0 + 0.5 * low[0] as f32, 1.0 + low[1] as f32, 1.0 + 0.25 * low[2] as f32];
            assert_eq!((place.origin, place.rows[2]), (origin, [0.0, 0.0, 4.0]));
            for (at, samples) in field.blocks() {
                let block = [0, 1, 2].map(|axis| ((at[axis] - low[axis]) / 8) as u32);
                let slots = (0..).map(|i| hash(block).wrapping_add(i) & place.last_slot);
                let slot = slots
                    .map(|slot| all.slots[(place.first_slot + slot) as usize])
                    .find(|slot| slot.number == 0 || slot.block == block)
                    .expect("a slot");
                assert_ne!(slot.number, 0, "{block:?}");
                let first = 729 * (place.first_block + slot.number - 1) as usize;
                assert_eq!(all.samples[first..first + 729], *samples, "{block:?}");
            }
        }
        assert_ne!(all.places[0].first_block, all.places[1].first_block);
    }
}
