//! The drawing of the crates in ARCHITECTURE.md is what `cargo metadata` tells.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

type Uses = BTreeMap<String, BTreeSet<String>>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().and_then(Path::parent).unwrap()
}

/// What stands in the drawing below "Who may use whom": `crate -> others`, two in a line.
fn drawn() -> Uses {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, rest) = page.split_once("Who may use whom:").expect("the drawing has its heading");
    let drawing = rest.split("```").nth(1).expect("the drawing is a block of code");
    let mut uses = Uses::new();
    for line in drawing.lines() {
        let mut parts = line.split("->");
        let mut user = parts.next().unwrap_or_default().trim().to_owned();
        let mut parts = parts.peekable();
        while let Some(part) = parts.next() {
            // Before the next arrow, the last word is the next user.
            let words: Vec<&str> = part.split_whitespace().collect();
            let (used, next) = match parts.peek() {
                Some(_) => words.split_at(words.len() - 1),
                None => (&words[..], &[][..]),
            };
            let used = match used.join(" ").as_str() {
                "nothing" => BTreeSet::new(),
                "all of the above" => uses.keys().cloned().collect(),
                list => list.split(',').map(|name| name.trim().to_owned()).collect(),
            };
            uses.insert(std::mem::replace(&mut user, next.concat()), used);
        }
    }
    uses
}

/// The folder that a package lies in, which is its short name.
fn short(manifest: &str) -> String {
    let folder = Path::new(manifest).parent().unwrap();
    folder.file_name().unwrap().to_string_lossy().into_owned()
}

/// The packages of the workspace that a manifest belongs to.
fn packages(manifest: &str) -> Vec<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1", "--manifest-path"])
        .arg(root().join(manifest))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

/// What the project's packages depend on among themselves, optional and for tests included. The Python
/// package is a workspace of its own.
fn found() -> Uses {
    let packages = ["Cargo.toml", "bindings/python/Cargo.toml"].map(packages).into_iter().flatten();
    let packages: Vec<Value> = packages.collect();
    let folders: BTreeMap<&str, String> = packages
        .iter()
        .map(|p| (p["name"].as_str().unwrap(), short(p["manifest_path"].as_str().unwrap())))
        .collect();
    let used = |package: &Value| {
        let dependencies = package["dependencies"].as_array().unwrap().iter();
        dependencies.filter_map(|d| folders.get(d["name"].as_str()?).cloned()).collect()
    };
    packages.iter().map(|p| (folders[p["name"].as_str().unwrap()].clone(), used(p))).collect()
}

#[test]
fn the_crates_use_each_other_as_drawn() {
    let (drawn, found) = (drawn(), found());
    let names = |uses: &Uses| uses.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&drawn), names(&found), "every crate stands in the drawing, and no other");
    for (user, used) in &found {
        let more: Vec<_> = used.difference(&drawn[user]).collect();
        assert!(more.is_empty(), "ARCHITECTURE.md does not let {user} use {more:?}");
        let fewer: Vec<_> = drawn[user].difference(used).collect();
        assert!(fewer.is_empty(), "ARCHITECTURE.md says that {user} uses {fewer:?}; it does not");
    }
}

#[test]
fn the_arena_knows_matchers_only_as_processes() {
    assert!(!found()["arena"].contains("matching"));
}
