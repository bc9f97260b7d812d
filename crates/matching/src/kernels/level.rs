//! Which instructions the processor has, and how a kernel is compiled once for each set of them.
//!
//! Kernels are plain loops over slices and fixed-length arrays that the compiler turns into vector
//! code. [`at_every_level!`] compiles such a body once per [`Level`] and gives one safe entry that
//! takes the level as its first argument. A [`Level`] can only be had from [`Level::detect`],
//! [`Level::available`] or [`Level::chosen`], all of which ask the processor, so holding one is
//! proof that its instructions exist: this is the argument for `unsafe` in that macro, which the values
//! in `products.rs` pass on.
//!
//! Where no plain loop expresses what vectors can do, [`with_vectors!`] gives those of `fearless_simd`, which
//! also says which levels there are.

use std::ffi::OsStr;
use std::fmt;
use std::sync::OnceLock;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Set {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Sse42,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

/// A set of vector instructions that this processor is known to have.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Level(Set);

impl fmt::Debug for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Level {
    /// Every level that this processor has, the plainest first.
    pub fn available() -> Vec<Level> {
        let mut levels = vec![Level(Set::Scalar)];
        let best = fearless_simd::Level::new();
        #[cfg(target_arch = "x86_64")]
        for (has, set) in [
            (best.as_sse4_2().is_some(), Set::Sse42),
            (best.as_avx2().is_some(), Set::Avx2),
            (best.as_avx512().is_some(), Set::Avx512),
        ] {
            if has {
                levels.push(Level(set));
            }
        }
        #[cfg(target_arch = "aarch64")]
        if best.as_neon().is_some() {
            levels.push(Level(Set::Neon));
        }
        levels
    }

    /// The best level of this processor.
    pub fn detect() -> Level {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| *Level::available().last().expect("scalar is always there"))
    }

    /// The level that the environment variable `HAZCAM_CPU` names, or the best one where it is not set or empty.
    ///
    /// # Errors
    ///
    /// When it names none that this processor has; the error says which there are.
    pub fn chosen() -> Result<Level, crate::MatchError> {
        let named = std::env::var_os("HAZCAM_CPU").filter(|name| !name.is_empty());
        named.map_or(Ok(Level::detect()), |name| Level::named(&name))
    }

    /// The level of this name.
    fn named(name: &OsStr) -> Result<Level, crate::MatchError> {
        let levels = Level::available();
        levels.iter().find(|level| level.name() == name).copied().ok_or_else(|| {
            let names: Vec<_> = levels.iter().map(|level| level.name()).collect();
            crate::MatchError::Option {
                field: "HAZCAM_CPU",
                value: format!("`{}`", name.display()),
                allowed: format!(
                    "this processor has {}: set one of these, or none for the best",
                    names.join(", ")
                ),
            }
        })
    }

    /// The name used by `HAZCAM_CPU` and in reports.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Scalar => "scalar",
            #[cfg(target_arch = "x86_64")]
            Set::Sse42 => "sse4.2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            Set::Neon => "neon",
        }
    }

    /// The level with vectors of 32 bytes where this one has 64: for kernels that load most of them across two cache
    /// lines.
    pub(crate) fn of_32_bytes(self) -> Self {
        match self.0 {
            // Every processor with AVX-512 has AVX2.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => Self(Set::Avx2),
            _ => self,
        }
    }

    pub(crate) fn set(self) -> Set {
        self.0
    }
}

