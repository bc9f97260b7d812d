//! How long work is done: while other Python threads run, and without a panic getting out.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;

use crate::errors::HazcamError;

/// Does `work` without the interpreter's lock. A panic, which is an error of hazcam's own, becomes an
/// exception that `except Exception` catches; what `work` changes must be fit for use after one.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|_| {
        HazcamError::new_err(
            "an error in hazcam itself, and not in what it was given; please report it with the \
             images and the lines that begin with `thread` on standard error",
        )
    })
}
