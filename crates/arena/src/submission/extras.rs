//! What a submission brings besides its source.

use std::fs;
use std::io::Read;
use std::path::Path;

use super::contents::{files_below, shortened};
use super::finding::Finding;

/// Bytes of files that together hold more than a few pages of text or a few numbers, and of sources that nobody wrote by
/// hand.
const LARGE: u64 = 20_000;
const LARGE_SOURCE: u64 = 200_000;
/// Files that [`besides_its_source`] names.
const SHOWN: usize = 5;

/// A finding for what may do more than the source tells: compiled code, which could be somebody else's matcher, and data,
/// which could be the truth.
pub(super) fn besides_its_source(root: &Path) -> Option<Finding> {
    let (mut sources, mut others, mut any_compiled) = (Vec::new(), Vec::new(), false);
    for path in files_below(root, None) {
        let bytes = path.metadata().map_or(0, |found| found.len());
        let name = shortened(&path.strip_prefix(root).unwrap_or(&path).display().to_string());
        let is_compiled = is_compiled(&path);
        any_compiled |= is_compiled;
        let kind = if is_compiled { " of compiled code" } else { "" };
        let is_source = !is_compiled && path.extension().is_some_and(|end| end == "py");
        (if is_source { &mut sources } else { &mut others }).push((bytes, name, kind));
    }
    let sum = |files: &[(u64, String, &str)]| files.iter().map(|(bytes, ..)| bytes).sum::<u64>();
    if sum(&sources) < LARGE_SOURCE {
        sources.clear();
    }
    if !any_compiled && sum(&others) < LARGE {
        others.clear();
    }
    let mut found = [sources, others].concat();
    // The largest first; of the same size by name.
    found.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let file = found.first()?.1.clone();
    let told: Vec<String> = (found.iter().take(SHOWN))
        .map(|(bytes, name, kind)| format!("{name} ({} KB{kind})", bytes.div_ceil(1000)))
        .collect();
    let more = match found.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let text = format!(
        "brought besides source that can be read: {}{more}; whoever grades may ask what for",
        told.join(", ")
    );
    Some(Finding { doubtful: true, ..Finding::about(file, text) })
}

/// Whether a file begins as programs and libraries do on Linux, Windows or macOS, or is called as Python's byte code is.
fn is_compiled(path: &Path) -> bool {
    const BEGINNINGS: [&[u8]; 5] =
        [b"\x7fELF", b"\xca\xfe\xba\xbe", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"!<arch>\n"];
    let mut beginning = Vec::new();
    let read = fs::File::open(path).and_then(|file| file.take(64).read_to_end(&mut beginning));
    let ends_in =
        |ends: &[&str]| path.extension().is_some_and(|end| ends.iter().any(|e| end == *e));
    // A text may begin with the letters of Windows.
    let is_of_windows = beginning.starts_with(b"MZ") && beginning.contains(&0);
    ends_in(&["pyc", "pyd", "so", "dll", "dylib"])
        || read.is_ok() && (is_of_windows || BEGINNINGS.iter().any(|b| beginning.starts_with(b)))
}
