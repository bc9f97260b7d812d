//! Submissions as zip archives, good and hostile.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::classroom::{Classroom, HONEST};

/// What stands in an archive beside names.
#[derive(Clone, Copy)]
enum Entry<'a> {
    Text(&'a str),
    Folder,
    Link(&'a str),
}

use Entry::{Folder, Link, Text};

fn archive(path: &Path, entries: &[(&str, Entry<'_>)]) -> PathBuf {
    let mut writer = ZipWriter::new(File::create(path).unwrap());
    let options = SimpleFileOptions::default();
    for (name, entry) in entries {
        match entry {
            Text(text) => {
                writer.start_file(*name, options).unwrap();
                writer.write_all(text.as_bytes()).unwrap();
            }
            Folder => writer.add_directory(*name, options).unwrap(),
            Link(target) => writer.add_symlink(*name, *target, options).unwrap(),
        }
    }
    writer.finish().unwrap();
    path.to_owned()
}

#[test]
fn a_zipped_folder_is_graded_with_slashes_of_either_kind() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("handin", HONEST);
    let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let names = ["secret_id.py", "stereo_disparity_fast.py", "stereo_disparity_best.py"];
    let texts = names.map(read);
    for slash in ["/", "\\"] {
        let path = |name: &str| ["some", "where", name].join(slash);
        let mut entries = vec![
            (path(""), Folder),
            (path("__pycache__").replace("where", "__pycache__"), Text("clutter")),
            (["__MACOSX", "._secret_id.py"].join(slash), Text("clutter")),
        ];
        entries.extend(names.iter().zip(&texts).map(|(name, text)| (path(name), Text(text))));
        let entries: Vec<_> = entries.iter().map(|(name, entry)| (name.as_str(), *entry)).collect();
        let report = classroom.grade(&archive(&classroom.path("handin.zip"), &entries), &[]);
        assert_eq!(report.0["points"], 5.0, "{}", report.message(0));
        assert_eq!(report.0["secret_id"], "Secret handin");
    }
}

#[test]
fn what_leads_out_of_a_zip_is_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let fast = "stereo_disparity_fast.py";
    for (entries, words) in [
        (vec![("../../outside.py", Text("x"))], "leads out of the archive by `..`"),
        (vec![("a/../../outside.py", Text("x"))], "leads out of the archive by `..`"),
        (vec![("..\\outside.py", Text("x"))], "leads out of the archive by `..`"),
        (vec![("/tmp/outside.py", Text("x"))], "is an absolute path"),
        (vec![(fast, Link("/etc/passwd"))], "is a link"),
        (vec![("d", Link("/tmp")), ("d/x.py", Text("x"))], "is a link"),
        (vec![("a.py", Text("x")), ("a.py/b.py", Text("x"))], "a file and a folder at once"),
        (vec![("main.py", Text("x"))], "it has main.py: rename them"),
        (vec![], "holds none of"),
    ] {
        let path = archive(&classroom.path("handin.zip"), &entries);
        classroom.grade(&path, &[]).expect("RE", &[words]);
    }
}

/// Sets bytes of the headers of the only entry: at `local` in its own, at `central` in the index.
fn with_bytes(path: &Path, (local, central): (usize, usize), value: &[u8]) {
    let mut bytes = fs::read(path).unwrap();
    let index = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    for at in [local, index + central] {
        bytes[at..at + value.len()].copy_from_slice(value);
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn what_cannot_be_unpacked_is_told_how_to_pack() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("handin.zip");
    // The flags of an entry, its method, and in the index alone its mode (of a pipe).
    for (places, value, words) in [
        ((6, 8), &[1, 0][..], "is encrypted: pack it without a password"),
        ((8, 10), &[12, 0], "is compressed in a rare way: pack it again"),
        ((14, 16), &[1, 2, 3, 4], "is damaged"),
    ] {
        archive(&path, &[("secret_id.py", Text("x"))]);
        with_bytes(&path, places, value);
        classroom.grade(&path, &[]).expect("RE", &[words]);
    }
    archive(&path, &[("secret_id.py", Text("x"))]);
    let mut bytes = fs::read(&path).unwrap();
    let index = bytes.windows(4).position(|four| four == b"PK\x01\x02").unwrap();
    bytes[index + 38..index + 42].copy_from_slice(&(0o010_644u32 << 16).to_le_bytes());
    fs::write(&path, bytes).unwrap();
    classroom.grade(&path, &[]).expect("RE", &["is no ordinary file"]);
}

#[test]
fn zips_that_grow_without_end_are_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("bomb.zip");
    let mut writer = ZipWriter::new(File::create(&path).unwrap());
    writer.start_file("stereo_disparity_fast.py", SimpleFileOptions::default()).unwrap();
    std::io::copy(&mut std::io::repeat(0).take(80 << 20), &mut writer).unwrap();
    writer.finish().unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 1 << 20);
    classroom.grade(&path, &[]).expect("RE", &["it holds more than 64 MiB"]);

    for (count, words) in
        [(1100, "it holds more than 1000 files"), (10_001, "it holds more than 10000 entries")]
    {
        let names: Vec<String> = (0..count).map(|k| format!("f{k}.py")).collect();
        let entries: Vec<_> = names.iter().map(|name| (name.as_str(), Text(""))).collect();
        classroom.grade(&archive(&path, &entries), &[]).expect("RE", &[words]);
    }

    // A hole, which takes no space, before an index that could be as long.
    archive(&path, &[("secret_id.py", Text("x"))]);
    File::options().write(true).open(&path).unwrap().set_len(65 << 20).unwrap();
    classroom.grade(&path, &[]).expect("RE", &["it holds more than 64 MiB"]);
}

#[test]
fn a_cut_zip_is_an_error_at_every_length() {
    let Some(classroom) = Classroom::without_python() else { return };
    let whole = classroom.path("whole.zip");
    archive(&whole, &[("secret_id.py", Text(&"#".repeat(700))), ("x.py", Text("##"))]);
    let bytes = fs::read(&whole).unwrap();
    let staging = tempfile::tempdir().unwrap();
    for length in 0..bytes.len() {
        let path = classroom.path("cut.zip");
        fs::write(&path, &bytes[..length]).unwrap();
        let target = staging.path().join(length.to_string());
        fs::create_dir(&target).unwrap();
        let error = arena::submission::Submission::open(&path, &target).unwrap_err();
        assert!(error.to_string().contains("cut.zip"), "{error}");
        assert!(error.is_entrants_fault(), "{error}");
    }
}

#[test]
fn a_zip_that_was_split_and_put_together_is_one() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("handin.zip");
    archive(&path, &[("main.py", Text("x"))]);
    let bytes = fs::read(&path).unwrap();
    for mark in [b"PK00", b"PK\x07\x08"] {
        fs::write(&path, [mark.as_slice(), &bytes].concat()).unwrap();
        classroom.grade(&path, &[]).expect("RE", &["it has main.py: rename them"]);
    }
}
