//! Chance for tests: the same numbers on every machine.

/// A generator with this state (a linear congruence; its upper bits are the good ones).
pub(crate) struct Chance(pub u32);

impl Chance {
    /// So many bits, at most 32.
    pub fn bits(&mut self, count: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> (32 - count)
    }

    /// A number below `end`.
    pub fn below(&mut self, end: u32) -> u32 {
        self.bits(16) % end
    }

    /// A number from 0 to below 1.
    pub fn share(&mut self) -> f32 {
        self.bits(24) as f32 / (1 << 24) as f32
    }
}
