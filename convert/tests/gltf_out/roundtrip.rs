//! From a document to GLB and back.
