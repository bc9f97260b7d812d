//! What must be quick. One file per kernel: the scalar definition, the body that the compiler
//! vectorises (in eight of them, the vectors themselves), and the test that they agree bit for bit at
//! every level of the processor.

pub(crate) mod ahead;
pub(crate) mod aligned;
pub(crate) mod bits;
pub(crate) mod border;
pub(crate) mod cubic;
pub(crate) mod every;
pub mod level;
pub(crate) mod look_up;
pub(crate) mod median;
pub(crate) mod nearness;
pub(crate) mod neurons;
pub(crate) mod path;
pub(crate) mod products;
pub(crate) mod records;
pub(crate) mod rounding;
pub(crate) mod sad;
pub(crate) mod stripes;
pub(crate) mod unlike;
