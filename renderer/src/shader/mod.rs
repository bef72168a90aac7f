//! Shaders: assembling their text from parts.

/// Why a shader's text cannot be assembled.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShaderError {
    /// An imported file does not exist.
    #[error("{file}:{line}: there is no shader file {name:?}")]
    UnknownImport {
        /// The file.
        file: String,
        /// Its line.
        line: usize,
        /// What was asked for.
        name: String,
    },
    /// A directive cannot be understood, or `#if` and `#endif` do not match.
    #[error("{file}:{line}: {reason}")]
    Directive {
        /// The file.
        file: String,
        /// Its line.
        line: usize,
        /// What is wrong.
        reason: String,
    },
}
