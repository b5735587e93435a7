//! Pictures without a window: textures that are drawn into and read back.

use std::sync::mpsc;

use super::device::Gpu;
use crate::{Error, Result};

/// A picture in the making. Its rows run downwards.
#[derive(Debug, Clone)]
pub struct Target {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl Target {
    /// A picture of this many columns and rows.
    ///
    /// # Errors
    /// It is larger than the adapter's textures, or the adapter does not draw into this format.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> Result<Self> {
        let most = gpu.most_texels_along();
        if width == 0 || height == 0 || width > most || height > most {
            return Err(Error::input(format!(
                "the picture has {width} × {height} pixels; give 1 to {most} columns and rows, which is what {gpu} has"
            )));
        }
        let texture = gpu.checked("the picture", || {
            gpu.device().create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        })?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { texture, view })
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// One pass over the picture, which is black before it.
    ///
    /// # Errors
    /// What the driver says against what was recorded.
    pub fn draw(&self, gpu: &Gpu, record: impl FnOnce(&mut wgpu::RenderPass<'_>)) -> Result<()> {
        gpu.checked("a pass", || {
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let attachment = wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
            };
            record(&mut encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            }));
            gpu.queue().submit([encoder.finish()]);
        })
    }

    /// The picture's bytes, row by row without gaps. Waits for all that was drawn.
    ///
    /// # Errors
    /// The adapter was lost, or has too little memory.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>> {
        read_texture(gpu, &self.texture)
    }
}

/// A texture's bytes, row by row without gaps. Waits for all that was drawn.
///
/// # Errors
/// The adapter was lost, or has too little memory.
pub(super) fn read_texture(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>> {
    let [width, height] = [texture.width(), texture.height()];
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let row = width * texel;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.checked("the picture's copy", || {
        let buffer = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture's copy"),
            size: u64::from(padded) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None };
        let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
        gpu.queue().submit([encoder.finish()]);
        buffer
    })?;
    let (sender, receiver) = mpsc::channel();
    // Nobody listens any more only where this function has failed already.
    buffer.map_async(wgpu::MapMode::Read, .., move |mapped| drop(sender.send(mapped)));
    let lost = |what: String| Error::machine(format!("the picture cannot be read from {gpu}: {what}"));
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).map_err(|error| lost(error.to_string()))?;
    receiver.recv().map_err(|error| lost(error.to_string()))?.map_err(|error| lost(error.to_string()))?;
    let bytes = buffer.get_mapped_range(..).map_err(|error| lost(error.to_string()))?;
    Ok(bytes.chunks_exact(padded as usize).flat_map(|line| line[..row as usize].to_vec()).collect())
}
