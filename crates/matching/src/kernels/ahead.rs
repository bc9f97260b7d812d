//! Memory that will be wanted soon is asked for ahead of time.
//!
//! Processors see by themselves what comes next where memory is read from lower to higher places, until a
//! page ends. What is read backwards, or only seldom between much else, they wait for.

/// Asks for the cache line of a byte. Only time tells whether it was.
#[inline(always)]
pub(crate) fn read(byte: &u8) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 processor has the instruction, which may name any address and changes nothing.
        #[allow(unsafe_code)]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(byte).cast())
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = byte;
}
