//! What a document means: resolved materials, normals, tangents, poses and bounds.