/// Defines functions whose first argument is a [`Level`] and whose body is compiled once for every
/// level. Everything the body calls must be `#[inline(always)]` to be compiled along with it. A body
/// that names something in brackets after the function's name gets the level's
/// [`Products`](super::products::Products) by that name.
macro_rules! at_every_level {
    ($(
        $(#[$meta:meta])*
        $vis:vis fn $name:ident $(<$(const $g:ident : $gt:ty),+>)? $([$products:ident])? ($($arg:ident : $ty:ty),* $(,)?) $(-> $ret:ty)? $body:block
    )*) => {$(
        $(#[$meta])*
        #[allow(unsafe_code, clippy::too_many_arguments)]
        $vis fn $name $(<$(const $g: $gt),+>)? (level: $crate::kernels::level::Level, $($arg: $ty),*) $(-> $ret)? {
            #[inline(always)]
            #[allow(clippy::too_many_arguments)]
            fn body $(<$(const $g: $gt),+>)? (
                $($products: impl $crate::kernels::products::Products,)?
                $($arg: $ty),*
            ) $(-> $ret)? $body

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "sse4.2,popcnt")]
            #[allow(clippy::too_many_arguments)]
            fn sse42 $(<$(const $g: $gt),+>)? ($($arg: $ty),*) $(-> $ret)? {
                body $(::<$($g),+>)? ($($crate::kernels::level::products_at!(Baseline, $products),)? $($arg),*)
            }

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,bmi1,bmi2,fma,lzcnt,popcnt")]
            #[allow(clippy::too_many_arguments)]
            fn avx2 $(<$(const $g: $gt),+>)? ($($arg: $ty),*) $(-> $ret)? {
                body $(::<$($g),+>)? ($($crate::kernels::level::products_at!(Avx2, $products),)? $($arg),*)
            }

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2,bmi1,bmi2,fma,lzcnt,popcnt,avx512f,avx512bw,avx512cd,avx512dq,avx512vl,avx512vbmi,avx512vnni,avx512bitalg,avx512vpopcntdq")]
            #[allow(clippy::too_many_arguments)]
            fn avx512 $(<$(const $g: $gt),+>)? ($($arg: $ty),*) $(-> $ret)? {
                body $(::<$($g),+>)? ($($crate::kernels::level::products_at!(Avx512, $products),)? $($arg),*)
            }

            #[cfg(target_arch = "aarch64")]
            #[target_feature(enable = "neon")]
            #[allow(clippy::too_many_arguments)]
            fn neon $(<$(const $g: $gt),+>)? ($($arg: $ty),*) $(-> $ret)? {
                body $(::<$($g),+>)? ($($crate::kernels::level::products_at!(Baseline, $products),)? $($arg),*)
            }

            // SAFETY: a `Level` exists only where the processor was asked and has its features.
            match level.set() {
                $crate::kernels::level::Set::Scalar => body $(::<$($g),+>)? ($($crate::kernels::level::products_at!(Baseline, $products),)? $($arg),*),
                #[cfg(target_arch = "x86_64")]
                $crate::kernels::level::Set::Sse42 => unsafe { sse42 $(::<$($g),+>)? ($($arg),*) },
                #[cfg(target_arch = "x86_64")]
                $crate::kernels::level::Set::Avx2 => unsafe { avx2 $(::<$($g),+>)? ($($arg),*) },
                #[cfg(target_arch = "x86_64")]
                $crate::kernels::level::Set::Avx512 => unsafe { avx512 $(::<$($g),+>)? ($($arg),*) },
                #[cfg(target_arch = "aarch64")]
                $crate::kernels::level::Set::Neon => unsafe { neon $(::<$($g),+>)? ($($arg),*) },
            }
        }
    )*};
}
pub(crate) use at_every_level;

/// Evaluates an expression that is compiled once for every level, with the vectors of the level by a name: a
/// token of `fearless_simd`, for what no plain loop expresses. Everything that the expression calls must be
/// `#[inline(always)]` to be compiled along with it.
macro_rules! with_vectors {
    ($level:expr, $simd:ident => $value:expr) => {
        $crate::kernels::level::with_vectors!(@ $level, $simd => $value;
            Scalar, "x86_64", as_sse2; Sse42, "x86_64", as_sse4_2; Avx2, "x86_64", as_avx2; Avx512, "x86_64", as_avx512;
            Scalar, "aarch64", as_neon; Neon, "aarch64", as_neon;
        )
    };
    (@ $level:expr, $simd:ident => $value:expr; $($set:ident, $arch:literal, $token:ident;)*) => {{
        use fearless_simd::Simd as _;
        match $level.set() {
            $(#[cfg(target_arch = $arch)]
            $crate::kernels::level::Set::$set => {
                let $simd = fearless_simd::Level::new().$token().expect("levels are where it finds them");
                $simd.vectorize(#[inline(always)] || $value)
            })*
            #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
            $crate::kernels::level::Set::Scalar => {
                let $simd = fearless_simd::Fallback::new();
                $simd.vectorize(#[inline(always)] || $value)
            }
        }
    }};
}
pub(crate) use with_vectors;

/// What multiplies at a level, for a body that asked for it by a name.
macro_rules! products_at {
    ($level:ident, $products:ident) => {
        // SAFETY: it is made where the instructions of the level are enabled.
        unsafe { $crate::kernels::products::$level::new() }
    };
}
pub(crate) use products_at;

#[cfg(test)]
mod tests {
    use super::*;

    at_every_level! {
        /// Adds up bytes.
        fn sum<const N: usize>(samples: &[u8; N], start: u32) -> u32 {
            samples.iter().fold(start, |s, &v| s + u32::from(v))
        }
    }

    #[test]
    fn a_kernel_runs_at_every_level_that_the_machine_has() {
        for level in Level::available() {
            eprintln!("level {}", level.name());
            assert_eq!(sum(level, &[1u8; 100], 3), 103);
        }
    }

    #[test]
    fn levels_are_ordered_and_the_best_is_the_last() {
        let levels = Level::available();
        assert!(levels.is_sorted());
        assert_eq!(Some(&Level::detect()), levels.last());
    }

    #[test]
    fn a_level_is_found_by_its_name_and_no_other() {
        for level in Level::available() {
            assert_eq!(Level::named(level.name().as_ref()), Ok(level));
        }
        let error = Level::named("abacus".as_ref()).unwrap_err().to_string();
        let expected = "option `HAZCAM_CPU` is `abacus`, but this processor has scalar";
        assert!(error.starts_with(expected), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_name_that_is_no_text_is_no_level() {
        use std::os::unix::ffi::OsStrExt;
        let error = Level::named(OsStr::from_bytes(b"avx2\xff")).unwrap_err().to_string();
        assert!(error.starts_with("option `HAZCAM_CPU` is `avx2\u{fffd}`, but "), "{error}");
    }
}
