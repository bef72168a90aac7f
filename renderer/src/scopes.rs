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
