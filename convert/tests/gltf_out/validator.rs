//! The Khronos validator, through node.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What the validator says of a file.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Verdict {
    pub file: PathBuf,
    pub errors: usize,
    pub warnings: usize,
    pub messages: Vec<Message>,
}

#[derive(Debug, serde::Deserialize)]
pub(crate) struct Message {
    pub code: String,
    pub message: String,
    pub severity: u8,
    #[serde(default)]
    pub pointer: String,
}

/// Validates files; `None`, with the reason printed, where the validator cannot be had.
pub(crate) fn validate(files: &[PathBuf]) -> Option<Vec<Verdict>> {
    let modules = match modules() {
        Ok(modules) => modules,
        Err(reason) => {
            println!("skipped: {reason}");
            return None;
        }
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validator/validate.mjs");
    let output = Command::new("node").arg(script).arg(modules).args(files).output().expect("node starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("node prints UTF-8");
    Some(text.lines().map(|line| serde_json::from_str(line).expect("a verdict a line")).collect())
}

/// The folder with the installed validator, installing it when it is not there.
fn modules() -> &'static Result<PathBuf, String> {
    static MODULES: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    MODULES.get_or_init(|| {
        let run = |command: &mut Command| {
            let output = command.output().map_err(|error| format!("{command:?} does not start: {error}"))?;
            let error = String::from_utf8_lossy(&output.stderr);
            output.status.success().then_some(()).ok_or_else(|| format!("{command:?} failed: {}", error.trim()))
        };
        run(Command::new("node").arg("--version"))?;
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validator");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf-validator");
        if !folder.join("node_modules/gltf-validator/package.json").exists() {
            // Complete under another name first: tests of several programs may install at once.
            let new = folder.with_extension(std::process::id().to_string());
            let copy = || {
                std::fs::create_dir_all(&new)?;
                for file in ["package.json", "package-lock.json"] {
                    std::fs::copy(source.join(file), new.join(file))?;
                }
                std::io::Result::Ok(())
            };
            copy().map_err(|error| format!("{}: {error}", new.display()))?;
            run(Command::new("npm").args(["ci", "--no-audit", "--no-fund"]).current_dir(&new))?;
            if std::fs::rename(&new, &folder).is_err() && !folder.exists() {
                return Ok(new);
            }
        }
        Ok(folder)
    })
}
