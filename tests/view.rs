//! The window, under a display without a screen: what a user sees and does.
//!
//! Needs Xvfb and xdotool; without them the tests print why they are skipped, or fail where `CI` is set.
#![cfg(target_os = "linux")]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use common::{fixture, square};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt, ImageFormat};
use x11rb::rust_connection::RustConnection;

const WIDTH: u16 = 1000;
const HEIGHT: u16 = 700;
/// Software drawing on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(90);

/// One window at a time: they share two cores.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// A display without a screen; it ends when dropped.
struct Display {
    server: Child,
    name: String,
    connection: RustConnection,
    root: u32,
    _turn: MutexGuard<'static, ()>,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

fn present(program: &str) -> bool {
    Command::new(program).arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

impl Display {
    fn start() -> Option<Self> {
        for program in ["Xvfb", "xdotool"] {
            if !present(program) {
                let reason = format!("skipped: {program} is not installed (apt-get install xvfb xdotool)");
                assert!(std::env::var_os("CI").is_none(), "{reason}");
                println!("{reason}");
                return None;
            }
        }
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let screen = format!("{WIDTH}x{HEIGHT}x24");
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let output = server.stdout.take().expect("Xvfb's output");
        BufReader::new(output).read_line(&mut number).expect("a display number");
        let name = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&name)).expect("a connection to the display");
        let root = connection.setup().roots[screen].root;
        Some(Self { server, name, connection, root, _turn: turn })
    }

    /// The pixels of the display, row after row.
    fn pixels(&self) -> Vec<[u8; 3]> {
        let reply = self
            .connection
            .get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, WIDTH, HEIGHT, u32::MAX)
            .expect("a request")
            .reply()
            .expect("the display's picture");
        reply.data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect()
    }

    /// The pixels where the scene is shown: between the panels.
    fn scene(&self) -> Vec<[u8; 3]> {
        let pixels = self.pixels();
        let mut scene = Vec::new();
        for row in 120..HEIGHT as usize - 80 {
            let start = row * WIDTH as usize;
            scene.extend_from_slice(&pixels[start + 300..start + 640]);
        }
        scene
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool").args(arguments).env("DISPLAY", &self.name).output().expect("xdotool runs");
        assert!(output.status.success(), "xdotool {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// Opens `aam view` in a folder and waits until it shows the file.
    fn view(&self, folder: &Path, file: &str) -> Window<'_> {
        self.view_as(folder, file, file)
    }

    /// The same with any argument, and the file that it then shows.
    fn view_as(&self, folder: &Path, argument: &str, file: &str) -> Window<'_> {
        let process = Command::new(env!("CARGO_BIN_EXE_aam"))
            .args(["view", argument, "--size", &format!("{WIDTH}x{HEIGHT}")])
            .current_dir(folder)
            .env("DISPLAY", &self.name)
            .env("XDG_RUNTIME_DIR", folder)
            .env_remove("WAYLAND_DISPLAY")
            .stderr(Stdio::inherit())
            .spawn()
            .expect("aam starts");
        let mut window = Window { display: self, process, id: String::new() };
        let title = format!("^{file} - aam$");
        window.id = wait("the window's title", || {
            let search = ["search", "--onlyvisible", "--name", &title];
            let output = Command::new("xdotool").args(search).env("DISPLAY", &self.name).output().ok()?;
            let ids = String::from_utf8_lossy(&output.stdout).trim().to_owned();
            ids.lines().next().map(str::to_owned)
        });
        // Without a window manager nobody else gives the focus.
        self.xdotool(&["windowfocus", "--sync", &window.id]);
        window
    }
}

