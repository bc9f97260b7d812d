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
    use crate::{Evaluation, Region, evaluate};
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
    fn every_name_leads_to_its_own_number() {
        // Estimates are off by so much, all beside a truth of 40, but the first, whose truth the course does not know,
        // and the last two.
        let errors = [
            0.25, -0.25, 0.5, 0.5, 0.75, -1.0, 1.0, 1.25, 1.5, 1.75, -2.0, 2.5, 2.75, 3.25, -3.5,
            4.5, 5.0, -6.0, 20.0, 4.0,
        ];
        let mut truth = [[0.0].as_slice(), &[40.0; 17], &[100.0; 2]].concat();
        let mut estimate: Vec<f32> = truth.iter().zip(errors).map(|(t, e)| t + e).collect();
        // KITTI fills the holes with the last estimate, 104: off by 0, 2.5, 3.5, 4.5 and twice by 10.
        let holes = [104.0, 101.5, 100.5, 99.5, 94.0, 94.0];
        truth.extend(holes);
        estimate.extend([f32::NAN; 6]);
        let [truth, estimate] = [truth, estimate].map(|row| Plane::new(26, 1, row).unwrap());
        // For Middlebury the 120 beside 100 is 108, off by 8.
        let evaluation = Evaluation::new(&estimate, &truth).unwrap().clipped_to(Some(108.0));
        let scores = evaluation.scores(&Region::whole()).unwrap();

        let squares = |values: &[f32]| values.iter().map(|v| f64::from(v * v)).sum::<f64>();
        let all = squares(&errors);
        let expected = [
            ("E_RMS", Unit::Pixels, ((all - 0.0625 + squares(&holes)) / 25.0).sqrt()),
            ("p_bad", Unit::Share, 15.0 / 25.0),
            ("bad0.5", Unit::Share, 22.0 / 26.0),
            ("bad1", Unit::Share, 19.0 / 26.0),
            ("bad2", Unit::Share, 15.0 / 26.0),
            ("bad4", Unit::Share, 10.0 / 26.0),
            ("bad0.5-est", Unit::Share, 16.0 / 20.0),
            ("bad1-est", Unit::Share, 13.0 / 20.0),
            ("bad2-est", Unit::Share, 9.0 / 20.0),
            ("bad4-est", Unit::Share, 4.0 / 20.0),
            ("avgerr", Unit::Pixels, 50.25 / 20.0),
            ("rms", Unit::Pixels, ((all - 400.0 + 64.0) / 20.0).sqrt()),
            ("A50", Unit::Pixels, 1.75),
            ("A90", Unit::Pixels, 5.0),
            ("A95", Unit::Pixels, 6.0),
            ("A99", Unit::Pixels, 8.0),
            ("density", Unit::Share, 20.0 / 26.0),
            ("D1", Unit::Share, 8.0 / 26.0),
            ("D1-est", Unit::Share, 6.0 / 20.0),
            ("Out2", Unit::Share, 14.0 / 26.0),
            ("Out3", Unit::Share, 11.0 / 26.0),
            ("Out4", Unit::Share, 7.0 / 26.0),
            ("Out5", Unit::Share, 4.0 / 26.0),
            ("EPE", Unit::Pixels, 62.25 / 20.0),
            ("median", Unit::Pixels, 1.875),
            ("bias", Unit::Pixels, 36.75 / 20.0),
            ("subpixel-mean", Unit::Pixels, 4.25 / 7.0),
            ("subpixel-rms", Unit::Pixels, f64::sqrt(3.1875 / 7.0)),
            ("subpixel-bias", Unit::Pixels, 1.75 / 7.0),
        ];
        for (measure, (name, unit, number)) in Measure::ALL.into_iter().zip(expected) {
            let found = measure.value(&scores).unwrap();
            assert_eq!((measure.name, measure.unit), (name, unit));
            assert!((found - number).abs() < 1e-12, "{name} is {found}, not {number}");
            // A number of its own, or another one could stand in its place.
            let same = expected.iter().filter(|other| other.2 == number).count();
            assert_eq!(same, 1, "{name}");
        }
    }

    #[test]
    fn names_are_unique_whatever_their_case() {
        for (i, measure) in Measure::ALL.iter().enumerate() {
            let found = Measure::ALL.iter().position(|m| m.name.eq_ignore_ascii_case(measure.name));
            assert_eq!(found, Some(i));
        }
    }
}
