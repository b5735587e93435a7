//! A graphics adapter, chosen among those that the system has, and what is made with it.

use std::fmt;

use crate::{Error, Result};

/// What adapters are spoken to through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Api {
    /// Vulkan.
    Vulkan,
    /// OpenGL, or OpenGL ES.
    OpenGl,
}

impl Api {
    fn backends(self) -> wgpu::Backends {
        match self {
            Self::Vulkan => wgpu::Backends::VULKAN,
            Self::OpenGl => wgpu::Backends::GL,
        }
    }
}

/// An adapter with its queue.
#[derive(Debug, Clone)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
}

/// Name and driver of the adapter, as in `llvmpipe (LLVM 15.0.6, 256 bits), Vulkan`.
impl fmt::Display for Gpu {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let api = match self.info.backend {
            wgpu::Backend::Vulkan => "Vulkan",
            wgpu::Backend::Gl => "OpenGL",
            wgpu::Backend::BrowserWebGpu => "WebGPU",
            _ => "another interface",
        };
        write!(f, "{}, {api}", self.info.name)
    }
}

impl Gpu {
    /// The system's best adapter, one in software where there is no other; no window is needed.
    ///
    /// # Errors
    /// There is none (of this interface): one sentence that says what to install.
    pub fn new(api: Option<Api>) -> Result<Self> {
        pollster::block_on(Self::open(api))
    }

    async fn open(api: Option<Api>) -> Result<Self> {
        let backends = api.map_or(wgpu::Backends::all(), Api::backends);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let mut adapters = instance.enumerate_adapters(backends).await;
        adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
        let mut refusals = String::new();
        for adapter in adapters {
            match Self::of_adapter(&adapter).await {
                Ok(gpu) => return Ok(gpu),
                Err(error) => refusals = format!(" ({}: {error})", adapter.get_info().name),
            }
        }
        let which = match api {
            None => "",
            Some(Api::Vulkan) => " that speaks Vulkan",
            Some(Api::OpenGl) => " that speaks OpenGL",
        };
        Err(Error::input(format!(
            "no graphics adapter{which} was found{refusals}; install the driver of the graphics card, or one in software (mesa-vulkan-drivers on Debian and Ubuntu)"
        )))
    }

    /// Browsers' limits, but textures as large as the adapter has them.
    async fn of_adapter(adapter: &wgpu::Adapter) -> Result<Self, wgpu::RequestDeviceError> {
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("barbule"),
            required_limits: wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = adapter.request_device(&descriptor).await?;
        Ok(Self { device, queue, info: adapter.get_info() })
    }

    /// A device that somebody else opened, as a window's or a browser's.
    #[must_use]
    pub fn of(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        Self { device, queue, info }
    }

    /// What resources are made with.
    #[must_use]
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// What work is handed to.
    #[must_use]
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Whether the adapter is the processor.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Rows and columns of textures at most.
    #[must_use]
    pub fn most_texels_along(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// Waits until all that was handed to the adapter is done.
    ///
    /// # Errors
    /// The adapter was lost.
    pub fn wait(&self) -> Result<()> {
        let done = self.device.poll(wgpu::PollType::wait_indefinitely());
        done.map(|_| ()).map_err(|error| Error::machine(format!("{self} does not answer: {error}")))
    }

    /// Makes resources, with a sentence where the driver refuses them. Browsers tell of that later, on their console.
    ///
    /// # Errors
    /// What the driver says, after `what` was to be made.
    pub fn checked<T>(&self, what: &str, make: impl FnOnce() -> T) -> Result<T> {
        if cfg!(target_arch = "wasm32") {
            return Ok(make());
        }
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let made = make();
        let refused = pollster::block_on(scope.pop());
        let full = pollster::block_on(memory.pop());
        match refused.or(full) {
            None => Ok(made),
            Some(error) => Err(Error::machine(format!("{what}: {self} refuses it: {error}"))),
        }
    }

    /// A bind group's layout, of its entries in order; all are of fragment shaders alone.
    #[must_use]
    pub(super) fn layout(&self, label: &str, entries: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        self.layout_for(label, wgpu::ShaderStages::FRAGMENT, entries)
    }

    /// The same of the stages that read it.
    #[must_use]
    pub(super) fn layout_for(
        &self,
        label: &str,
        visibility: wgpu::ShaderStages,
        entries: &[wgpu::BindingType],
    ) -> wgpu::BindGroupLayout {
        let entries: Vec<_> = (0..)
            .zip(entries)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty: *ty, count: None })
            .collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
    }

    /// A bind group, of what is bound in order.
    #[must_use]
    pub(super) fn bound(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout,
            entries: &entries,
        })
    }

    /// A uniform buffer with these bytes.
    #[must_use]
    pub(super) fn uniform(&self, label: &str, bytes: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// A texture of one level with these texels, row by row; the last row may be shorter.
    #[must_use]
    pub(super) fn texture<T: bytemuck::Pod>(
        &self,
        label: &str,
        format: wgpu::TextureFormat,
        width: u32,
        texels: &[T],
    ) -> wgpu::TextureView {
        let rows = texels.len().div_ceil(width as usize).max(1);
        let mut padded = texels.to_vec();
        padded.resize(rows * width as usize, T::zeroed());
        let size = wgpu::Extent3d { width, height: rows as u32, depth_or_array_layers: 1 };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * size_of::<T>() as u32),
            rows_per_image: None,
        };
        self.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&padded), layout, size);
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}

/// A texture that shaders read texel by texel.
pub(super) fn texture_type(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    }
}

/// The texture's numbers are not filtered.
pub(super) const NUMBERS: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: false };

/// A uniform buffer's.
pub(super) const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

/// The smaller, the better.
fn rank(info: &wgpu::AdapterInfo) -> (u8, u8) {
    let kind = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    (kind, u8::from(info.backend != wgpu::Backend::Vulkan))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(device_type: wgpu::DeviceType, backend: wgpu::Backend) -> wgpu::AdapterInfo {
        wgpu::AdapterInfo::new(device_type, backend)
    }

    #[test]
    fn cards_come_before_processors_and_vulkan_before_opengl() {
        use wgpu::{Backend, DeviceType};
        let in_order = [
            info(DeviceType::DiscreteGpu, Backend::Vulkan),
            info(DeviceType::DiscreteGpu, Backend::Gl),
            info(DeviceType::IntegratedGpu, Backend::Vulkan),
            info(DeviceType::Other, Backend::Gl),
            info(DeviceType::Cpu, Backend::Vulkan),
            info(DeviceType::Cpu, Backend::Gl),
        ];
        assert!(in_order.windows(2).all(|pair| rank(&pair[0]) < rank(&pair[1])));
    }
}
