//! The elements of an array: from bytes, to bytes, and from Fortran to C order.

use std::io::{self, Write};

use half::f16;

use super::Dtype;

mod sealed {
    pub trait Sealed {}
}

/// What a [`raster::Plane`] may hold to be read from or written to `.npy`: `u8`, `u16`, `i32`,
/// `f32`, `f64`, and the colours `[u8; 3]`, `[u16; 3]` and `[f32; 3]`.
pub trait Element: sealed::Sealed + Copy {
    /// The type of its samples.
    const DTYPE: Dtype;
    /// Samples a pixel: 1, or 3 for a colour.
    const CHANNELS: usize;
    /// Takes the samples as pixels; `None` when they are of another type.
    fn from_samples(samples: Samples) -> Option<Vec<Self>>;
    /// Writes pixels as little-endian bytes.
    fn write_all(pixels: &[Self], writer: &mut dyn Write) -> io::Result<()>;
}

macro_rules! samples {
    ($($variant:ident($type:ty)),+) => {
        /// The elements of an array, by type.
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub enum Samples {
            /// Truth values; any byte but 0 is true.
            Bool(Vec<bool>),
            /// Elements of 16 bits with a point.
            Float16(Vec<f16>),
            $(
                #[doc = concat!("Elements of type `", stringify!($type), "`.")]
                $variant(Vec<$type>),
            )+
        }

        impl Samples {
            /// The type of the elements.
            pub fn dtype(&self) -> Dtype {
                match self {
                    Self::Bool(_) => Dtype::Bool,
                    Self::Float16(_) => Dtype::Float16,
                    $(Self::$variant(_) => Dtype::$variant,)+
                }
            }

            /// Reads the elements; `bytes` must be a whole number of them.
            pub(super) fn from_bytes(dtype: Dtype, big_endian: bool, bytes: &[u8]) -> Self {
                let pairs = bytes.as_chunks().0.iter();
                match dtype {
                    Dtype::Float16 => Self::Float16(match big_endian {
                        true => pairs.map(|&c| f16::from_be_bytes(c)).collect(),
                        false => pairs.map(|&c| f16::from_le_bytes(c)).collect(),
                    }),
                    Dtype::Bool => Self::Bool(bytes.iter().map(|&b| b != 0).collect()),
                    $(Dtype::$variant => {
                        let chunks = bytes.as_chunks().0.iter();
                        Self::$variant(match big_endian {
                            true => chunks.map(|&c| <$type>::from_be_bytes(c)).collect(),
                            false => chunks.map(|&c| <$type>::from_le_bytes(c)).collect(),
                        })
                    })+
                }
            }

            /// Reorders elements whose first index runs fastest.
            pub(super) fn fortran_to_c(self, shape: &[usize]) -> Self {
                match self {
                    Self::Bool(v) => Self::Bool(reorder(&v, shape)),
                    Self::Float16(v) => Self::Float16(reorder(&v, shape)),
                    $(Self::$variant(v) => Self::$variant(reorder(&v, shape)),)+
                }
            }

            /// The elements as `f64` (64-bit integers past 2^53 are rounded), without memory for all of them.
            pub fn values(&self) -> Box<dyn Iterator<Item = f64> + '_> {
                match self {
                    Self::Bool(v) => Box::new(v.iter().map(|&v| f64::from(u8::from(v)))),
                    Self::Float16(v) => Box::new(v.iter().map(|&v| v.to_f64())),
                    $(Self::$variant(v) => Box::new(v.iter().map(|&v| v as f64)),)+
                }
            }

            /// The same in memory.
            pub fn to_f64(&self) -> Vec<f64> {
                self.values().collect()
            }
        }
    };
}

samples!(
    Uint8(u8),
    Int8(i8),
    Uint16(u16),
    Int16(i16),
    Uint32(u32),
    Int32(i32),
    Uint64(u64),
    Int64(i64),
    Float32(f32),
    Float64(f64)
);

/// Walks the shape as an odometer whose last wheel turns fastest, keeping the Fortran position.
fn reorder<T: Copy>(from: &[T], shape: &[usize]) -> Vec<T> {
    let strides: Vec<usize> = shape
        .iter()
        .scan(1, |stride, &side| {
            let this = *stride;
            *stride *= side;
            Some(this)
        })
        .collect();
    let mut index = vec![0; shape.len()];
    let mut at = 0;
    let mut to = Vec::with_capacity(from.len());
    while to.len() < from.len() {
        to.push(from[at]);
        for axis in (0..shape.len()).rev() {
            index[axis] += 1;
            at += strides[axis];
            if index[axis] < shape[axis] {
                break;
            }
            at -= strides[axis] * shape[axis];
            index[axis] = 0;
        }
    }
    to
}

macro_rules! element {
    ($type:ty, $variant:ident) => {
        impl sealed::Sealed for $type {}

        impl Element for $type {
            const DTYPE: Dtype = Dtype::$variant;
            const CHANNELS: usize = 1;

            fn from_samples(samples: Samples) -> Option<Vec<Self>> {
                match samples {
                    Samples::$variant(samples) => Some(samples),
                    _ => None,
                }
            }

            fn write_all(pixels: &[Self], writer: &mut dyn Write) -> io::Result<()> {
                let mut bytes = Vec::new();
                for block in pixels.chunks(1 << 14) {
                    bytes.clear();
                    bytes.extend(block.iter().flat_map(|pixel| pixel.to_le_bytes()));
                    writer.write_all(&bytes)?;
                }
                Ok(())
            }
        }
    };
}

macro_rules! colour_element {
    ($type:ty) => {
        impl sealed::Sealed for [$type; 3] {}

        impl Element for [$type; 3] {
            const DTYPE: Dtype = <$type as Element>::DTYPE;
            const CHANNELS: usize = 3;

            fn from_samples(samples: Samples) -> Option<Vec<Self>> {
                Some(<$type>::from_samples(samples)?.as_chunks().0.to_vec())
            }

            fn write_all(pixels: &[Self], writer: &mut dyn Write) -> io::Result<()> {
                <$type>::write_all(pixels.as_flattened(), writer)
            }
        }
    };
}

element!(u8, Uint8);
element!(u16, Uint16);
element!(i32, Int32);
element!(f32, Float32);
element!(f64, Float64);
colour_element!(u8);
colour_element!(u16);
colour_element!(f32);
