//! The page of requirements names tests that exist.

use std::path::Path;

/// All Rust sources below a folder, as one text for each crate-like path.
fn sources(folder: &Path, all: &mut String) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry")) {
        let path = entry.path();
        let name = entry.file_name();
        if path.is_dir() && name != "target" && name != ".git" {
            sources(&path, all);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            all.push_str(&std::fs::read_to_string(&path).expect("a source"));
        }
    }
}

#[test]
fn every_test_that_the_page_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = String::new();
    sources(root, &mut all);
    let page = std::fs::read_to_string(root.join("docs/requirements.md")).expect("the page");
    let mut named = 0;
    for line in page.lines().filter(|line| line.contains("done: ")) {
        let state = line.rsplit(" | ").next().unwrap_or_default();
        for quoted in state.split('`').skip(1).step_by(2) {
            let test = quoted.rsplit("::").next().unwrap_or_default();
            if !quoted.contains("::") {
                let path = quoted.split(' ').next().unwrap_or_default();
                let known = [path.to_owned(), format!("{path}.rs")];
                assert!(known.iter().any(|path| root.join(path).exists()), "{path} does not exist:\n{line}");
            } else if test.contains('_') {
                assert!(all.contains(&format!("fn {test}(")), "there is no test {test}:\n{line}");
                named += 1;
            }
        }
    }
    assert!(named > 50, "only {named} tests are named");
}
