//! A context: a device, opened here or supplied by the caller, and uploads that have yet to be recorded.

use crate::gpu::device::device_owner::{Device, Handle, Memory, Parts, allocation_error};
use crate::gpu::device::instance::{choose, create_device, open_instance, physical_devices};
use crate::gpu::profile::executables::Executables;
use crate::gpu::profile::tools::tools;
use crate::gpu::record::frames::Frames;
use crate::gpu::record::pending::Pending;
use crate::gpu::record::recorder::Recorders;
use crate::gpu::resource::pipelines::Pipelines;
use crate::gpu::{Enabled, Features, Messages, Tool};
use crate::{Error, Need, Result};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, Weak};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Index into [`devices`], or part of a device's name; `None` prefers discrete > integrated > virtual > CPU.
    pub device: Option<String>,
    /// Whether to load the validation layer, with synchronization validation. It is an error if it is not installed.
    pub validation: bool,
    /// List that receives the validation layer's messages.
    pub messages: Messages,
}

/// A device owned by the caller, for [`Context::adopt`]. Every handle stays the caller's.
pub struct Adopt {
    /// Vulkan 1.3 entry points. The application must have requested version 1.3 too.
    pub entry: ash::Entry,
    /// The instance that `device` was created from.
    pub instance: ash::Instance,
    /// The physical device behind `device`.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// Queue family of the command buffers to record into. It must support graphics and compute.
    pub queue_family: u32,
    /// Features that the device was opened with. No other feature is used; a path that needs another one is refused
    /// with an error that names the feature.
    pub enabled: Enabled,
    /// Source of device memory; `None` creates an allocator. With [`Enabled::ray_query`], its memory must support
    /// device addresses.
    pub allocator: Option<Arc<Mutex<Allocator>>>,
    /// Number of frames in flight, at least 1: when frame `f` is recorded, frame `f - frames_in_flight` has finished.
    pub frames_in_flight: u32,
    /// List that receives leak reports. Messages of the validation layer go to the caller's messenger.
    pub messages: Messages,
}

/// An open device. Clones share it; the last one closes it, unless the caller owns it.
///
/// Resources may outlive their context, but can then no longer be written or read back.
#[derive(Clone)]
pub struct Context(Arc<Shared>);

/// Fields are dropped in this order.
pub(in crate::gpu) struct Shared {
    /// Queue for submitting commands; `None` on an adopted device.
    pub(in crate::gpu) queue: Option<Queue>,
    /// Work to record before the next pass.
    pub(in crate::gpu) pending: Pending,
    /// Work recorded in the caller's command buffers.
    pub(in crate::gpu) frames: Frames,
    device: Device,
    /// Whether the driver has reported the device as lost. Nothing is submitted after that.
    lost: AtomicBool,
    /// Whether each pass of a submission is timed, rather than only the submission as a whole.
    pub(in crate::gpu) times_passes: AtomicBool,
    /// Layers and tools between the program and the driver, if the device was opened here and reports them.
    tools: Vec<Tool>,
    /// Whether each pass of a submission counts its work.
    pub(in crate::gpu) counts_passes: AtomicBool,
    pub(in crate::gpu) queue_family: u32,
    pub(in crate::gpu) frames_in_flight: u32,
    /// Number of submissions begun.
    pub(in crate::gpu) begun: AtomicU64,
}

/// The queue of a device that was opened here.
pub(in crate::gpu) struct Queue {
    pub(in crate::gpu) handle: vk::Queue,
    pub(in crate::gpu) recorders: Recorders,
}

impl Drop for Shared {
    fn drop(&mut self) {
        if self.queue.is_some() {
            // SAFETY: the device still exists, and nothing more is recorded.
            let _ = unsafe { self.device.device_wait_idle() };
        }
    }
}

/// Lists the features of every Vulkan device, in the order that [`Options::device`] indexes.
///
/// # Errors
/// [`Error::Gpu`] if no Vulkan loader or no driver is installed.
pub fn devices() -> Result<Vec<Features>> {
    let instance = open_instance(false, &Messages::default())?;
    Ok(physical_devices(&instance.instance)?.into_iter().map(|(_, _, features)| features).collect())
}

/// An open device, with everything a context is built from.
struct Open<'a> {
    entry: ash::Entry,
    instance: &'a ash::Instance,
    physical_device: vk::PhysicalDevice,
    handle: Handle,
    queue_family: u32,
    features: Features,
    labels: bool,
    allocator: Option<Arc<Mutex<Allocator>>>,
    frames_in_flight: u32,
    messages: Messages,
}