/// A running `aam view`; it ends when dropped.
struct Window<'a> {
    display: &'a Display,
    process: Child,
    id: String,
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Window<'_> {
    fn title(&self) -> String {
        self.display.xdotool(&["getwindowname", &self.id])
    }

    fn key(&self, key: &str) {
        self.display.xdotool(&["key", key]);
    }

    /// Drags with a button through the middle of the scene.
    fn drag(&self, button: &str) {
        let steps: &[&[&str]] = &[
            &["mousemove", "420", "350"],
            &["mousedown", button],
            &["mousemove", "440", "355"],
            &["mousemove", "480", "370"],
            &["mousemove", "540", "390"],
            &["mouseup", button],
            &["mousemove", "560", "600"],
        ];
        for step in steps {
            self.display.xdotool(step);
            std::thread::sleep(Duration::from_millis(60));
        }
    }

    fn ends_with(&mut self, code: i32) {
        let status = wait("the end", || self.process.try_wait().expect("a status"));
        assert_eq!(status.code(), Some(code));
    }

    fn is_alive(&mut self) -> bool {
        self.process.try_wait().expect("a status").is_none()
    }

    /// The scene once it has been the same for half a second.
    fn settled(&self) -> Vec<[u8; 3]> {
        let mut last = self.display.scene();
        let mut since = Instant::now();
        let start = Instant::now();
        while since.elapsed() < Duration::from_millis(500) {
            assert!(start.elapsed() < PATIENCE, "the picture does not come to rest");
            std::thread::sleep(Duration::from_millis(100));
            let now = self.display.scene();
            if now != last {
                last = now;
                since = Instant::now();
            }
        }
        last
    }

    /// Does something and waits until the scene looks different; gives what it then looks like.
    fn changed_by(&self, what: &str, action: impl FnOnce()) -> Vec<[u8; 3]> {
        let before = self.settled();
        action();
        wait(what, || (different(&before, &self.display.scene()) > 0.002).then_some(()));
        self.settled()
    }
}

fn wait<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn colors(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().collect::<BTreeSet<_>>().len()
}

/// The fraction of pixels that differ.
fn different(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    a.iter().zip(b).filter(|(a, b)| a != b).count() as f64 / a.len() as f64
}

fn is_reddish(pixels: &[[u8; 3]]) -> bool {
    let middle = pixels[pixels.len() / 2 + 170];
    middle[0] > middle[2].saturating_add(40)
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).expect("a folder");
        for entry in fs::read_dir(from).expect("a folder") {
            let entry = entry.expect("an entry");
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        fs::copy(from, to).expect("a copy");
    }
}

#[test]
fn a_model_is_shown_turned_and_closed() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["crate.gltf", "crate.bin", "textures"] {
        copy(&fixture(name), &folder.path().join(name));
    }
    let mut window = display.view(folder.path(), "crate.gltf");
    wait("the model", || (colors(&display.scene()) > 500).then_some(()));
    assert!(colors(&display.pixels()) > 1000, "panels and model are drawn");

    let turned = window.changed_by("turning", || window.drag("1"));
    let moved = window.changed_by("moving", || window.drag("2"));
    assert!(different(&turned, &moved) > 0.02);
    window.changed_by("looking around", || window.drag("3"));
    window.changed_by("coming closer", || {
        display.xdotool(&["click", "4"]);
    });
    window.changed_by("wireframe", || window.key("x"));
    window.changed_by("no wireframe", || window.key("x"));
    window.changed_by("the diffuse layer alone", || window.key("l"));
    window.changed_by("flying", || {
        display.xdotool(&["keydown", "w"]);
        std::thread::sleep(Duration::from_millis(400));
        display.xdotool(&["keyup", "w"]);
    });
    window.changed_by("the front", || window.key("1"));
    window.changed_by("the keys", || window.key("h"));
    window.changed_by("no keys", || window.key("Escape"));
    assert!(window.is_alive(), "Escape closes the list of keys, not the window");

    window.key("p");
    wait("a picture", || folder.path().join("crate-001.png").metadata().ok().filter(|file| file.len() > 1000));
    window.key("q");
    window.ends_with(0);
}

#[test]
fn a_file_that_changes_is_shown_again() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("square.aam");
    fs::write(&file, square("0.9 0.1 0.1")).expect("written");
    let mut window = display.view(folder.path(), "square.aam");
    wait("a red square", || is_reddish(&display.scene()).then_some(()));

    fs::write(&file, square("0.1 0.1 0.9")).expect("written");
    wait("a blue square", || (!is_reddish(&display.scene())).then_some(()));
    let blue = window.settled();

    fs::write(&file, "MATERIALS\nMatCount: what?\n").expect("written");
    wait("the reason", || (different(&blue, &display.scene()) > 0.001).then_some(()));
    let broken = window.settled();
    let middle = broken.len() / 2;
    assert_eq!(broken[middle..middle + 300], blue[middle..middle + 300], "the last good picture stays");
    assert!(window.is_alive());

    fs::remove_file(&file).expect("removed");
    window.settled();
    let other = folder.path().join("other");
    fs::write(&other, square("0.9 0.1 0.1")).expect("written");
    fs::rename(&other, &file).expect("renamed");
    wait("a red square", || is_reddish(&display.scene()).then_some(()));
    window.key("Escape");
    window.ends_with(0);
}

