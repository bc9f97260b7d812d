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

/// One number with its name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// The name, as in tables and after `--fail-over`.
    pub name: &'static str,
    /// The number; `None` when there is nothing to take it from.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Unit,
    /// Whether a larger number is better (only for the density).
    pub larger_is_better: bool,
}

impl Scores {
    /// Every number, the course's two first. The names do not depend on the scores.
    pub fn measures(&self) -> Vec<Measure> {
        use Unit::{Pixels, Share};
        let (course, community) = (self.course.as_ref(), &self.middlebury);
        let [half, one, two, four] = community.bad.map(|bad| Some(bad.totbad));
        let sub_pixel = &self.end_point.sub_pixel;
        [
            ("e_rms", course.map(|course| course.e_rms), Pixels),
            ("p_bad", course.map(|course| course.p_bad), Share),
            ("bad0.5", half, Share),
            ("bad1", one, Share),
            ("bad2", two, Share),
            ("bad4", four, Share),
            ("avgerr", community.avgerr, Pixels),
            ("rms", community.rms, Pixels),
            ("a50", community.a50, Pixels),
            ("a90", community.a90, Pixels),
            ("a95", community.a95, Pixels),
            ("a99", community.a99, Pixels),
            ("d1", Some(self.kitti.d1), Share),
            ("d1_est", self.kitti.d1_est, Share),
            ("epe", self.end_point.mean, Pixels),
            ("median", self.end_point.median, Pixels),
            ("bias", self.end_point.bias, Pixels),
            ("subpixel_mean", sub_pixel.mean, Pixels),
            ("subpixel_rms", sub_pixel.rms, Pixels),
            ("subpixel_bias", sub_pixel.bias, Pixels),
            ("density", Some(community.density), Share),
        ]
        .map(|(name, value, unit)| Measure {
            name,
            value,
            unit,
            larger_is_better: name == "density",
        })
        .into()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Region, evaluate};
    use raster::Plane;

    #[test]
    fn names_are_unique_and_lead_to_the_numbers() {
        let truth = Plane::filled(2, 1, 5.0);
        let estimate = Plane::new(2, 1, vec![5.25, 9.0]).unwrap();
        let scores = evaluate(&estimate, &truth, &Region::whole()).unwrap();
        let measures = scores.measures();
        let find = |name| measures.iter().find(|m| m.name == name).and_then(|m| m.value);
        assert_eq!(find("p_bad"), Some(0.5));
        assert_eq!(find("bad4"), Some(0.0));
        assert_eq!(find("a50"), Some(0.25));
        assert_eq!(find("bias"), Some(4.25 / 2.0));
        let mut names: Vec<_> = measures.iter().map(|m| m.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), measures.len());
    }
}
