//! Submissions as tar archives, good and hostile.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use tar::{Builder, EntryType, Header};

use crate::classroom::{Classroom, HONEST};

/// Writes an archive; the header's name is set past the library's checks.
fn archive(path: &Path, entries: &[(&str, EntryType, &str, &[u8])]) -> PathBuf {
    let mut builder = Builder::new(File::create(path).unwrap());
    for (name, kind, link, content) in entries {
        let mut header = Header::new_gnu();
        header.as_old_mut().name[..name.len()].copy_from_slice(name.as_bytes());
        header.as_old_mut().linkname[..link.len()].copy_from_slice(link.as_bytes());
        header.set_entry_type(*kind);
        header.set_size(content.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        builder.append(&header, *content).unwrap();
    }
    builder.finish().unwrap();
    path.to_owned()
}

#[test]
fn folders_of_old_archives_are_marked_by_a_slash() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("handin", HONEST);
    let files: Vec<(String, Vec<u8>)> = (fs::read_dir(&folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .map(|path| (format!("h/{}", path.file_name().unwrap().display()), fs::read(path).unwrap()))
        .collect();
    // Before there was a type for folders.
    let old = EntryType::new(0);
    let mut entries = vec![("h/", old, "", &b""[..])];
    entries.extend(files.iter().map(|(name, content)| (&**name, old, "", &**content)));
    let packed = archive(&classroom.path("old.tar"), &entries);
    let report = classroom.grade(&packed, &[]);
    assert_eq!(report.0["points"], 5.0, "{}", report.message(0));
}

#[test]
fn a_packed_folder_is_graded_plain_or_compressed() {
    let Some(classroom) = Classroom::with_python() else { return };
    let folder = classroom.submission("handin", HONEST);
    fs::create_dir(folder.join("__pycache__")).unwrap();
    fs::write(folder.join("__pycache__/x.pyc"), "clutter").unwrap();
    let plain = classroom.path("handin.tar");
    let mut builder = Builder::new(File::create(&plain).unwrap());
    builder.append_dir_all("some/where/handin", &folder).unwrap();
    builder.finish().unwrap();
    let packed = classroom.path("handin.tgz");
    let mut encoder = GzEncoder::new(File::create(&packed).unwrap(), Compression::default());
    encoder.write_all(&fs::read(&plain).unwrap()).unwrap();
    encoder.finish().unwrap();
    for archive in [plain, packed] {
        let report = classroom.grade(&archive, &[]);
        assert_eq!(report.0["points"], 5.0, "{}", report.message(0));
        assert_eq!(report.0["secret_id"], "Secret handin");
    }
}

#[test]
fn what_leads_out_of_an_archive_is_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let fast = "stereo_disparity_fast.py";
    let file = EntryType::Regular;
    for (entries, words) in [
        (vec![("../../outside.py", file, "", b"x".as_slice())], "leads out of the archive by `..`"),
        (vec![("a/../../outside.py", file, "", b"x")], "leads out of the archive by `..`"),
        (vec![("/tmp/outside.py", file, "", b"x")], "is an absolute path"),
        (vec![(fast, EntryType::Symlink, "/etc/passwd", b"")], "is a link"),
        (vec![(fast, EntryType::Link, "/etc/passwd", b"")], "is a link"),
        (vec![("d", EntryType::Symlink, "/tmp", b""), ("d/x.py", file, "", b"x")], "is a link"),
        (vec![(fast, EntryType::Char, "", b"")], "is no ordinary file"),
        (vec![(fast, EntryType::Fifo, "", b"")], "is no ordinary file"),
        (
            vec![("a.py", file, "", b"x"), ("a.py/b.py", file, "", b"x")],
            "a file and a folder at once",
        ),
        (vec![("main.py", file, "", b"x")], "it has main.py: rename them"),
        (
            vec![("a/secret_id.py", file, "", b"x"), ("b/secret_id.py", file, "", b"x")],
            "holds files of the course in several folders, a and b among them: hand in one",
        ),
        (vec![], "holds none of"),
    ] {
        let path = archive(&classroom.path("handin.tar"), &entries);
        let report = classroom.grade(&path, &[]);
        for test in [0, 1] {
            assert_eq!(report.outcome(test), "RE", "{words}: {}", report.message(test));
            assert!(report.message(test).contains(words), "{words}: {}", report.message(test));
        }
    }
}

#[test]
fn archives_that_grow_without_end_are_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("bomb.tar.gz");
    let encoder = GzEncoder::new(File::create(&path).unwrap(), Compression::best());
    let mut builder = Builder::new(encoder);
    let mut header = Header::new_gnu();
    header.set_size(10 << 30);
    header.set_path("stereo_disparity_fast.py").unwrap();
    header.set_cksum();
    // The size is a claim: the archive holds 80 MiB and then ends.
    let zeros = std::io::Read::take(std::io::repeat(0), 80 << 20);
    builder.append(&header, zeros).unwrap();
    builder.into_inner().unwrap().finish().unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 1 << 20);
    let report = classroom.grade(&path, &[]);
    report.expect("RE", &["it holds more than 64 MiB"]);

    let many: Vec<String> = (0..1100).map(|k| format!("f{k}.py")).collect();
    let entries: Vec<_> =
        many.iter().map(|name| (name.as_str(), EntryType::Regular, "", b"".as_slice())).collect();
    let report = classroom.grade(&archive(&classroom.path("many.tar"), &entries), &[]);
    report.expect("RE", &["it holds more than 1000 files"]);
}