impl Context {
    /// Opens a device, with a queue that runs recorded commands immediately ([`Context::submit`]).
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is no loader, driver or validation layer, [`Error::Input`] if no device matches
    /// `options.device`, [`Error::Refused`] if the device is below the floor.
    pub fn new(options: &Options) -> Result<Self> {
        let owner = open_instance(options.validation, &options.messages)?;
        let all = physical_devices(&owner.instance)?;
        let (physical_device, family, features) = choose(all, options.device.as_deref())?;
        let queue_family = above_floor(&features, family)?;
        let tools = tools(&owner.instance, physical_device);
        let device = create_device(&owner.instance, physical_device, queue_family, &features)?;
        let instance = owner.instance.clone();
        let open = Open {
            entry: owner.entry.clone(),
            instance: &instance,
            physical_device,
            handle: Handle::Own(device),
            queue_family,
            features,
            labels: owner.messenger.is_some(),
            allocator: None,
            frames_in_flight: 1,
            messages: options.messages.clone(),
        };
        let mut shared = Shared::new(open, Some(owner))?;
        // SAFETY: the device was created with one queue of this family.
        let handle = unsafe { shared.device.get_device_queue(queue_family, 0) };
        let recorders = Recorders::new(&shared.device, queue_family)?;
        shared.tools = tools;
        shared.queue = Some(Queue { handle, recorders });
        Ok(Self(Arc::new(shared)))
    }

    /// Adopts the caller's device. There is no queue, so nothing is submitted or waited for; passes are recorded with
    /// [`crate::gpu::Commands::on`]. None of the caller's handles is destroyed.
    ///
    /// # Errors
    /// [`Error::Refused`] if the device is below the floor or was opened without its features ([`Enabled::FLOOR`]), or
    /// if the queue family lacks graphics or compute; [`Error::Gpu`] if memory runs out.
    ///
    /// # Safety
    /// The handles must be valid, belong together, and stay so until the context and everything created on it are gone.
    /// The device must have been opened with every feature set in `enabled`. All frames must have finished before the
    /// last clone of the context is dropped.
    pub unsafe fn adopt(theirs: Adopt) -> Result<Self> {
        let Adopt { entry, instance, physical_device, device, queue_family, enabled, .. } = theirs;
        // SAFETY: the caller promises that the physical device belongs to this instance.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
        let wanted = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        let family = families.get(queue_family as usize).filter(|f| f.queue_flags.contains(wanted));
        let family = family.map(|_| queue_family);
        let features = Features::read(&instance, physical_device, family).only(&enabled);
        let open = Open {
            entry,
            instance: &instance,
            physical_device,
            handle: Handle::Theirs(device),
            queue_family: above_floor(&features, family)?,
            features,
            labels: enabled.debug_utils,
            allocator: theirs.allocator,
            frames_in_flight: theirs.frames_in_flight.max(1),
            messages: theirs.messages,
        };
        Ok(Self(Arc::new(Shared::new(open, None)?)))
    }

    /// Returns the features that the device has and was opened with.
    pub fn features(&self) -> &Features {
        self.0.device.features()
    }

    /// Returns the active layers and tools that report themselves; empty for an adopted device.
    pub fn tools(&self) -> &[Tool] {
        &self.0.tools
    }

    /// Returns the validation layer's messages, including reports of objects that were never freed.
    pub fn messages(&self) -> &Messages {
        self.0.device.messages()
    }

    /// Returns the number of bytes of device memory still held by resources created here.
    pub fn allocated_bytes(&self) -> u64 {
        self.0.device.allocated_bytes()
    }

    /// Returns the number of frames that may be in flight at once; 1 if each submission is waited for.
    pub fn frames_in_flight(&self) -> u32 {
        self.0.frames_in_flight
    }

    /// Returns the number of pipelines created on the device so far.
    pub fn pipelines(&self) -> usize {
        self.device().pipelines().count()
    }

    /// Sets whether each pass recorded from now on is timed, which is the default, or only each submission as a whole.
    /// A timestamp waits for all work before it, which costs a GPU a few microseconds per pass.
    pub fn time_passes(&self, each: bool) {
        self.0.times_passes.store(each, Ordering::Relaxed);
    }

