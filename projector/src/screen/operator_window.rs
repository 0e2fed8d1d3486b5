//! The operator's window on its monitor: egui's input and pixels, on the pattern's graphics driver.
//!
//! It is drawn only when something has changed and presents without waiting for a refresh. `window` draws it only
//! when the pattern has stood still for longer than a drawing takes, the GPU's work included ([`OperatorWindow::rest`]),
//! so pictures that follow each other closely, as in a sequence, are never held up by it. The preview is made by a
//! thread of its own.

use std::{
    net::SocketAddr,
    sync::Arc,
    time::{Duration, Instant},
};

use egui_wgpu::ScreenDescriptor;
use shared::{pattern::Raster, protocol::Command};
use wgpu::CurrentSurfaceTexture as Acquired;
use winit::{
    dpi::{LogicalSize, PhysicalPosition, PhysicalSize},
    event::{ElementState, WindowEvent},
    event_loop::ActiveEventLoop,
    monitor::MonitorHandle,
    window::{Window, WindowAttributes, WindowId},
};

use super::{Monitor, ScreenError, gpu::Gpu, keys::command_of};
use crate::{
    operator::{
        self, Action, OperatorView, Panels,
        preview::{Original, PreviewMaker},
    },
    state::Overview,
};

/// Title of the window.
const TITLE: &str = "projector - operator";
/// Names the file that gets a list of what stands in the window.
const WIDGETS: &str = "PROJECTOR_WIDGETS";
/// Size of the window where there is room, in points.
const SIZE: LogicalSize<f64> = LogicalSize::new(1080.0, 720.0);
/// Distance from the monitor's corner, in pixels.
const INSET_PX: i32 = 40;
/// Pause after a frame that could not be presented.
const RETRY: Duration = Duration::from_millis(100);
/// Least time that the pattern stands still before a drawing, and between two drawings.
const SHORTEST_REST: Duration = Duration::from_millis(30);
/// The same where drawing is slow, as with a software driver.
const LONGEST_REST: Duration = Duration::from_millis(500);
/// Longest time the GPU may take for one drawing.
const GPU_TIMEOUT: Duration = Duration::from_secs(2);

/// The open window.
pub(super) struct OperatorWindow {
    window: Arc<Window>,
    gpu: Gpu,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    context: egui::Context,
    input: egui_winit::State,
    renderer: egui_wgpu::Renderer,
    maker: PreviewMaker,
    view: Option<OperatorView>,
    panels: Panels,
    /// When it is to be drawn; `None` while nothing changes.
    due: Option<Instant>,
    drawn_at: Instant,
    /// How long the last drawing took.
    cost: Duration,
}

/// What an event means for the program.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Outcome {
    /// Nothing further.
    Nothing,
    /// The window is to be closed.
    Close,
    /// It is to be drawn now, if the pattern allows.
    Draw,
    /// A key asks for a change.
    Ask(Command),
    /// A key asks for black, or back.
    ToggleBlank,
}