#[test]
fn changes_are_saved_to_a_scene_file() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("square.aam"), square("0.9 0.1 0.1")).expect("written");
    let mut window = display.view(folder.path(), "square.aam");
    wait("a red square", || is_reddish(&display.scene()).then_some(()));
    window.changed_by("hiding the square", || {
        display.xdotool(&["mousemove", "208", "77", "click", "1"]);
    });
    assert!(!is_reddish(&display.scene()));
    window.key("q");
    std::thread::sleep(Duration::from_millis(700));
    assert!(window.is_alive(), "unsaved changes ask once");
    window.key("ctrl+s");
    let saved = folder.path().join("square.scene.toml");
    let text = wait("the scene file", || fs::read_to_string(&saved).ok());
    assert!(text.contains("square.aam") && text.contains("visible = false") && text.contains("[[camera]]"), "{text}");
    window.key("q");
    window.ends_with(0);
}

#[test]
fn the_demo_goes_through_its_scenes_and_steps() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = display.view_as(folder.path(), "--demo", "demo-torus.scene.toml");
    wait("the first scene", || (colors(&display.scene()) > 300).then_some(()));
    window.key("p");
    let shadowed = window.settled();
    let unshadowed = window.changed_by("no shadows", || window.key("m"));
    assert!(different(&shadowed, &unshadowed) > 0.01);
    window.changed_by("shadows", || window.key("m"));
    let light = window.changed_by("the view of the light", || window.key("l"));
    assert!(different(&shadowed, &light) > 0.2);
    window.changed_by("the eye's view", || window.key("l"));
    window.key("u");
    let moved = |before: &[[u8; 3]]| different(before, &display.scene()) > 0.002;
    wait("spheres that turn", || moved(&shadowed).then_some(()));
    window.key("p");
    window.changed_by("the start", || window.key("r"));
    for next in ["demo-spheres", "demo-teapot", "demo-torus"] {
        window.key("space");
        wait(next, || window.title().starts_with(next).then_some(()));
    }
    assert!(!folder.path().join("demo-torus-001.png").exists(), "P pauses");
    window.key("Escape");
    window.ends_with(0);
}

#[test]
fn resizing_and_hiding_do_no_harm() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("square.aam"), square("0.9 0.1 0.1")).expect("written");
    let mut window = display.view(folder.path(), "square.aam");
    wait("a red square", || is_reddish(&display.scene()).then_some(()));
    for step in 0..30 {
        let size = [1 + 37 * step % 900, 1 + 53 * step % 640].map(|side| side.to_string());
        display.xdotool(&["windowsize", &window.id, &size[0], &size[1]]);
    }
    display.xdotool(&["windowunmap", "--sync", &window.id]);
    std::thread::sleep(Duration::from_millis(300));
    display.xdotool(&["windowmap", "--sync", &window.id]);
    display.xdotool(&["windowsize", "--sync", &window.id, &WIDTH.to_string(), &HEIGHT.to_string()]);
    wait("a red square", || is_reddish(&display.scene()).then_some(()));
    display.xdotool(&["windowfocus", "--sync", &window.id]);
    window.key("q");
    window.ends_with(0);
}

#[test]
fn a_broken_file_says_why_and_can_be_mended() {
    let Some(display) = Display::start() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("broken.aam");
    fs::write(&file, "nonsense").expect("written");
    let mut window = display.view(folder.path(), "broken.aam");
    fs::write(&file, square("0.9 0.1 0.1")).expect("written");
    wait("a red square", || is_reddish(&display.scene()).then_some(()));
    window.key("q");
    window.ends_with(0);
}

#[test]
fn without_a_display_there_is_advice() {
    let output = Command::new(env!("CARGO_BIN_EXE_aam"))
        .args(["view"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .expect("aam runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("DISPLAY") && error.contains("aam render"), "{error}");
}
