//! The window's renderer: its own device, frames in flight and swapchain. Gobo records into the window's command buffers, as into those of
//! any engine. All `unsafe` code of the window is in this folder; its public functions are safe to call in any order.

mod device;
mod frames;
mod heap;
mod swapchain;

pub use device::HostMessages;
pub use heap::heap_bytes;

use self::device::Device;
use self::frames::{FRAMES_IN_FLIGHT, Frames};
use self::swapchain::{Swapchain, Turn};
use crate::gpu::{Adopt, Buffer, Commands, Context, Messages};
use crate::{Error, GpuCause, Result};
use ash::vk;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError, allocator::GpuAllocator};
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::window::Window;

/// Builds an error about the window itself.
fn error(operation: &'static str, name: &str, cause: impl Into<GpuCause>) -> Error {
    let way_out = "run `gobo devices`, update the driver, or choose another device with --device".into();
    Error::Gpu { operation, name: name.into(), cause: cause.into(), way_out }
}

/// Builds an error from a Vulkan result.
fn failed(operation: &'static str, name: &'static str) -> impl Fn(vk::Result) -> Error {
    move |result| error(operation, name, GpuCause::Vulkan(result))
}

/// Converts an error of egui's renderer to its cause.
fn cause_of(error: RendererError) -> GpuCause {
    match error {
        RendererError::Vulkan(result) => GpuCause::Vulkan(result),
        other => other.to_string().into(),
    }
}

/// egui's meshes to draw, shared by all frames that draw the same panel.
#[derive(Clone)]
pub struct Ui {
    pub textures: egui::TexturesDelta,
    pub primitives: Rc<[egui::ClippedPrimitive]>,
    pub pixels_per_point: f32,
}

/// A frame being recorded.
pub struct Frame {
    pub number: u64,
    commands: vk::CommandBuffer,
    /// Index of the window's image; `None` if the window has no area.
    image: Option<usize>,
}

/// Fields drop in this order: everything created from the device comes before the device.
pub struct Host {
    context: Context,
    ui: Option<Renderer<GpuAllocator>>,
    ui_format: vk::Format,
    frames: Frames,
    swapchain: Option<Swapchain>,
    /// Size of the window, in pixels.
    size: [u32; 2],
    is_stale: bool,
    /// Buffer that each frame in flight copies its picture from.
    copied: [Option<Buffer>; FRAMES_IN_FLIGHT as usize],
    /// Number of the next frame to record.
    next: u64,
    device: Device,
}

impl Host {
    /// Opens a device for the window, and Gobo on it.
    ///
    /// # Errors
    /// [`Error::Gpu`] and [`Error::Input`] if there is no such device, [`Error::Refused`] if the device is below the floor.
    pub fn open(
        window: &Arc<Window>,
        wanted: Option<&str>,
        validation: bool,
        said: &HostMessages,
        messages: &Messages,
    ) -> Result<Self> {
        let device = Device::open(window, wanted, validation, said)?;
        let (entry, instance) = device.origin();
        let adopt = Adopt {
            entry,
            instance,
            physical_device: device.physical,
            device: device.handle.clone(),
            queue_family: device.queue_family,
            enabled: device.enabled,
            allocator: device.allocator(),
            frames_in_flight: FRAMES_IN_FLIGHT,
            messages: messages.clone(),
        };
        // SAFETY: all of these belong together, and the device was opened with `enabled`. The device is destroyed last: `Open` drops its
        // stage before `Host`, and `device` is the last field of `Host`.
        let context = unsafe { Context::adopt(adopt) }?;
        let frames = Frames::new(&device)?;
        let size = window.inner_size().into();
        let swapchain = Swapchain::new(&device, size, None)?;
        let ui_format = swapchain.as_ref().map_or(vk::Format::B8G8R8A8_UNORM, |chain| chain.format);
        let copied = Default::default();
        let mut host =
            Self { context, ui: None, ui_format, frames, swapchain, size, is_stale: false, copied, next: 0, device };
        host.ui = Some(host.panel()?);
        Ok(host)
    }

    /// Creates the renderer that draws the panel.
    fn panel(&self) -> Result<Renderer<GpuAllocator>> {
        let allocator =
            self.device.allocator().ok_or_else(|| error("make", "the panel", "the device is being closed"))?;
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: self.ui_format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options = Options { in_flight_frames: FRAMES_IN_FLIGHT as usize, ..Options::default() };
        Renderer::with_gpu_allocator(allocator, self.device.handle.clone(), mode, options)
            .map_err(|cause| error("make", "the panel", cause_of(cause)))
    }

    /// Returns Gobo's context on the window's device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Returns the number of frames that may run at the same time.
    pub fn frames_in_flight(&self) -> u64 {
        FRAMES_IN_FLIGHT.into()
    }

    /// Returns the number of device bytes allocated.
    pub fn allocated_bytes(&self) -> u64 {
        self.device.allocated_bytes()
    }

    /// Whether blue is the first byte of a pixel.
    pub fn is_blue_first(&self) -> bool {
        self.ui_format == vk::Format::B8G8R8A8_UNORM
    }

