//! The graphics device: opening it, its errors, its buffers.

pub mod layout;
pub mod readback;
pub mod shaders;
pub mod timing;

use std::sync::{Arc, Mutex};

/// Why nothing could be drawn on a graphics device.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter, not even one in software.
    #[error("no graphics adapter was found ({reason})")]
    NoAdapter {
        /// What the library said.
        reason: String,
    },
    /// The adapter gave no device with WebGPU's default limits.
    #[error("graphics adapter '{adapter}' gave no device: {reason}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What the library said.
        reason: String,
    },
    /// A command failed: out of memory, or a fault in a pass.
    #[error("graphics device: {reason}")]
    Device {
        /// What the library said.
        reason: String,
    },
}

/// A graphics device.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// Device, with WebGPU's default limits.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    fault: Arc<Mutex<Option<String>>>,
}

/// What every device of ours is asked for, in the window and off-screen: default limits, timestamps where they exist.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("sheen"),
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..wgpu::DeviceDescriptor::default()
    }
}

impl Gpu {
    /// Opens the fastest adapter, software ones included, without any display.
    pub fn headless() -> Result<Self, GpuError> {
        pollster::block_on(Self::open())
    }

    async fn open() -> Result<Self, GpuError> {
        let descriptor = wgpu::InstanceDescriptor {
            // Compute passes are needed: no OpenGL.
            backends: wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY),
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        };
        let instance = wgpu::Instance::new(descriptor);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            force_fallback_adapter: false,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter =
            instance
                .request_adapter(&options)
                .await
                .map_err(|error| GpuError::NoAdapter {
                    reason: relevant(&error.to_string()),
                })?;
        let (device, queue) = adapter
            .request_device(&device_descriptor(&adapter))
            .await
            .map_err(|error| GpuError::NoDevice {
                adapter: adapter.get_info().name,
                reason: one_line(&error.to_string()),
            })?;
        Ok(Self::from_device(device, queue, adapter.get_info()))
    }

    /// Takes over a device that a window opened.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let fault = Arc::new(Mutex::new(None));
        let sink = Arc::clone(&fault);
        // Without a handler a fault would end the process.
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if let Ok(mut slot) = sink.lock() {
                slot.get_or_insert_with(|| one_line(&error.to_string()));
            }
        }));
        Self {
            device,
            queue,
            info,
            fault,
        }
    }

    /// The first fault since the last call, if any.
    pub fn check(&self) -> Result<(), GpuError> {
        match self.fault.lock().ok().and_then(|mut slot| slot.take()) {
            Some(reason) => Err(GpuError::Device { reason }),
            None => Ok(()),
        }
    }

    /// True when the adapter is a program on the processor.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// A buffer that holds `data`; never empty, so that it can always be bound.
    pub fn buffer<T: bytemuck::Pod>(
        &self,
        label: &str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        use wgpu::util::DeviceExt;
        let zeros = vec![0u8; std::mem::size_of::<T>().max(16)];
        let contents = if data.is_empty() {
            &zeros
        } else {
            bytemuck::cast_slice(data)
        };
        self.device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
    }
}

/// Leaves out of the library's list what this build never asked for.
fn relevant(text: &str) -> String {
    let text = one_line(text);
    let is_relevant =
        |clause: &&str| !clause.ends_with("not requested") && !clause.ends_with("not compiled in");
    let clauses: Vec<&str> = text
        .split([',', ';'])
        .map(str::trim)
        .filter(is_relevant)
        .collect();
    clauses.join(", ")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
