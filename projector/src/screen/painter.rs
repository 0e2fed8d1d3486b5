//! Draws patterns on the GPU, byte for byte as `Pattern::raster` defines them.
//!
//! Takes a pattern and a raster size, gives a target texture of an 8-bit format without sRGB conversion.
//! Lines are composed by the shader from two 1-D profiles, so a grid costs a few kilobytes of upload
//! whatever the raster's size; the ramp and the cards come as a texture of the whole raster. It
//! fails quietly only where the target's format converts: with an sRGB format every value but 0 and 255
//! would come out brighter, which is why the window asks for a format without.

use bytemuck::{Pod, Zeroable};
use shared::pattern::{Axis, Pattern, RasterSize, Rgb};
use thiserror::Error;

/// Why there is nothing to draw with.
#[derive(Debug, Error)]
pub enum PainterError {
    /// The GPU cannot hold a picture of this size.
    #[error("the picture is {0}, the graphics driver's limit is {1} pixels a side")]
    TooLarge(RasterSize, u32),
}

/// The uniform block of the shader; 16-byte aligned as WGSL wants it.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct PictureUniform {
    field: [f32; 4],
    lines: u32,
    padding: [u32; 3],
}

/// The pipeline and the pattern that is loaded.
#[derive(Debug)]
pub(super) struct Painter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
    loaded: Option<wgpu::BindGroup>,
}

/// What the shader needs for one pattern.
struct Content {
    field: Rgb,
    columns: Vec<[u8; 4]>,
    rows: Vec<[u8; 4]>,
    texels: Option<Vec<[u8; 4]>>,
}

impl Content {
    fn of(pattern: &Pattern, size: RasterSize) -> Self {
        let nothing = vec![[0; 4]];
        let lines = |columns, rows, field| Self {
            field,
            columns,
            rows,
            texels: None,
        };
        match pattern {
            Pattern::Solid { colour } => lines(nothing.clone(), nothing, *colour),
            Pattern::Grid(grid) => {
                let profile = |axis| grid.profile(axis, size).into_iter().map(texel).collect();
                lines(profile(Axis::Column), profile(Axis::Row), Rgb::BLACK)
            }
            Pattern::Ramp
            | Pattern::TestCard
            | Pattern::Identify { .. }
            | Pattern::PairingCode { .. } => {
                let raster = pattern.raster(size);
                let texels = raster
                    .bytes()
                    .chunks_exact(3)
                    .map(|c| [c[0], c[1], c[2], 255]);
                let texels = Some(texels.collect());
                Self {
                    field: Rgb::BLACK,
                    columns: nothing.clone(),
                    rows: nothing,
                    texels,
                }
            }
        }
    }
}

fn texel(line: Option<Rgb>) -> [u8; 4] {
    line.map_or([0; 4], |Rgb([red, green, blue])| [red, green, blue, 255])
}

impl Painter {
    /// A painter for targets of this format, with nothing loaded: it paints black.
    pub(super) fn new(
        device: wgpu::Device,
        queue: wgpu::Queue,
        format: wgpu::TextureFormat,
    ) -> Self {
        let shader = device.create_shader_module(wgpu::include_wgsl!("pattern.wgsl"));
        let target = wgpu::ColorTargetState {
            format,
            blend: None,
            write_mask: wgpu::ColorWrites::ALL,
        };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("pattern"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("whole_target"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("colour"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(target)],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        Self {
            device,
            queue,
            pipeline,
            loaded: None,
        }
    }

    /// Loads the pattern that the next calls of [`Self::paint`] draw.
    ///
    /// # Errors
    /// The raster is larger than the GPU's textures; the last pattern stays loaded.
    pub(super) fn load(&mut self, pattern: &Pattern, size: RasterSize) -> Result<(), PainterError> {
        let most = self.device.limits().max_texture_dimension_2d;
        if size.width.max(size.height) > most {
            return Err(PainterError::TooLarge(size, most));
        }
        let content = Content::of(pattern, size);
        let columns = self.texture(&content.columns, line_of(&content.columns));
        let rows = self.texture(&content.rows, line_of(&content.rows));
        let texels = match &content.texels {
            Some(texels) => self.texture(texels, size),
            None => self.texture(
                &[[0; 4]],
                RasterSize {
                    width: 1,
                    height: 1,
                },
            ),
        };
        let [red, green, blue] = content.field.0.map(|byte| f32::from(byte) / 255.0);
        let lines = u32::from(content.texels.is_none());
        let uniform = PictureUniform {
            field: [red, green, blue, 1.0],
            lines,
            padding: [0; 3],
        };
        self.loaded = Some(self.bind(&uniform, [&columns, &rows, &texels]));
        Ok(())
    }

    /// Draws the loaded pattern over the whole target.
    pub(super) fn paint(&self, target: &wgpu::TextureView) {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("pattern"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    resolve_target: None,
                    depth_slice: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..Default::default()
            });
            if let Some(loaded) = &self.loaded {
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, loaded, &[]);
                pass.draw(0..3, 0..1);
            }
        }
        self.queue.submit([encoder.finish()]);
    }

    fn texture(&self, texels: &[[u8; 4]], size: RasterSize) -> wgpu::TextureView {
        let extent = wgpu::Extent3d {
            width: size.width,
            height: size.height,
            depth_or_array_layers: 1,
        };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("pattern"),
            size: extent,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * size.width),
            rows_per_image: None,
        };
        self.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(texels),
            layout,
            extent,
        );
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    fn bind(&self, uniform: &PictureUniform, views: [&wgpu::TextureView; 3]) -> wgpu::BindGroup {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture"),
            size: size_of::<PictureUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue
            .write_buffer(&buffer, 0, bytemuck::bytes_of(uniform));
        let texture = |binding, view| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        };
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: buffer.as_entire_binding(),
                },
                texture(1, views[0]),
                texture(2, views[1]),
                texture(3, views[2]),
            ],
        })
    }
}

fn line_of(texels: &[[u8; 4]]) -> RasterSize {
    RasterSize {
        width: texels.len() as u32,
        height: 1,
    }
}