    /// Sets the size of the window from now on; 0 × 0 if the window is minimized.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.is_stale |= size != self.size;
        self.size = size;
    }

    /// Begins the next frame, after waiting for the frame `frames_in_flight` before it.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost.
    pub fn begin(&mut self) -> Result<Frame> {
        let number = self.next;
        self.frames.wait(number)?;
        let mut image = None;
        // Tries twice: while the window is being dragged, images of the new size may be out of date too.
        for _ in 0..2 {
            if self.is_stale {
                self.remake()?;
            }
            let Some(chain) = &self.swapchain else { break };
            match chain.acquire(self.frames.acquired(number))? {
                Turn::Done(index) => {
                    image = Some(index);
                    break;
                }
                Turn::Stale => self.is_stale = true,
            }
        }
        let commands = self.frames.begin(number)?;
        Ok(Frame { number, commands, image })
    }

    /// Returns the size of the window's images, in pixels; 0 × 0 if the window has no area.
    pub fn window_size(&self) -> [u32; 2] {
        self.swapchain.as_ref().map_or([0; 2], |chain| chain.size)
    }

    /// Returns the number of bytes of the window's pixels; 0 if they cannot be read.
    pub fn window_bytes(&self) -> u64 {
        let chain = self.swapchain.as_ref().filter(|chain| chain.is_readable);
        chain.map_or(0, |chain| 4 * u64::from(chain.size[0]) * u64::from(chain.size[1]))
    }

    /// Waits until the device is done with all frames.
    pub fn wait(&self) {
        self.device.wait();
    }

    fn remake(&mut self) -> Result<()> {
        self.device.wait();
        let old = self.swapchain.take();
        self.is_stale = false;
        if !self.size.contains(&0) {
            self.swapchain = Swapchain::new(&self.device, self.size, old)?;
        }
        Ok(())
    }

    /// Lets `record` record passes into the frame.
    ///
    /// # Errors
    /// Errors of [`Commands::on`] and of `record`.
    pub fn record<T>(&self, frame: &Frame, record: impl FnOnce(&mut Commands) -> Result<T>) -> Result<T> {
        // SAFETY: the command buffer belongs to the frame, is being recorded outside rendering, and is submitted once, in order; `begin`
        // waited for the frame `FRAMES_IN_FLIGHT` before.
        let mut commands = unsafe { Commands::on(&self.context, frame.commands, frame.number) }?;
        record(&mut commands)
    }

    /// Ends and submits the frame: `picture`, of `size` pixels with four bytes each, goes to the upper left of the window, and the panel is
    /// drawn over it. The whole window is copied to `film`, which the host may read after [`Host::wait`]. Returns how long presenting took,
    /// which may include a wait for the device.
    ///
    /// # Errors
    /// [`Error::Gpu`] if the device is lost.
    pub fn end(
        &mut self,
        frame: Frame,
        picture: Option<(&Buffer, [u32; 2])>,
        mut ui: Ui,
        film: Option<&Buffer>,
    ) -> Result<Duration> {
        self.textures(&mut ui)?;
        self.copied[(frame.number % u64::from(FRAMES_IN_FLIGHT)) as usize] = picture.map(|(buffer, _)| buffer.clone());
        if let (Some(image), Some(chain)) = (frame.image, &self.swapchain) {
            self.frames.copy(frame.commands, chain, image, picture);
            let extent = vk::Extent2D { width: chain.size[0], height: chain.size[1] };
            let panel = &mut self.ui;
            self.frames.over(frame.commands, chain, image, film, |commands| match panel {
                Some(panel) => panel
                    .cmd_draw(commands, extent, ui.pixels_per_point, &ui.primitives)
                    .map_err(|cause| error("draw", "the panel", cause_of(cause))),
                None => Ok(()),
            })?;
        }
        let shown = self.swapchain.as_ref().zip(frame.image);
        self.frames.submit(self.device.queue, frame.number, shown.map(|(chain, image)| chain.drawn[image]))?;
        self.next += 1;
        let handed_over = Instant::now();
        if let Some((chain, image)) = shown
            && let Turn::Stale = chain.present(self.device.queue, image)?
        {
            self.is_stale = true;
        }
        let handed_over = handed_over.elapsed();
        if !ui.textures.free.is_empty() {
            self.device.wait();
            for id in ui.textures.free.drain() {
                self.ui
                    .as_mut()
                    .map_or(Ok(()), |panel| panel.free_texture(id))
                    .map_err(|cause| error("free", "text", cause_of(cause)))?;
            }
        }
        Ok(handed_over)
    }

    /// Uploads textures of text not shown before. This waits for the device, but is rarely needed.
    fn textures(&mut self, ui: &mut Ui) -> Result<()> {
        let (Some(panel), false) = (&mut self.ui, ui.textures.set.is_empty()) else { return Ok(()) };
        // Waits for earlier frames, which may draw from textures that are replaced now.
        self.device.wait();
        for (id, deltas) in ui.textures.set.drain() {
            for delta in deltas {
                let copied = panel.set_texture(self.device.queue, self.frames.pool(), id, &delta);
                copied.map_err(|cause| error("copy", "text", cause_of(cause)))?;
            }
        }
        Ok(())
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.device.wait();
        // Both free memory into the allocator, so they are dropped before it.
        (self.ui, self.copied) = (None, Default::default());
    }
}