/// A header of this kind with this much content, such as the long name of the entry after it.
fn append(builder: &mut Builder<impl Write>, kind: EntryType, name: &str, content: &[u8]) {
    let mut header = Header::new_gnu();
    header.set_path(name).unwrap();
    header.set_entry_type(kind);
    header.set_size(content.len() as u64);
    header.set_cksum();
    builder.append(&header, content).unwrap();
}

#[test]
fn headers_that_grow_without_end_are_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("names.tar.gz");
    let pax = |value: usize| {
        let body = format!(" comment={}\n", "x".repeat(value));
        // The record's length counts its own digits.
        let digits = (1..9).find(|n| (body.len() + n).to_string().len() == *n).unwrap();
        format!("{}{body}", body.len() + digits)
    };
    for (kind, content, words) in [
        (EntryType::GNULongName, "a".repeat(8 << 20), "take more than 64 KiB"),
        (EntryType::GNULongLink, "a".repeat(8 << 20), "take more than 64 KiB"),
        (EntryType::XHeader, pax(8 << 20), "take more than 64 KiB"),
        // Short enough to be read, too long for any file.
        (EntryType::GNULongName, "a".repeat(60_000), "has too long a name: at most 255 bytes"),
        (EntryType::GNULongName, "a/".repeat(2000), "has too long a name: at most 255 bytes"),
    ] {
        let encoder = GzEncoder::new(File::create(&path).unwrap(), Compression::fast());
        let mut builder = Builder::new(encoder);
        append(&mut builder, kind, "extension", content.as_bytes());
        append(&mut builder, EntryType::Regular, "secret_id.py", b"x");
        builder.into_inner().unwrap().finish().unwrap();
        let report = classroom.grade(&path, &[]);
        report.expect("RE", &[words]);
        assert!(report.message(0).len() < 500, "{}", report.message(0).len());
    }
    // Attributes of a few kilobytes, as some systems pack them, are fine.
    let mut builder = Builder::new(File::create(classroom.path("mine.tar")).unwrap());
    append(&mut builder, EntryType::XHeader, "extension", pax(60_000).as_bytes());
    append(&mut builder, EntryType::Regular, "main.py", b"x");
    builder.finish().unwrap();
    let report = classroom.grade(&classroom.path("mine.tar"), &[]);
    report.expect("RE", &["it has main.py: rename them"]);
}

#[test]
fn what_is_left_out_of_an_archive_ends_somewhere() {
    let Some(classroom) = Classroom::without_python() else { return };
    let path = classroom.path("clutter.tar");
    let mut header = Header::new_gnu();
    header.set_path(".cache/big").unwrap();
    header.set_size(10 << 30);
    header.set_cksum();
    let mut file = File::create(&path).unwrap();
    file.write_all(header.as_bytes()).unwrap();
    // A hole, which takes no space.
    file.set_len(300 << 20).unwrap();
    let report = classroom.grade(&path, &[]);
    report.expect("RE", &["with what is left out it unpacks to more than 256 MiB"]);

    let mut builder = Builder::new(File::create(&path).unwrap());
    for _ in 0..10_001 {
        append(&mut builder, EntryType::Directory, "folder/", b"");
    }
    builder.finish().unwrap();
    classroom.grade(&path, &[]).expect("RE", &["it holds more than 10000 entries"]);
}

#[test]
fn other_files_are_told_what_is_wanted() {
    let Some(classroom) = Classroom::without_python() else { return };
    for (content, words) in [
        (b"Rar!\x1a".as_slice(), "is a rar archive: hand in a folder, or an archive (.zip, .tar"),
        (b"PK\x03\x04 and so on", "is damaged"),
        (b"", "is an empty file"),
        (b"def stereo_disparity_fast(): pass", "is a single text file"),
        (b"\x1f\x8b garbage", "is damaged"),
        (b"\xfd7zXZ\x00", "compressed by xz"),
    ] {
        fs::write(classroom.path("handin"), content).unwrap();
        classroom.grade(&classroom.path("handin"), &[]).expect("RE", &[words]);
    }
}

#[test]
fn a_cut_archive_is_an_error_or_a_shorter_one_at_every_length() {
    let Some(classroom) = Classroom::without_python() else { return };
    let file = EntryType::Regular;
    let whole = classroom.path("whole.tar");
    archive(&whole, &[("secret_id.py", file, "", &[b'#'; 700]), ("x.py", file, "", &[b'#'; 300])]);
    let bytes = fs::read(&whole).unwrap();
    let staging = tempfile::tempdir().unwrap();
    for length in 0..bytes.len() {
        let path = classroom.path("cut.tar");
        fs::write(&path, &bytes[..length]).unwrap();
        let target = staging.path().join(length.to_string());
        fs::create_dir(&target).unwrap();
        if let Err(error) = arena::submission::Submission::open(&path, &target) {
            assert!(error.to_string().contains("cut.tar"), "{error}");
        } else {
            assert!(length >= 512 + 700, "{length}");
        }
    }
}

#[cfg(unix)]
#[test]
fn links_in_a_folder_are_refused() {
    let Some(classroom) = Classroom::without_python() else { return };
    let folder = classroom.submission("linked", HONEST);
    std::os::unix::fs::symlink("/etc/passwd", folder.join("data.txt")).unwrap();
    classroom.grade(&folder, &[]).expect("RE", &["`data.txt` is a link: hand in the file itself"]);
    fs::remove_file(folder.join("data.txt")).unwrap();
    std::os::unix::fs::symlink("/etc", folder.join("data")).unwrap();
    classroom.grade(&folder, &[]).expect("RE", &["`data` is a link"]);
}
