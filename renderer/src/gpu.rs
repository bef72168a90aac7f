//! The device: finding an adapter, asking for what the renderer can use, and collecting the errors it raises.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Why there is no device to draw with.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No driver offers an adapter.
    #[error(
        "no GPU adapter found ({reason}); install a Vulkan driver (on Debian, the software driver is the package \
         mesa-vulkan-drivers), or check WGPU_BACKEND and WGPU_ADAPTER_NAME if they are set"
    )]
    NoAdapter {
        /// What the search said.
        reason: String,
    },
    /// The adapter is there, but gives no device.
    #[error("the GPU adapter {adapter} gives no device: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// The adapter lacks something that every frame needs.
    #[error("the GPU adapter {adapter} cannot be used: {reason}")]
    Unsuitable {
        /// Its name.
        adapter: String,
        /// What it lacks.
        reason: String,
    },
}

/// What the adapter is, for reports: figures mean nothing without it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterSummary {
    /// Its name, such as `llvmpipe (LLVM 15.0.6, 256 bits)`.
    pub name: String,
    /// Driver and its version.
    pub driver: String,
    /// `vulkan`, `gl`, `metal`, `dx12`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: &'static str,
}

impl AdapterSummary {
    fn of(info: &wgpu::AdapterInfo) -> Self {
        let driver = [info.driver.trim(), info.driver_info.trim()].join(" ").trim().to_owned();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        };
        Self { name: info.name.trim().to_owned(), driver, backend: info.backend.to_string(), kind }
    }

    /// True when pictures are made by a processor, not a graphics card: its timings say nothing about a GPU.
    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }
}

impl fmt::Display for AdapterSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.kind, self.backend)?;
        if !self.driver.is_empty() {
            write!(f, ", {}", self.driver)?;
        }
        f.write_str(")")
    }
}

/// What the device reported outside of any error scope.
#[derive(Debug, Default)]
struct Reports {
    lost: Option<String>,
    errors: Vec<String>,
}

/// A device to draw with. Clones share it.
#[derive(Clone, Debug)]
pub struct Gpu {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    summary: AdapterSummary,
    reports: Arc<Mutex<Reports>>,
}