impl OperatorWindow {
    /// Opens the window on a monitor, or where the system likes; `wake` wakes the event loop.
    ///
    /// # Errors
    /// The system refuses the window, or the driver cannot draw into it.
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        gpu: &Gpu,
        monitor: Option<&MonitorHandle>,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, ScreenError> {
        let attributes = WindowAttributes::default().with_title(TITLE);
        let attributes = match monitor {
            Some(monitor) => attributes
                .with_position(corner(monitor))
                .with_inner_size(size_on(monitor)),
            None => attributes.with_inner_size(SIZE),
        };
        let window = Arc::new(event_loop.create_window(attributes)?);
        let surface = gpu.instance.create_surface(window.clone())?;
        let config = configuration(&surface, gpu, &window)?;
        surface.configure(&gpu.device, &config);
        let context = egui::Context::default();
        operator::install_style(&context);
        look::widget_list::start_if_wanted(&context, WIDGETS);
        let input = egui_winit::State::new(
            context.clone(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(gpu.most_px() as usize),
        );
        let options = egui_wgpu::RendererOptions {
            // It would change the colours of the preview and of the swatches.
            dithering: false,
            ..Default::default()
        };
        let renderer = egui_wgpu::Renderer::new(&gpu.device, config.format, options);
        Ok(Self {
            window,
            gpu: gpu.clone(),
            surface,
            config,
            context,
            input,
            renderer,
            maker: PreviewMaker::start(wake).map_err(ScreenError::Thread)?,
            view: None,
            panels: Panels::default(),
            due: Some(Instant::now()),
            drawn_at: Instant::now(),
            cost: Duration::ZERO,
        })
    }

    pub(super) fn id(&self) -> WindowId {
        self.window.id()
    }

    /// When it is to be drawn next, if at all, with a pattern that stands still since a time.
    pub(super) fn due(&self, still_since: Instant) -> Option<Instant> {
        let rested = self.drawn_at.max(still_since) + self.rest();
        self.due.map(|due| due.max(rested))
    }

    /// How long the pattern must stand still before a drawing: twice as long as the last one took.
    fn rest(&self) -> Duration {
        (2 * self.cost).clamp(SHORTEST_REST, LONGEST_REST)
    }

    /// Asks the system to call for a drawing.
    pub(super) fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// Goes to another monitor.
    pub(super) fn move_to(&mut self, monitor: &MonitorHandle) {
        self.window.set_outer_position(corner(monitor));
        // Where the system resizes at once it tells so here, and sends no event.
        if let Some(size) = self.window.request_inner_size(size_on(monitor)) {
            self.resized(size);
        }
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        let most = self.gpu.most_px();
        self.config.width = size.width.clamp(1, most);
        self.config.height = size.height.clamp(1, most);
        self.surface.configure(&self.gpu.device, &self.config);
        self.changed();
    }

    /// Takes what it shows from now on.
    pub(super) fn tell(
        &mut self,
        overview: Overview,
        monitors: Vec<Monitor>,
        listening: Option<SocketAddr>,
    ) {
        let preview = self.view.take().and_then(|view| view.preview);
        self.view = Some(OperatorView {
            overview,
            monitors,
            listening,
            preview,
        });
        self.changed();
    }

    /// Takes a preview that was made, if there is one.
    pub(super) fn take_preview(&mut self) {
        let (Some(raster), Some(view)) = (self.maker.take(), &mut self.view) else {
            return;
        };
        let image = colour_image(&raster);
        // Its pixels are the monitor's pixels: nothing is to be smoothed.
        let texture = self
            .context
            .load_texture("preview", image, egui::TextureOptions::NEAREST);
        view.preview = Some(texture);
        self.changed();
    }

    /// It is to be drawn soon.
    pub(super) fn changed(&mut self) {
        self.wanted_at(Instant::now());
    }

    fn wanted_at(&mut self, time: Instant) {
        self.due = Some(self.due.map_or(time, |due| due.min(time)));
    }

    /// Takes an event of the window system.
    pub(super) fn event(&mut self, event: &WindowEvent) -> Outcome {
        if *event == WindowEvent::RedrawRequested {
            return Outcome::Draw;
        }
        let response = self.input.on_window_event(&self.window, event);
        if response.repaint {
            self.changed();
        }
        match event {
            WindowEvent::Resized(size) => {
                self.resized(*size);
                Outcome::Nothing
            }
            WindowEvent::CloseRequested => Outcome::Close,
            WindowEvent::KeyboardInput { event, .. }
                if !response.consumed && event.state == ElementState::Pressed && !event.repeat =>
            {
                key(&event.logical_key)
            }
            _ => Outcome::Nothing,
        }
    }

    /// Draws the window; gives what the operator asks for.
    pub(super) fn draw(&mut self) -> Vec<Action> {
        let begin = Instant::now();
        self.due = None;
        let Some(view) = &self.view else {
            return Vec::new();
        };
        let input = self.input.take_egui_input(&self.window);
        let mut asked = Vec::new();
        let panels = &mut self.panels;
        let output = self
            .context
            .run_ui(input, |ui| asked.extend(operator::ui(ui, view, panels)));
        let shown = &view.overview.state.shown;
        self.maker.ask(Original {
            pattern: shown.pattern.clone(),
            raster: shown.raster,
            size: self.panels.preview_px(),
        });
        let again = self.present(output);
        let end = Instant::now();
        (self.cost, self.drawn_at) = (end - begin, end);
        if let Some(time) = again.and_then(|delay| end.checked_add(delay)) {
            self.wanted_at(time);
        }
        asked
    }

    /// Brings the drawing to the monitor; gives after which time it is to be drawn again, if nothing changes.
    fn present(&mut self, output: egui::FullOutput) -> Option<Duration> {
        let again = output
            .viewport_output
            .values()
            .map(|view| view.repaint_delay)
            .min();
        self.input
            .handle_platform_output(&self.window, output.platform_output);
        let shapes = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        let screen = ScreenDescriptor {
            size_in_pixels: [self.config.width, self.config.height],
            pixels_per_point: output.pixels_per_point,
        };
        let mut textures = output.textures_delta;
        let Gpu { device, queue, .. } = &self.gpu;
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.renderer.update_texture(device, queue, id, &delta);
            }
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let uploads = self
            .renderer
            .update_buffers(device, queue, &mut encoder, &shapes, &screen);
        let presented = match self.surface.get_current_texture() {
            Acquired::Success(texture) | Acquired::Suboptimal(texture) => {
                self.paint(&texture, &mut encoder, &shapes, &screen);
                queue.submit(uploads.into_iter().chain([encoder.finish()]));
                self.window.pre_present_notify();
                queue.present(texture);
                self.finish();
                true
            }
            other => {
                tracing::debug!("operator's window not drawn: {other:?}");
                self.surface.configure(device, &self.config);
                false
            }
        };
        for id in textures.free.drain() {
            self.renderer.free_texture(&id);
        }
        if presented { again } else { Some(RETRY) }
    }

