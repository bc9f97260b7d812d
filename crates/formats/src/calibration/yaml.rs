//! How OpenCV's and ROS's YAML is read.

use serde::de::DeserializeOwned;
use serde_saphyr::UserMessageFormatter;

use super::Entries;
use crate::FormatError;

/// Reads what is needed of a text; what else is in it does not matter.
pub(super) fn read<T: DeserializeOwned>(
    entries: &Entries<'_>,
    text: &str,
) -> Result<T, FormatError> {
    // What is not finite may stand elsewhere; no camera is made of it.
    let options = serde_saphyr::options! {
        non_finite_float_policy: serde_saphyr::NonFiniteFloatPolicy::PassThrough,
    };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let what = error.without_snippet().render_with_formatter(&UserMessageFormatter);
        let what = what.lines().next().unwrap_or_default();
        entries.fail(None, format!("the YAML cannot be read: {what}"))
    })
}
