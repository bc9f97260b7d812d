//! Paths in records.

use std::path::Path;

use serde::Serializer;

/// For serde's `serialize_with`: a path as text. What is not UTF-8 in it becomes `U+FFFD`, as it is
/// shown in messages; serde itself gives up there, with an error that names no file.
pub fn path_as_text<S: Serializer>(path: &impl AsRef<Path>, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(&path.as_ref().display())
}
