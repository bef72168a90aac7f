//! Turning what a device reports while a frame is made into errors.

use crate::{Gpu, RenderError};

/// Collects the errors of everything done while it lives.
pub(crate) struct Scopes {
    // Dropped, and popped, in this order: the opposite of the order in which they were pushed.
    internal: wgpu::ErrorScopeGuard,
    validation: wgpu::ErrorScopeGuard,
    out_of_memory: wgpu::ErrorScopeGuard,
}

impl Scopes {
    pub(crate) fn open(gpu: &Gpu) -> Self {
        let out_of_memory = gpu.device().push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = gpu.device().push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = gpu.device().push_error_scope(wgpu::ErrorFilter::Internal);
        Self { internal, validation, out_of_memory }
    }

    /// The first cause among what was reported: lack of memory or a lost device make other errors follow.
    pub(crate) fn close(self, gpu: &Gpu, during: &'static str) -> Result<(), RenderError> {
        let [internal, validation, out_of_memory] =
            [self.internal, self.validation, self.out_of_memory].map(|scope| pollster::block_on(scope.pop()));
        if let Some(reason) = gpu.lost() {
            return Err(RenderError::DeviceLost { reason });
        }
        if out_of_memory.is_some() {
            return Err(RenderError::OutOfMemory { during });
        }
        match internal.or(validation) {
            Some(error) => Err(RenderError::Gpu { during, message: error.to_string() }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_become_errors_and_only_once() {
        let Ok(gpu) = Gpu::headless() else {
            assert!(std::env::var("CI").as_deref() != Ok("true"), "CI needs a GPU adapter");
            println!("skipped: no GPU adapter");
            return;
        };
        let buffer = |size, usage| {
            gpu.device().create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let scopes = Scopes::open(&gpu);
        buffer(4, wgpu::BufferUsages::empty());
        let error = scopes.close(&gpu, "made a buffer").unwrap_err();
        assert!(matches!(error, RenderError::Gpu { during: "made a buffer", .. }), "{error}");

        // More than any machine has, where the device does not refuse it by its limits.
        let scopes = Scopes::open(&gpu);
        buffer(gpu.device().limits().max_buffer_size.min(1 << 46), wgpu::BufferUsages::VERTEX);
        let outcome = scopes.close(&gpu, "made a buffer");
        let many = gpu.device().limits().max_buffer_size >= 1 << 42;
        assert!(!many || matches!(outcome, Err(RenderError::OutOfMemory { .. })), "{outcome:?}");

        let scopes = Scopes::open(&gpu);
        buffer(4, wgpu::BufferUsages::VERTEX);
        assert!(scopes.close(&gpu, "made a buffer").is_ok());
    }
}
