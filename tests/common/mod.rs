//! What the tests of the command share: a folder of their own, the command in it, and a small file.
#![allow(dead_code, reason = "each of them uses a part")]

pub(crate) mod schema;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

/// A red square that faces the front, two metres wide, made of two triangles.
pub(crate) const SQUARE: &str = "\
MATERIALS
MatCount: 1
Mat# 0
{
\tName: m
\tClass: Standard
\tAm: 0.9 0.1 0.1
\tDi: 0.9 0.1 0.1
\tSp: 0.0 0.0 0.0
\tTr: 0.0
\tSh: 0.0
\tTx: N
\tTS: N
}
ENDMATERIALS
GEOMETRY
NObj: 1
NFrames: 1
Animation_mode: None
Frame: 0
{
\tObj: 0 square
\tPar: -1
\t{
\tMatID: 0
\tV_List: 4
\t\t-1.0 0.0 -1.0
\t\t1.0 0.0 -1.0
\t\t1.0 0.0 1.0
\t\t-1.0 0.0 1.0
\tTV_List: 0
\tI_List: 2 1
\t\tNEWGROUP: 0
\t\tI: 0 1 2 0
\t\tI: 0 2 3 0
\t\tENDGROUP
\tAnim_Ctrl: N
\t}
}
ENDGEOMETRY
";

/// The square in another colour.
pub(crate) fn square(color: &str) -> String {
    SQUARE.replace("0.9 0.1 0.1", color)
}

/// A file of the fixture with the crate.
pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/assets").join(name)
}

/// Whether pictures can be drawn on a GPU here; a software one counts.
pub(crate) fn has_gpu() -> bool {
    static HAS: OnceLock<bool> = OnceLock::new();
    *HAS.get_or_init(|| {
        let folder = Folder::new();
        folder.write("a.aam", SQUARE);
        let has = folder.aam(&["render", "a.aam", "-o", "a.png", "--size", "8x8", "--engine", "gpu"]).code == Some(0);
        assert!(has || std::env::var_os("CI").is_none(), "no GPU adapter, not even a software one");
        has
    })
}

/// A temporary folder to run the command in.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).expect("a file")
    }

    pub(crate) fn picture(&self, name: &str) -> image::DynamicImage {
        image::open(self.path(name)).expect("a picture")
    }

    pub(crate) fn fixture(&self, name: &str) -> String {
        fixture(name).display().to_string()
    }

    pub(crate) fn copy_fixture(&self, name: &str) {
        fs::copy(fixture(name), self.path(name)).expect("a copy");
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_aam"));
        command
            .args(arguments)
            .current_dir(self.0.path())
            .env("XDG_RUNTIME_DIR", self.0.path())
            .env_remove("RUST_BACKTRACE")
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE");
        command
    }

    pub(crate) fn aam(&self, arguments: &[&str]) -> Ran {
        Ran::of(self.command(arguments).stdin(Stdio::null()).output().expect("aam runs"))
    }

    pub(crate) fn aam_with_input(&self, arguments: &[&str], input: &[u8]) -> Ran {
        let mut child = self
            .command(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("aam starts");
        child.stdin.take().expect("its input").write_all(input).expect("written");
        Ran::of(child.wait_with_output().expect("aam ends"))
    }
}

/// What a run gave.
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) bytes: Vec<u8>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Ran {
    pub(crate) fn of(output: Output) -> Self {
        let out = String::from_utf8_lossy(&output.stdout).into_owned();
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        Self { code: output.status.code(), bytes: output.stdout, out, err }
    }

    #[track_caller]
    pub(crate) fn succeeds(self) -> Self {
        assert_eq!(self.code, Some(0), "{}{}", self.out, self.err);
        self
    }

    /// Ends with a code, and a message that says what is wrong unless it is 1.
    #[track_caller]
    pub(crate) fn fails(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}{}", self.out, self.err);
        assert!(code == 1 || self.err.contains("error: "), "{}", self.err);
        self
    }

    /// Ends with a code, whatever is said.
    #[track_caller]
    pub(crate) fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}{}", self.out, self.err);
        self
    }

    /// Contains a text, on either stream.
    #[track_caller]
    pub(crate) fn says(&self, text: &str) -> &Self {
        assert!(self.out.contains(text) || self.err.contains(text), "{text:?} is not in\n{}{}", self.out, self.err);
        self
    }

    #[track_caller]
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.out).expect("JSON")
    }
}
