//! A conversion that is killed, or that finds the disk full, leaves the earlier output whole, or none where there was none.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::fixture;

/// The conversion of the crate to `out.aam` in a folder, with all its output discarded.
fn convert(folder: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_aam"))
        .args(["convert", "--force"])
        .arg(fixture("crate.glb"))
        .arg(folder.join("out.aam"))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the command starts")
}

/// Every file below a folder with its content, but for temporary ones.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(current) = pending.pop() {
        for entry in fs::read_dir(&current).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                pending.push(path);
            } else if !is_temporary(&path) {
                found.insert(path.strip_prefix(folder).expect("below").to_owned(), fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with(".aam-") && name.ends_with(".tmp")
}

/// A new folder with the earlier files in it.
fn folder_with(earlier: &BTreeMap<PathBuf, Vec<u8>>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in earlier {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, content).expect("written");
    }
    folder
}

/// Each file is as it was or as it is to be.
fn assert_whole(folder: &Path, earlier: &BTreeMap<PathBuf, Vec<u8>>, later: &BTreeMap<PathBuf, Vec<u8>>, when: &str) {
    let found = files(folder);
    for (name, content) in &found {
        let whole = earlier.get(name) == Some(content) || later.get(name) == Some(content);
        assert!(whole, "{} is neither the earlier nor the new file after {when}", name.display());
    }
    for name in earlier.keys() {
        assert!(found.contains_key(name), "{} is gone after {when}", name.display());
    }
    // The main file comes last, so that what it names is there.
    let main = Path::new("out.aam");
    if found.get(main) == later.get(main) {
        assert_eq!(&found, later, "after {when}");
    }
}

#[test]
fn a_killed_conversion_leaves_whole_files() {
    let whole = tempfile::tempdir().expect("a folder");
    let start = Instant::now();
    assert!(convert(whole.path()).wait().expect("it ends").success());
    let duration = start.elapsed();
    let later = files(whole.path());
    assert!(later.len() > 1, "textures too");
    // Earlier output with the same names and other content.
    let earlier: BTreeMap<PathBuf, Vec<u8>> =
        later.keys().map(|name| (name.clone(), name.to_string_lossy().repeat(1000).into_bytes())).collect();
    let none = BTreeMap::new();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut killed, mut written) = (0, 0);
    for round in 0..40 {
        let earlier = if round % 2 == 0 { &earlier } else { &none };
        let folder = folder_with(earlier);
        let mut child = convert(folder.path());
        let when = if round % 4 < 2 {
            // At any moment.
            let moment = duration.mul_f64(1.1 * random());
            std::thread::sleep(moment);
            format!("{moment:?}")
        } else {
            // While files are written.
            while child.try_wait().expect("its state").is_none()
                && !fs::read_dir(folder.path()).expect("a folder").flatten().any(|entry| is_temporary(&entry.path()))
            {
                std::thread::sleep(Duration::from_micros(50));
            }
            let moment = Duration::from_micros((4000.0 * random()) as u64);
            std::thread::sleep(moment);
            format!("{moment:?} of writing")
        };
        child.kill().expect("it is killed or has ended");
        let status = child.wait().expect("it ends");
        if status.success() {
            written += 1;
        } else {
            killed += 1;
        }
        assert_whole(folder.path(), earlier, &later, &when);
        // What a killed run left behind does not stand in the way of the next.
        if round % 8 == 0 {
            assert!(convert(folder.path()).wait().expect("it ends").success(), "after {when}");
            assert_eq!(files(folder.path()), later, "after {when}");
        }
    }
    println!("{killed} killed, {written} done before");
    assert!(killed > 0);
}

/// What must hold when a conversion into this folder fails for want of room.
#[cfg(unix)]
fn assert_refused(folder: &Path, output: &std::process::Output, earlier: &[u8]) {
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && output.status.code().is_some(), "{:?}: {error}", output.status);
    assert!(error.contains("cannot write"), "{error}");
    let found = files(folder);
    let out = found.get(Path::new("out.aam")).map(Vec::as_slice);
    assert_eq!(out, (!earlier.is_empty()).then_some(earlier), "{error}");
    let left = fs::read_dir(folder).expect("a folder").flatten().filter(|entry| is_temporary(&entry.path())).count();
    assert_eq!(left, 0, "temporary files are removed");
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_the_earlier_output() {
    /// A small disk, for as long as this lives.
    struct Disk(tempfile::TempDir);
    impl Drop for Disk {
        fn drop(&mut self) {
            let _ = Command::new("umount").arg(self.0.path()).status();
        }
    }
    for earlier in [&b""[..], b"the earlier output"] {
        let folder = tempfile::tempdir().expect("a folder");
        let mount = ["-t", "tmpfs", "-o", "size=128k", "none"];
        let mounted = Command::new("mount").args(mount).arg(folder.path()).output();
        match mounted {
            Ok(output) if output.status.success() => {}
            Ok(output) => {
                println!("skipped: a small disk cannot be mounted: {}", String::from_utf8_lossy(&output.stderr).trim());
                return;
            }
            Err(error) => {
                println!("skipped: a small disk cannot be mounted: {error}");
                return;
            }
        }
        let disk = Disk(folder);
        let out = disk.0.path().join("out.aam");
        if !earlier.is_empty() {
            fs::write(&out, earlier).expect("room for the earlier output");
        }
        let output = Command::new(env!("CARGO_BIN_EXE_aam"))
            .args(["convert", "--force"])
            .arg(fixture("crate.glb"))
            .arg(&out)
            .output()
            .expect("the command starts");
        assert_refused(disk.0.path(), &output, earlier);
    }
}

/// The same by a limit on the size of files, which needs no rights.
#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_leaves_the_earlier_output() {
    for earlier in [&b""[..], b"the earlier output"] {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("out.aam");
        if !earlier.is_empty() {
            fs::write(&out, earlier).expect("written");
        }
        let output = Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 64; exec \"$0\" convert --force \"$1\" \"$2\""])
            .arg(env!("CARGO_BIN_EXE_aam"))
            .arg(fixture("crate.glb"))
            .arg(&out)
            .output()
            .expect("a shell");
        assert_refused(folder.path(), &output, earlier);
    }
}