    /// Sets whether each pass submitted from now on counts its work ([`crate::gpu::PassTime::counts`]). Passes count
    /// only if the device supports it ([`Features::pipeline_statistics_query`]) and passes are timed individually. Off
    /// by default, because counting takes time.
    pub fn count_passes(&self, each: bool) {
        self.0.counts_passes.store(each, Ordering::Relaxed);
    }

    /// Returns whether the device is lost. Once it is, every submission fails.
    pub fn is_lost(&self) -> bool {
        self.0.lost.load(Ordering::Relaxed)
    }

    pub(in crate::gpu) fn shared(&self) -> &Shared {
        &self.0
    }

    pub(in crate::gpu) fn device(&self) -> &Device {
        &self.0.device
    }

    /// Returns the weak reference to the context that the device's resources hold.
    pub(in crate::gpu) fn link(&self) -> Link {
        Link(Arc::downgrade(&self.0))
    }

    /// Returns the queue, which only a device opened here has.
    pub(in crate::gpu) fn queue(&self) -> Result<&Queue> {
        self.0.queue.as_ref().ok_or(Error::Refused(Need::Queue))
    }

    /// Checks that recorded commands can run immediately, and that their results can be read back right after.
    ///
    /// # Errors
    /// [`Error::Refused`] on an adopted device.
    pub(crate) fn require_queue(&self) -> Result<()> {
        self.queue().map(|_| ())
    }

    /// Records that the device is lost, if that is why a submission failed. A lost device stays lost.
    pub(in crate::gpu) fn note_lost(&self, result: vk::Result) {
        if result == vk::Result::ERROR_DEVICE_LOST {
            self.0.lost.store(true, Ordering::Relaxed);
        }
    }
}

/// A resource's weak reference to its context.
#[derive(Clone)]
pub(in crate::gpu) struct Link(Weak<Shared>);

impl Link {
    /// Returns the context, unless it is gone.
    pub(in crate::gpu) fn context(&self) -> Option<Context> {
        self.0.upgrade().map(Context)
    }
}

/// Returns the queue family of a device that meets the floor, and refuses any other device.
fn above_floor(features: &Features, family: Option<u32>) -> Result<u32> {
    match (&features.below_floor, family) {
        (None, Some(family)) => Ok(family),
        (below, _) => {
            let missing = below.clone().unwrap_or_else(|| "a queue with graphics and compute".into());
            Err(Error::Refused(format!("{missing} (device {})", features.name).into()))
        }
    }
}

impl Shared {
    fn new(open: Open, owner: Option<crate::gpu::device::instance::InstanceOwner>) -> Result<Self> {
        let Open { instance, handle, features, .. } = open;
        let labels = open.labels.then(|| ext::debug_utils::Device::new(instance, &handle));
        let acceleration = features.ray_query.then(|| khr::acceleration_structure::Device::new(instance, &handle));
        let clock =
            crate::gpu::profile::calibration::clock(&open.entry, instance, open.physical_device, &handle, &features);
        let executables = Executables::new(instance, &handle, &features);
        let allocator = match open.allocator {
            Some(theirs) => Memory::Theirs(theirs),
            None => {
                let allocator = Allocator::new(&AllocatorCreateDesc {
                    instance: instance.clone(),
                    device: handle.clone(),
                    physical_device: open.physical_device,
                    // Leaks are reported when the device closes.
                    debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
                    buffer_device_address: features.ray_query,
                    allocation_sizes: gpu_allocator::AllocationSizes::default(),
                });
                Memory::Own(Arc::new(Mutex::new(allocator.map_err(|e| allocation_error("the allocator", &e))?)))
            }
        };
        let device = Device::new(Parts {
            allocator,
            allocated: AtomicU64::new(0),
            pipelines: Pipelines::default(),
            labels,
            acceleration,
            clock,
            executables,
            features,
            messages: open.messages,
            handle,
            _entry: open.entry,
            _instance: owner,
        });
        Ok(Self {
            queue: None,
            tools: Vec::new(),
            pending: Pending::default(),
            frames: Frames::new(open.frames_in_flight),
            device,
            lost: AtomicBool::new(false),
            times_passes: AtomicBool::new(true),
            counts_passes: AtomicBool::new(false),
            queue_family: open.queue_family,
            frames_in_flight: open.frames_in_flight,
            begun: AtomicU64::new(0),
        })
    }
}
