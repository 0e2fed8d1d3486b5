//! The window's pixels: the GPU device, the swap chain, and the painter that fills it.
//!
//! Takes a window, gives presented frames. The format is 8 bits without sRGB conversion, so that a byte of
//! the pattern is a byte on the cable; presentation is paced by the refresh (Fifo) with the shortest queue.

use std::{sync::Arc, time::Duration};

use shared::pattern::{Pattern, RasterSize};
use wgpu::CurrentSurfaceTexture as Acquired;
use winit::{event_loop::ActiveEventLoop, window::Window};

use super::{PainterError, ScreenError, painter::Painter};

/// Longest time the GPU may take for one frame before it counts as stuck.
const GPU_TIMEOUT: Duration = Duration::from_secs(2);

/// What became of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Frame {
    /// It is in the queue to the screen.
    Presented,
    /// It is not; try again later, for this reason.
    NotNow(&'static str),
}

/// A window that can be drawn into.
pub(super) struct Canvas {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    device: wgpu::Device,
    queue: wgpu::Queue,
    painter: Painter,
}

impl Canvas {
    /// Prepares a window for drawing.
    ///
    /// # Errors
    /// No driver that can draw into it, or none with an exact format.
    pub(super) fn new(
        event_loop: &ActiveEventLoop,
        window: Arc<Window>,
    ) -> Result<Self, ScreenError> {
        let (instance, surface, adapter) = open_adapter(event_loop, &window)?;
        let info = adapter.get_info();
        tracing::info!(
            "drawing with {} ({}, {})",
            info.name,
            info.backend,
            info.driver_info
        );
        let limits = wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits());
        let descriptor = wgpu::DeviceDescriptor {
            required_limits: limits,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
        // The default is to panic; a lost GPU must not take the TCP side with it.
        device.on_uncaptured_error(Arc::new(|error| {
            tracing::error!("graphics driver: {error}");
        }));
        let config = configuration(&surface, &adapter, &window)?;
        surface.configure(&device, &config);
        let painter = Painter::new(device.clone(), queue.clone(), config.format);
        Ok(Self {
            window,
            instance,
            surface,
            config,
            device,
            queue,
            painter,
        })
    }

    /// Size of what is drawn.
    pub(super) fn raster(&self) -> RasterSize {
        RasterSize {
            width: self.config.width,
            height: self.config.height,
        }
    }

    /// Follows the window's size; whether it changed.
    pub(super) fn follow_window(&mut self) -> bool {
        let size = self.window.inner_size();
        let most = self.device.limits().max_texture_dimension_2d;
        let (width, height) = (size.width.clamp(1, most), size.height.clamp(1, most));
        let changed = (width, height) != (self.config.width, self.config.height);
        if changed {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.device, &self.config);
        }
        changed
    }

    /// Loads the pattern for the next frames.
    ///
    /// # Errors
    /// The GPU cannot hold it.
    pub(super) fn load(&mut self, pattern: &Pattern) -> Result<(), PainterError> {
        let raster = self.raster();
        self.painter.load(pattern, raster)
    }

    /// Draws the loaded pattern and hands it to the screen.
    pub(super) fn draw(&mut self) -> Frame {
        let texture = match self.surface.get_current_texture() {
            // "Suboptimal" still shows what was drawn; the window's size is followed on its own event.
            Acquired::Success(texture) | Acquired::Suboptimal(texture) => texture,
            Acquired::Timeout => return Frame::NotNow("the screen does not take pictures"),
            Acquired::Occluded => return Frame::NotNow("the window is covered or minimised"),
            Acquired::Outdated => {
                self.surface.configure(&self.device, &self.config);
                return Frame::NotNow("the window is changing");
            }
            Acquired::Lost => return self.renew_surface(),
            Acquired::Validation => return Frame::NotNow("the graphics driver reports an error"),
        };
        self.painter.paint(
            &texture
                .texture
                .create_view(&wgpu::TextureViewDescriptor::default()),
        );
        self.window.pre_present_notify();
        self.queue.present(texture);
        Frame::Presented
    }

    /// Waits until the GPU has drawn everything handed to it; whether it did in time.
    pub(super) fn finish(&self) -> bool {
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(GPU_TIMEOUT),
        };
        self.device.poll(wait).is_ok()
    }

    fn renew_surface(&mut self) -> Frame {
        match self.instance.create_surface(self.window.clone()) {
            Ok(surface) => {
                self.surface = surface;
                self.surface.configure(&self.device, &self.config);
                Frame::NotNow("the connection to the window was renewed")
            }
            Err(error) => {
                tracing::error!("the window is lost: {error}");
                Frame::NotNow("the window is lost")
            }
        }
    }
}

type Opened = (wgpu::Instance, wgpu::Surface<'static>, wgpu::Adapter);

/// Vulkan first: it is the driver whose pixels and pacing were checked; any other if there is none.
fn open_adapter(event_loop: &ActiveEventLoop, window: &Arc<Window>) -> Result<Opened, ScreenError> {
    let open = |backends| -> Result<Opened, ScreenError> {
        let display = Box::new(event_loop.owned_display_handle());
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_with_display_handle(display)
        });
        let surface = instance.create_surface(window.clone())?;
        let options = wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        Ok((instance, surface, adapter))
    };
    if let Some(backends) = wgpu::Backends::from_env() {
        return open(backends);
    }
    open(wgpu::Backends::VULKAN).or_else(|error| {
        tracing::warn!("Vulkan cannot be used, trying other graphics drivers: {error}");
        open(wgpu::Backends::all())
    })
}

fn configuration(
    surface: &wgpu::Surface<'static>,
    adapter: &wgpu::Adapter,
    window: &Window,
) -> Result<wgpu::SurfaceConfiguration, ScreenError> {
    let capabilities = surface.get_capabilities(adapter);
    let exact = [
        wgpu::TextureFormat::Bgra8Unorm,
        wgpu::TextureFormat::Rgba8Unorm,
    ];
    let format = exact
        .into_iter()
        .find(|format| capabilities.formats.contains(format));
    let no_format = || ScreenError::NoExactFormat(format!("{:?}", capabilities.formats));
    let format = format.ok_or_else(no_format)?;
    let size = window.inner_size();
    let default = surface.get_default_config(adapter, size.width.max(1), size.height.max(1));
    Ok(wgpu::SurfaceConfiguration {
        format,
        present_mode: wgpu::PresentMode::Fifo,
        desired_maximum_frame_latency: 1,
        ..default.ok_or_else(no_format)?
    })
}
