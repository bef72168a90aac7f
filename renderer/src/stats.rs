//! What a frame cost.

/// What a frame cost, and what there is to say about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameStats {
    /// Time on the CPU.
    pub cpu: CpuTimes,
    /// Time on the GPU by pass, in the order of execution; `None` where the device has no timestamps or
    /// [`crate::RenderOptions::gpu_timing`] is off. [`crate::Renderer::render`] does not wait for the GPU: it reports
    /// the last frame that is known to have ended (`None` until there is one).
    pub gpu: Option<Vec<PassTime>>,
    /// Draw calls.
    pub draws: u32,
    /// Changes of pipeline between draw calls.
    pub pipeline_switches: u32,
    /// Triangles sent to the GPU (instances counted).
    pub triangles: u64,
    /// Of these, triangles sorted back to front.
    pub sorted_triangles: u64,
    /// Points of displaced surfaces that were worked out for this frame: 0 while nothing about them changes.
    pub displaced_points: u64,
    /// Pipelines built for this frame: 0 once everything in view was drawn before.
    pub pipelines_built: u32,
    /// Bytes copied to the GPU for this frame.
    pub bytes_uploaded: u64,
    /// Shadow maps drawn; a cascade or the face of a cube counts as one.
    pub shadow_maps: u32,
    /// Draw calls of casters, which are part of `draws`.
    pub caster_draws: u32,
    /// Bytes of all shadow maps.
    pub shadow_bytes: u64,
    /// Lights drawn.
    pub lights: u32,
    /// True when the scene has no lights and was lit by one at the camera.
    pub camera_light: bool,
    /// What the user should know, such as a texture that had to be downscaled; each said once, when it happens.
    pub warnings: Vec<String>,
}

impl FrameStats {
    /// Sum of all GPU times in milliseconds.
    pub fn gpu_ms(&self) -> Option<f64> {
        self.gpu.as_ref().map(|passes| passes.iter().map(|pass| pass.ms).sum())
    }
}

/// Time on the CPU in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuTimes {
    /// Preparing and uploading: meshes, textures, materials.
    pub upload_ms: f64,
    /// Building shaders and pipelines that no frame needed before. A driver may put part of that off to the first draw.
    pub pipelines_ms: f64,
    /// Sorting transparent triangles.
    pub sort_ms: f64,
    /// Recording and submitting commands.
    pub encode_ms: f64,
    /// Waiting for the GPU and reading the picture back; 0 unless an image was asked for.
    pub read_back_ms: f64,
}

impl CpuTimes {
    /// What the frame cost the CPU; waiting for the GPU is not part of it.
    pub fn total_ms(&self) -> f64 {
        self.upload_ms + self.pipelines_ms + self.sort_ms + self.encode_ms
    }
}

/// Time that one pass took on the GPU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub name: &'static str,
    /// Milliseconds.
    pub ms: f64,
}

/// What the renderer holds on the GPU at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Resources {
    /// Meshes.
    pub meshes: usize,
    /// Vertex and index buffers of those meshes; a stream that no shader reads is not there.
    pub mesh_buffers: usize,
    /// Displaced surfaces: one for each subset of a mesh that a displacement map moves.
    pub displaced_surfaces: usize,
    /// Textures (of material layers and backgrounds).
    pub textures: usize,
    /// Materials.
    pub materials: usize,
    /// Shader variants compiled since the start.
    pub shaders_built: usize,
    /// Pipelines built since the start.
    pub pipelines_built: usize,
    /// Render targets of the renderer's own: depth, multisampled colour, intermediate colour.
    pub targets: usize,
    /// Shadow maps: one for each source, whatever its layers.
    pub shadow_maps: usize,
    /// Bytes in mesh buffers, displaced surfaces, textures, environments and shadow maps.
    pub bytes: u64,
    /// Of these, bytes of environments.
    pub environment_bytes: u64,
}
