//! What a matcher answers: per pixel a disparity, the reason for it, and how sure it is.

use std::fmt;

use crate::{BoundingBox, Plane};

/// Why a pixel has the value it has, or none. Stored as one byte per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Reason {
    /// Outside the box that was asked for: no value.
    #[default]
    OutsideBox = 0,
    /// Found in the right image and confirmed by every check that the matcher makes. `x - d` lies inside it. Where
    /// not all pixels are matched themselves (`balanced`), the nearest one was that is.
    Matched = 1,
    /// Seen by the left camera only (hidden by something nearer in the right image); filled from
    /// the background.
    OccludedFilled = 2,
    /// The match was wrong or ambiguous; filled from its surroundings.
    MismatchedFilled = 3,
    /// The match lies outside the right image, of so many columns: `x - d` is below -0.5 or above
    /// `columns - 0.5`. Extrapolated from where both cameras see.
    OutsideRightFilled = 4,
    /// As [`Reason::OccludedFilled`], but left without a value because holes were asked for.
    OccludedHole = 5,
    /// As [`Reason::MismatchedFilled`], but left without a value because holes were asked for.
    MismatchedHole = 6,
    /// As [`Reason::OutsideRightFilled`], but left without a value because holes were asked for.
    OutsideRightHole = 7,
}

impl Reason {
    /// Every reason, in the order of its byte.
    pub const ALL: [Reason; 8] = [
        Reason::OutsideBox,
        Reason::Matched,
        Reason::OccludedFilled,
        Reason::MismatchedFilled,
        Reason::OutsideRightFilled,
        Reason::OccludedHole,
        Reason::MismatchedHole,
        Reason::OutsideRightHole,
    ];

    /// A name for tables and files, in lower case with hyphens.
    pub fn name(self) -> &'static str {
        match self {
            Self::OutsideBox => "outside-box",
            Self::Matched => "matched",
            Self::OccludedFilled => "occluded-filled",
            Self::MismatchedFilled => "mismatched-filled",
            Self::OutsideRightFilled => "outside-right-filled",
            Self::OccludedHole => "occluded-hole",
            Self::MismatchedHole => "mismatched-hole",
            Self::OutsideRightHole => "outside-right-hole",
        }
    }

    /// The reason with this byte, or `None`.
    pub fn from_byte(byte: u8) -> Option<Self> {
        Self::ALL.get(usize::from(byte)).copied()
    }

    /// Whether a pixel with this reason has a value.
    pub fn has_value(self) -> bool {
        matches!(
            self,
            Self::Matched
                | Self::OccludedFilled
                | Self::MismatchedFilled
                | Self::OutsideRightFilled
        )
    }
}

/// Its [name](Reason::name).
impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A disparity per pixel of the left image, with its reason and confidence. All planes have the
/// size of the left image.
///
/// Where a pixel has no value it is NaN, which equals nothing: a map with such pixels is not `==` to itself.
/// Compare the bits of its values ([`f32::to_bits`]).
#[derive(Debug, PartialEq, Default)]
pub struct DisparityMap {
    /// Disparity in pixels, `x_right = x_left - d`; NaN exactly where the reason has no value. All of a matcher's,
    /// filled ones too, lie within the range that was asked for.
    pub values: Plane<f32>,
    /// Why the pixel has this value or none.
    pub reasons: Plane<Reason>,
    /// How sure the value is, 0 (a guess) to 1; 0 where there is no value. It ranks pixels and is no
    /// probability: `hazcam bench --reliability` tells how many are wrong from which value on. What is filled, and what
    /// lies within half a pixel of an end of the range, has [`DisparityMap::MOST_OF_A_GUESS`] at the most, in `fast` 0 or
    /// next to it.
    pub confidence: Plane<f32>,
}

/// [`Clone::clone_from`] keeps the memory of a map that is large enough: so answers go to other threads without any
/// allocation.
impl Clone for DisparityMap {
    fn clone(&self) -> Self {
        let Self { values, reasons, confidence } = self;
        Self { values: values.clone(), reasons: reasons.clone(), confidence: confidence.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.values.clone_from(&source.values);
        self.reasons.clone_from(&source.reasons);
        self.confidence.clone_from(&source.confidence);
    }
}

impl DisparityMap {
    /// No matcher is surer of what was filled in without a match.
    pub const MOST_OF_A_GUESS: f32 = 0.05;

