//! The graphics driver: one instance, one device, one queue for both windows.

use std::sync::Arc;

use winit::{event_loop::ActiveEventLoop, window::Window};

use super::ScreenError;

/// The open driver. Copies are the same driver.
#[derive(Debug, Clone)]
pub(super) struct Gpu {
    pub(super) instance: wgpu::Instance,
    pub(super) adapter: wgpu::Adapter,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
}

impl Gpu {
    /// Opens a driver that can draw into this window, and prepares the window for it.
    ///
    /// # Errors
    /// There is none, or it does not start.
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        window: &Arc<Window>,
    ) -> Result<(Self, wgpu::Surface<'static>), ScreenError> {
        let (instance, surface, adapter) = open_adapter(event_loop, window)?;
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
        let gpu = Self {
            instance,
            adapter,
            device,
            queue,
        };
        Ok((gpu, surface))
    }

    /// Largest side of a picture, in pixels.
    pub(super) fn most_px(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
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