impl Gpu {
    /// An instance that follows `WGPU_BACKEND` and the other variables of wgpu.
    pub fn instance() -> wgpu::Instance {
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env())
    }

    /// A device without a window. `WGPU_BACKEND`, `WGPU_ADAPTER_NAME` and `WGPU_POWER_PREF` choose; software adapters
    /// count.
    ///
    /// # Errors
    /// When no adapter is there or it gives no usable device.
    pub fn headless() -> Result<Self, GpuError> {
        Self::request(&Self::instance(), None)
    }

    /// A device that can present to `surface`, which `instance` made.
    ///
    /// # Errors
    /// When no adapter can present there or it gives no usable device.
    pub fn for_surface(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>) -> Result<Self, GpuError> {
        Self::request(instance, Some(surface))
    }

    /// A device that others use too, for example `egui-wgpu`'s. It should have been made with
    /// [`Gpu::device_descriptor`], without which timings and large textures may be missing. Its handler for uncaptured
    /// errors is left alone; its callback for the loss of the device is replaced.
    ///
    /// # Errors
    /// When the device lacks something that every frame needs.
    pub fn from_parts(adapter: wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Result<Self, GpuError> {
        let summary = AdapterSummary::of(&adapter.get_info());
        let gpu = Self { adapter, device, queue, summary, reports: Arc::default() };
        gpu.check_suitable()?;
        let reports = Arc::clone(&gpu.reports);
        gpu.device.set_device_lost_callback(move |reason, message| {
            let mut reports = reports.lock().unwrap_or_else(PoisonError::into_inner);
            reports.lost = Some(if message.is_empty() { format!("{reason:?}") } else { message });
        });
        Ok(gpu)
    }

    /// What the renderer asks an adapter for: all its limits, and the optional features that a frame makes use of.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES
            | wgpu::Features::FLOAT32_FILTERABLE
            | wgpu::Features::DEPTH32FLOAT_STENCIL8;
        wgpu::DeviceDescriptor {
            label: Some("aam"),
            required_features: adapter.features() & wanted,
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

    fn request(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<Self, GpuError> {
        let adapter =
            pollster::block_on(find_adapter(instance, surface)).map_err(|reason| GpuError::NoAdapter { reason })?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Self::device_descriptor(&adapter)))
            .map_err(|error| GpuError::NoDevice { adapter: adapter.get_info().name, reason: error.to_string() })?;
        let gpu = Self::from_parts(adapter, device, queue)?;
        let reports = Arc::clone(&gpu.reports);
        gpu.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            log::error!("uncaptured GPU error: {error}");
            reports.lock().unwrap_or_else(PoisonError::into_inner).errors.push(error.to_string());
        }));
        Ok(gpu)
    }

    fn check_suitable(&self) -> Result<(), GpuError> {
        let unsuitable = |reason: String| Err(GpuError::Unsuitable { adapter: self.summary.name.clone(), reason });
        let limits = self.device.limits();
        if limits.max_vertex_buffers < 8 || limits.max_vertex_attributes < 16 {
            return unsuitable(format!(
                "it takes {} vertex buffers with {} attributes, and a frame needs 8 with 16",
                limits.max_vertex_buffers, limits.max_vertex_attributes
            ));
        }
        if limits.max_uniform_buffer_binding_size < 16 << 10 {
            return unsuitable(format!(
                "its uniform buffers hold {} bytes, and a frame needs 16384",
                limits.max_uniform_buffer_binding_size
            ));
        }
        Ok(())
    }

    /// The adapter.
    pub fn adapter(&self) -> &wgpu::Adapter {
        &self.adapter
    }

    /// The device.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// What the adapter is.
    pub fn summary(&self) -> &AdapterSummary {
        &self.summary
    }

    /// Why the device was lost, if it was: it then draws nothing any more, and a new one must be made.
    pub fn lost(&self) -> Option<String> {
        self.reports.lock().unwrap_or_else(PoisonError::into_inner).lost.clone()
    }

    /// Errors that came outside of a frame since the last call. Only devices made by [`Gpu::headless`] and
    /// [`Gpu::for_surface`] collect them.
    pub fn take_errors(&self) -> Vec<String> {
        std::mem::take(&mut self.reports.lock().unwrap_or_else(PoisonError::into_inner).errors)
    }

    /// Waits until the device has done everything submitted so far.
    ///
    /// # Errors
    /// A sentence, when the device was lost or does not answer.
    pub fn wait(&self) -> Result<(), String> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(|error| error.to_string())
    }
}

/// The adapter that `WGPU_ADAPTER_NAME` names, or else the best one; a sentence if there is none.
async fn find_adapter(instance: &wgpu::Instance, surface: Option<&wgpu::Surface<'_>>) -> Result<wgpu::Adapter, String> {
    if let Some(name) = std::env::var_os("WGPU_ADAPTER_NAME") {
        return named_adapter(instance, surface, &name.to_string_lossy()).await;
    }
    let power_preference = wgpu::PowerPreference::from_env().unwrap_or(wgpu::PowerPreference::HighPerformance);
    let options = wgpu::RequestAdapterOptions { power_preference, compatible_surface: surface, ..Default::default() };
    instance.request_adapter(&options).await.map_err(|error| error.to_string())
}

/// The first adapter whose name contains `name`, in any case. (wgpu's own helper panics if there is none.)
async fn named_adapter(
    instance: &wgpu::Instance,
    surface: Option<&wgpu::Surface<'_>>,
    name: &str,
) -> Result<wgpu::Adapter, String> {
    let wanted = name.to_lowercase();
    let mut others = Vec::new();
    for adapter in instance.enumerate_adapters(wgpu::Backends::all()).await {
        if surface.is_some_and(|surface| !adapter.is_surface_supported(surface)) {
            continue;
        }
        let found = adapter.get_info().name;
        if found.to_lowercase().contains(&wanted) {
            return Ok(adapter);
        }
        others.push(found);
    }
    let others = if others.is_empty() { "there is none".to_owned() } else { format!("there is {}", others.join(", ")) };
    Err(format!("no adapter's name contains {name:?} as WGPU_ADAPTER_NAME asks; {others}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_no_adapter_has_is_an_error_that_lists_those_there_are() {
        let instance = Gpu::instance();
        let error = pollster::block_on(named_adapter(&instance, None, "No Such Card")).unwrap_err();
        assert!(error.contains("\"No Such Card\"") && error.contains("there is "), "{error}");
    }
}