    /// A map without any value.
    pub fn empty(columns: usize, rows: usize) -> Self {
        Self {
            values: Plane::filled(columns, rows, f32::NAN),
            reasons: Plane::filled(columns, rows, Reason::OutsideBox),
            confidence: Plane::filled(columns, rows, 0.0),
        }
    }

    /// The values that are at least so sure, NaN where none is: what depth is to be made of. With 0.1 all guesses are left
    /// out, see [`DisparityMap::MOST_OF_A_GUESS`].
    ///
    /// # Panics
    ///
    /// If the two planes differ in size.
    pub fn surer_than(&self, min_confidence: f32) -> Plane<f32> {
        assert_eq!(self.values.size(), self.confidence.size(), "planes of a map are of one size");
        let mut values = self.values.clone();
        for (value, &confidence) in values.samples_mut().iter_mut().zip(self.confidence.samples()) {
            // Nothing is known of a confidence that is no number.
            let is_sure = confidence >= min_confidence;
            if !is_sure {
                *value = f32::NAN;
            }
        }
        values
    }

    /// As [`DisparityMap::empty`], reusing the memory of this map, for someone who writes every pixel
    /// of a box: what stands there is left as it is, whatever it meant.
    pub fn reshape(&mut self, columns: usize, rows: usize, bounds: BoundingBox) {
        self.values.reshape(columns, rows, f32::NAN);
        self.reasons.reshape(columns, rows, Reason::OutsideBox);
        self.confidence.reshape(columns, rows, 0.0);
        self.empty_around(bounds);
    }

    /// Takes what stands around a box out of the map.
    pub fn empty_around(&mut self, bounds: BoundingBox) {
        self.values.fill_around(bounds, f32::NAN);
        self.reasons.fill_around(bounds, Reason::OutsideBox);
        self.confidence.fill_around(bounds, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_survive_their_byte() {
        for reason in Reason::ALL {
            assert_eq!(Reason::from_byte(reason as u8), Some(reason));
        }
        assert_eq!(Reason::from_byte(8), None);
    }

    #[test]
    fn what_is_matched_or_filled_has_a_value() {
        let with_value = Reason::ALL.map(Reason::has_value);
        assert_eq!(with_value, [false, true, true, true, true, false, false, false]);
    }

    #[test]
    fn around_a_box_a_map_is_empty_in_all_its_planes() {
        let mut map = DisparityMap {
            values: Plane::filled(3, 1, 7.0),
            reasons: Plane::filled(3, 1, Reason::Matched),
            confidence: Plane::filled(3, 1, 0.5),
        };
        map.empty_around(BoundingBox::new(1, 0, 1, 0).unwrap());
        let without_value = map.values.map(|value| value.is_nan());
        assert_eq!(
            (without_value.samples(), map.values.row(0)[1]),
            (&[true, false, true][..], 7.0)
        );
        let [outside, matched] = [Reason::OutsideBox, Reason::Matched];
        assert_eq!(map.reasons.samples(), [outside, matched, outside]);
        assert_eq!(map.confidence.samples(), [0.0, 0.5, 0.0]);
    }

    #[test]
    fn what_is_less_sure_is_left_out() {
        let map = DisparityMap {
            values: Plane::new(3, 1, vec![7.0, 8.0, f32::NAN]).unwrap(),
            reasons: Plane::filled(3, 1, Reason::Matched),
            confidence: Plane::new(3, 1, vec![0.5, 0.4, 0.0]).unwrap(),
        };
        let bits = |values: Plane<f32>| values.map(|value| value.to_bits()).into_samples();
        let nan = f32::NAN.to_bits();
        assert_eq!(bits(map.surer_than(0.5)), [7f32.to_bits(), nan, nan]);
        assert_eq!(bits(map.surer_than(0.0)), bits(map.values.clone()));
        let mut copy = DisparityMap::empty(5, 5);
        copy.clone_from(&map);
        assert_eq!((copy.reasons, copy.confidence), (map.reasons, map.confidence));
    }

    #[test]
    fn an_empty_map_holds_no_value() {
        let map = DisparityMap::empty(2, 2);
        assert!(map.values.samples().iter().all(|v| v.is_nan()));
        assert!(map.reasons.samples().iter().all(|r| !r.has_value()));
    }
}
