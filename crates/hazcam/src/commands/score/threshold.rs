//! `--fail-over MEASURE=VALUE`, and the limits of `hazcam bench`.

use arena::report::shown_until;
use std::str::FromStr;

use score::{Measure, Scores, Unit};

/// A measure that must not be over a value.
#[derive(Debug, Clone)]
pub struct Threshold {
    measure: Measure,
    value: f64,
}

/// Measures that are better when small; the density is not.
fn comparable() -> impl Iterator<Item = Measure> {
    Measure::ALL.into_iter().filter(|measure| measure.name != "density")
}

impl FromStr for Threshold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) =
            text.split_once('=').ok_or("give MEASURE=VALUE, for example p_bad=0.05")?;
        let measure = named(name)?;
        let (number, scale) = match (value.strip_suffix('%'), measure.unit) {
            (Some(number), Unit::Share) => (number, 0.01),
            (Some(_), Unit::Pixels) => {
                return Err(format!("{} is in pixels, not in per cent", measure.name));
            }
            (None, _) => (value, 1.0),
        };
        let number = number.parse::<f64>().map_or(f64::NAN, |number| number * scale);
        Self::checked(measure, number, value)
    }
}

/// The measure of a name.
fn named(name: &str) -> Result<Measure, String> {
    comparable().find(|measure| measure.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
        let names: Vec<_> = comparable().map(|measure| measure.name).collect();
        format!("`{name}` is no measure; the measures are {}", names.join(", "))
    })
}

impl Threshold {
    /// Of a measure by its name, in pixels or as a share.
    pub fn new(name: &str, value: f64) -> Result<Self, String> {
        Self::checked(named(name)?, value, &value.to_string())
    }

    /// With a value that was given in these words.
    fn checked(measure: Measure, value: f64, said: &str) -> Result<Self, String> {
        // It would never be exceeded.
        if value > 1.0 && measure.unit == Unit::Share {
            return Err(format!(
                "{} is a share, and `{said}` is more than all: give 0 to 1, or per cent as 5% (in a file \"5%\")",
                measure.name
            ));
        }
        if !(value.is_finite() && value >= 0.0) {
            return Err(format!("`{said}` is no threshold: give a number, 0 or more"));
        }
        Ok(Self { measure, value })
    }

    /// The measure's name.
    pub fn measure(&self) -> &'static str {
        self.measure.name
    }

    /// What to say when the score is over the threshold. A bias counts by its size, and a measure
    /// that has no value counts as over: nothing was answered.
    pub fn exceeded_by(&self, scores: &Scores) -> Option<String> {
        self.exceeded(self.measure.value(scores))
    }

    /// The same of the measure's value.
    pub fn exceeded(&self, value: Option<f64>) -> Option<String> {
        let name = self.measure.name;
        match value {
            None => Some(format!("{name} has no value, but must not be over {}", self.value)),
            Some(value) if value.abs() > self.value => {
                let shown = shown_until(value, 4, |shown| shown.abs() > self.value);
                Some(format!("{name} is {shown}, over {}", self.value))
            }
            Some(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use raster::Plane;
    use score::{Region, evaluate};

    #[test]
    fn thresholds_are_shares_or_per_cent() {
        assert_eq!("p_bad=0.05".parse::<Threshold>().unwrap().value, 0.05);
        assert_eq!("d1=6%".parse::<Threshold>().unwrap().value, 0.06);
        assert_eq!("d1=100%".parse::<Threshold>().unwrap().value, 1.0);
        for (text, expected) in [
            ("p_bad", "MEASURE=VALUE"),
            ("psnr=3", "E_RMS, p_bad, bad0.5"),
            ("E_RMS=3%", "in pixels"),
            ("p_bad=-1", "0 or more"),
            ("p_bad=x", "`x`"),
            ("bad2=5", "bad2 is a share, and `5` is more than all: give 0 to 1, or per cent as 5%"),
            ("p_bad=101%", "`101%` is more than all"),
            ("p_bad=inf", "more than all"),
            ("E_RMS=inf", "0 or more"),
            ("density=0.5", "no measure"),
        ] {
            let error = text.parse::<Threshold>().unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn only_what_is_over_fails() {
        let (estimate, truth) = (Plane::filled(1, 1, 4.0), Plane::filled(1, 1, 5.0));
        let scores = evaluate(&estimate, &truth, &Region::whole()).unwrap();
        let over = |text: &str| text.parse::<Threshold>().unwrap().exceeded_by(&scores);
        assert_eq!(over("E_RMS=1"), None);
        assert_eq!(over("E_RMS=0.5"), Some("E_RMS is 1.0000, over 0.5".into()));
        assert!(over("bias=0.5").is_some(), "a negative bias counts by its size");

        let nothing = Plane::filled(1, 1, f32::NAN);
        let scores = evaluate(&nothing, &truth, &Region::whole()).unwrap();
        let threshold: Threshold = "avgerr=9".parse().unwrap();
        assert!(threshold.exceeded_by(&scores).unwrap().contains("no value"));
    }
}