    /// Waits until the GPU has drawn, so that it is known what a drawing costs. The next picture could not be drawn
    /// earlier anyway: there is one queue.
    fn finish(&self) {
        let wait = wgpu::PollType::Wait {
            submission_index: None,
            timeout: Some(GPU_TIMEOUT),
        };
        if self.gpu.device.poll(wait).is_err() {
            tracing::warn!("the GPU does not finish the operator's window");
        }
    }

    fn paint(
        &self,
        texture: &wgpu::SurfaceTexture,
        encoder: &mut wgpu::CommandEncoder,
        shapes: &[egui::ClippedPrimitive],
        screen: &ScreenDescriptor,
    ) {
        let view = texture
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("operator"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                resolve_target: None,
                depth_slice: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        self.renderer
            .render(&mut pass.forget_lifetime(), shapes, screen);
    }
}

fn key(key: &winit::keyboard::Key) -> Outcome {
    if let winit::keyboard::Key::Character(text) = key
        && text.eq_ignore_ascii_case("b")
    {
        return Outcome::ToggleBlank;
    }
    command_of(key).map_or(Outcome::Nothing, Outcome::Ask)
}

fn colour_image(raster: &Raster) -> egui::ColorImage {
    let size = raster.size();
    egui::ColorImage::from_rgb([size.width as usize, size.height as usize], raster.bytes())
}

fn corner(monitor: &MonitorHandle) -> PhysicalPosition<i32> {
    let PhysicalPosition { x, y } = monitor.position();
    PhysicalPosition::new(x + INSET_PX, y + INSET_PX)
}

/// The usual size, but no larger than the monitor has room for, its bars and the window's title included.
fn size_on(monitor: &MonitorHandle) -> PhysicalSize<u32> {
    let usual = SIZE.to_physical::<u32>(monitor.scale_factor());
    let room = |length: u32| length.saturating_sub(2 * INSET_PX.unsigned_abs()).max(1);
    let size = monitor.size();
    PhysicalSize::new(
        usual.width.min(room(size.width)),
        usual.height.min(room(size.height)),
    )
}

/// Without waiting for a refresh: another window's refreshes are no business of the pattern's.
fn configuration(
    surface: &wgpu::Surface<'static>,
    gpu: &Gpu,
    window: &Window,
) -> Result<wgpu::SurfaceConfiguration, ScreenError> {
    let capabilities = surface.get_capabilities(&gpu.adapter);
    let no_format = || ScreenError::NoExactFormat(format!("{:?}", capabilities.formats));
    let format =
        egui_wgpu::preferred_framebuffer_format(&capabilities.formats).map_err(|_| no_format())?;
    let size = window.inner_size();
    let default = surface.get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1));
    Ok(wgpu::SurfaceConfiguration {
        format,
        present_mode: wgpu::PresentMode::AutoNoVsync,
        ..default.ok_or_else(no_format)?
    })
}
