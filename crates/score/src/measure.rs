//! Every number of a [`Scores`] under one name: what tables, thresholds and records use.

use crate::Scores;

/// What a measure counts in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Pixels of disparity.
    Pixels,
    /// A share from 0 to 1.
    Share,
}

/// A measure by its name: what it counts in, and how to find it in [`Scores`].
#[derive(Debug, Clone, Copy)]
pub struct Measure {
    /// The name, as in tables and thresholds.
    pub name: &'static str,
    /// Its unit.
    pub unit: Unit,
    find: fn(&Scores) -> (Option<f64>, Option<&str>),
}

/// Builds a row of the table: name, unit, and where the family and the number in it are.
macro_rules! measure {
    ($name:literal, $unit:ident, $family:ident, |$scores:ident| $value:expr) => {
        Measure {
            name: $name,
            unit: Unit::$unit,
            find: |scores| {
                let $scores = &scores.$family;
                ($value, Some(&$scores.protocol))
            },
        }
    };
}

impl Measure {
    /// Every measure, the course's two first, then family by family.
    pub const ALL: [Measure; 29] = [
        Measure {
            name: "E_RMS",
            unit: Unit::Pixels,
            find: |scores| {
                let course = scores.course.as_ref();
                (course.map(|c| c.e_rms), course.map(|c| c.protocol.as_str()))
            },
        },
        Measure {
            name: "p_bad",
            unit: Unit::Share,
            find: |scores| {
                let course = scores.course.as_ref();
                (course.map(|c| c.p_bad), course.map(|c| c.protocol.as_str()))
            },
        },
        measure!("bad0.5", Share, middlebury, |m| Some(m.bad[0].totbad)),
        measure!("bad1", Share, middlebury, |m| Some(m.bad[1].totbad)),
        measure!("bad2", Share, middlebury, |m| Some(m.bad[2].totbad)),
        measure!("bad4", Share, middlebury, |m| Some(m.bad[3].totbad)),
        measure!("bad0.5-est", Share, middlebury, |m| m.bad[0].of_estimates),
        measure!("bad1-est", Share, middlebury, |m| m.bad[1].of_estimates),
        measure!("bad2-est", Share, middlebury, |m| m.bad[2].of_estimates),
        measure!("bad4-est", Share, middlebury, |m| m.bad[3].of_estimates),
        measure!("avgerr", Pixels, middlebury, |m| m.avgerr),
        measure!("rms", Pixels, middlebury, |m| m.rms),
        measure!("A50", Pixels, middlebury, |m| m.a50),
        measure!("A90", Pixels, middlebury, |m| m.a90),
        measure!("A95", Pixels, middlebury, |m| m.a95),
        measure!("A99", Pixels, middlebury, |m| m.a99),
        measure!("density", Share, middlebury, |m| Some(m.density)),
        measure!("D1", Share, kitti, |k| Some(k.d1)),
        measure!("D1-est", Share, kitti, |k| k.d1_est),
        measure!("Out2", Share, kitti, |k| Some(k.out[0].share)),
        measure!("Out3", Share, kitti, |k| Some(k.out[1].share)),
        measure!("Out4", Share, kitti, |k| Some(k.out[2].share)),
        measure!("Out5", Share, kitti, |k| Some(k.out[3].share)),
        measure!("EPE", Pixels, end_point, |e| e.mean),
        measure!("median", Pixels, end_point, |e| e.median),
        measure!("bias", Pixels, end_point, |e| e.bias),
        measure!("subpixel-mean", Pixels, end_point, |e| e.sub_pixel.mean),
        measure!("subpixel-rms", Pixels, end_point, |e| e.sub_pixel.rms),
        measure!("subpixel-bias", Pixels, end_point, |e| e.sub_pixel.bias),
    ];

    /// The measure of this name, upper and lower case alike.
    pub fn named(name: &str) -> Option<Measure> {
        Self::ALL.into_iter().find(|measure| measure.name.eq_ignore_ascii_case(name))
    }

    /// The number; `None` when there is nothing to take it from (no estimate at all, or for the
    /// course's numbers no truth but zero).
    pub fn value(&self, scores: &Scores) -> Option<f64> {
        (self.find)(scores).0
    }

    /// The protocol of its family; `None` only together with the value.
    pub fn protocol<'a>(&self, scores: &'a Scores) -> Option<&'a str> {
        (self.find)(scores).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Region, evaluate};
    use raster::Plane;

    #[test]
    fn names_lead_to_the_numbers_and_their_protocols() {
        let truth = Plane::filled(2, 1, 5.0);
        let estimate = Plane::new(2, 1, vec![5.25, 9.0]).unwrap();
        let scores = evaluate(&estimate, &truth, &Region::whole()).unwrap();
        let value = |name| Measure::named(name).unwrap().value(&scores);
        assert_eq!(value("p_bad"), Some(0.5));
        assert_eq!(value("BAD4"), Some(0.0));
        assert_eq!(value("a50"), Some(0.25));
        assert_eq!(value("bias"), Some(4.25 / 2.0));
        assert_eq!(value("d1"), Some(0.5));
        assert!(Measure::named("D1").unwrap().protocol(&scores).unwrap().starts_with("KITTI"));
        assert!(Measure::named("psnr").is_none());
    }

    #[test]
    fn names_are_unique_whatever_their_case() {
        for (i, measure) in Measure::ALL.iter().enumerate() {
            let found = Measure::ALL.iter().position(|m| m.name.eq_ignore_ascii_case(measure.name));
            assert_eq!(found, Some(i));
        }
    }
}
