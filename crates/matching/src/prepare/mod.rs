//! What matching costs are computed from: images whose rows agree, and what is made of them.

pub(crate) mod alignment;
pub(crate) mod census;
pub(crate) mod descriptor;
pub(crate) mod gradient;
pub(crate) mod grey;
mod histogram;
pub(crate) mod noise;
pub(crate) mod plain;
pub(crate) mod prefilter;
pub(crate) mod smoothing;
pub(crate) mod texture;

use raster::Plane;

/// Gives a plane its size; what stands in it does not matter.
pub(crate) fn take<T: Copy + Default>(plane: &mut Plane<T>, (columns, rows): (usize, usize)) {
    if plane.size() != (columns, rows) {
        // Zeros that nobody has written to yet take no memory.
        *plane = Plane::filled(columns, rows, T::default());
    }
}
