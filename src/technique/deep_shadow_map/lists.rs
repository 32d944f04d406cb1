//! The lists of segments, drawn or captured tile by tile, and the lists of their ends.

use super::DeepPush;
use super::settings::{BuildPath, Settings};
use crate::Result;
use crate::gpu::{Buffer, Commands, Context, Kernel, Memory};
use crate::maps::{Bins, CasterQuads, DrawingOrder, Entries, Keep, List, Maps, SegmentData, Use};
use crate::shaders::deep_shadow_map as shaders;
use crate::world::World;
use std::collections::BTreeMap;
use std::ops::Range;

/// Maximum number of events per segment; an event is one end of a segment.
const EVENTS: u64 = 2;

/// The lists, and the passes that fill them.
pub struct Lists {
    context: Context,
    pub list: List,
    /// [`SegmentData`], with two slots for each segment of `list`.
    pub events: Buffer,
    bins: Option<Bins>,
    /// Builds the lists tile by tile; `None` if casters are drawn.
    capture: Option<Kernel<DeepPush>>,
}

fn events(context: &Context, list: &List) -> Result<Buffer> {
    let bytes = EVENTS * u64::from(list.capacity()) * size_of::<SegmentData>() as u64;
    Buffer::new(context, "deep_shadow_map.events", bytes, Memory::Device)
}

impl Lists {
    pub fn new(context: &Context, world: &World, maps: &Maps, settings: &Settings, way: BuildPath) -> Result<Self> {
        let is_binned = way == BuildPath::Binned;
        let bins = if settings.skip || is_binned {
            let parts = if is_binned { [1, 0] } else { [0, 0] };
            let entries = if is_binned { Entries::Summed } else { Entries::None };
            let reach = settings.filter().reach();
            let what = Use { entries, skip: settings.skip, reach, parts, area: false, blocks: None };
            Some(Bins::new(context, world, maps, what)?)
        } else {
            None
        };
        // With `bytes=`, all nodes are counted before the first is written, so the lists of all maps must exist at the same time.
        let keep = if settings.bytes.is_some() { Keep::All } else { Keep::Some };
        let quads = match way {
            BuildPath::TwoPass => Some(CasterQuads::new(context, world, maps, DrawingOrder::Index, bins.as_ref())?),
            BuildPath::Binned => None,
        };
        let list = List::new(context, maps, quads, keep, None)?.with_events(EVENTS);
        let capture = match &bins {
            Some(bins) if is_binned => {
                let constants = world.constants();
                let sets = [maps.scene(), bins.set(), list.set()];
                Some(Kernel::compute(context, &shaders::CAPTURE, &sets, &constants)?)
            }
            _ => None,
        };
        Ok(Self { context: context.clone(), events: events(context, &list)?, list, bins, capture })
    }

    pub fn begin(&mut self, commands: &mut Commands, world: &World, maps: &Maps) {
        if let Some(bins) = &mut self.bins {
            bins.record(commands, world);
        }
        self.list.begin(commands, world, maps, self.bins.as_ref());
    }

    /// Empties the lists, then fills the lists of `maps`.
    pub fn capture(&self, commands: &mut Commands, maps: Range<u32>, push: &DeepPush) {
        self.list.capture(commands, maps, push.group);
        if let (Some(kernel), Some(bins)) = (&self.capture, &self.bins) {
            commands.pass("deep_shadow_map.capture", |pass| bins.per_part(pass, kernel, push));
        }
    }

    /// Same as [`List::settle`], but also settles the bins. Replaces `events` if the lists grew.
    pub fn settle(&mut self, frame: u64) -> Result<bool> {
        let bins = self.bins.as_mut().map_or(Ok(false), |bins| bins.settle(frame))?;
        let list = self.list.settle(frame)?;
        if list {
            self.events = events(&self.context, &self.list)?;
        }
        Ok(bins || list)
    }

    pub fn bytes(&self) -> u64 {
        self.list.bytes() + self.events.bytes() + self.bins.as_ref().map_or(0, Bins::bytes_transient)
    }

    pub fn counters(&self) -> Result<BTreeMap<String, u64>> {
        let mut counters = self.bins.as_ref().map_or(Ok(BTreeMap::new()), Bins::counters)?;
        counters.insert("fragments".into(), self.list.fragments());
        Ok(counters)
    }
}
