//! The window's pixels: the GPU device, the swap chain, and the painter that fills it.
//!
//! Takes a window, gives presented frames. The format is 8 bits without sRGB conversion, so that a byte of
//! the pattern is a byte on the cable; presentation is paced by the refresh (Fifo) with the shortest queue.

use std::{sync::Arc, time::Duration};

use shared::pattern::{Pattern, RasterSize};
use wgpu::CurrentSurfaceTexture as Acquired;
use winit::{event_loop::ActiveEventLoop, window::Window};

use super::{PainterError, ScreenError, gpu::Gpu, painter::Painter};

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
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    painter: Painter,
}

impl Canvas {
    /// Prepares a window for drawing, with the driver that is open already or with one opened for it.
    ///
    /// # Errors
    /// No driver that can draw into it, or none with an exact format.
    pub(super) fn new(
        event_loop: &ActiveEventLoop,
        window: Arc<Window>,
        open: Option<&Gpu>,
    ) -> Result<Self, ScreenError> {
        let (gpu, surface) = match open {
            Some(gpu) => (gpu.clone(), gpu.instance.create_surface(window.clone())?),
            None => Gpu::open(event_loop, &window)?,
        };
        let config = configuration(&surface, &gpu.adapter, &window)?;
        surface.configure(&gpu.device, &config);
        let painter = Painter::new(gpu.device.clone(), gpu.queue.clone(), config.format);
        Ok(Self {
            window,
            gpu,
            surface,
            config,
            painter,
        })
    }

    /// The driver it is drawn with.
    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
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
        let most = self.gpu.most_px();
        let (width, height) = (size.width.clamp(1, most), size.height.clamp(1, most));
        let changed = (width, height) != (self.config.width, self.config.height);
        if changed {
            (self.config.width, self.config.height) = (width, height);
            self.surface.configure(&self.gpu.device, &self.config);
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
                self.surface.configure(&self.gpu.device, &self.config);
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
        self.gpu.queue.present(texture);
        Frame::Presented
    }

    /// Waits until the GPU has drawn everything handed to it; whether it did in time.
    pub(super) fn finish(&self) -> bool {
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(GPU_TIMEOUT),
        };
        self.gpu.device.poll(wait).is_ok()
    }

    fn renew_surface(&mut self) -> Frame {
        match self.gpu.instance.create_surface(self.window.clone()) {
            Ok(surface) => {
                self.surface = surface;
                self.surface.configure(&self.gpu.device, &self.config);
                Frame::NotNow("the connection to the window was renewed")
            }
            Err(error) => {
                tracing::error!("the window is lost: {error}");
                Frame::NotNow("the window is lost")
            }
        }
    }
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
