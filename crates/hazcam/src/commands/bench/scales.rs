//! Whether truths and answers of a run seem to be read at the scale that they were written with.

use std::collections::BTreeMap;

use arena::dataset::{Case, CaseData, Purpose, RANGE_BY_TRUTH};
use arena::engine::Answer;
use arena::record::Record;
use raster::Plane;
use score::{Pixels, Region, suspected_scale};

/// Narrower images say nothing: hardly anything in them is matched.
const NARROW: usize = 64;
/// A truth no part of which comes to more was hardly meant so.
const NEAR_NOTHING: i32 = 2;

/// What was suspected, as it went on.
#[derive(Default)]
pub struct Scales {
    /// By engine, for each scene that it answered: the scene and the factor that was suspected.
    engines: BTreeMap<String, Vec<(String, Option<f64>)>>,
    /// Scenes whose range is that of a truth near nothing, with its end.
    flat: Vec<(String, i32)>,
}

impl Scales {
    /// Looks at an answer.
    pub fn look_at(
        &mut self,
        case: &Case,
        data: &CaseData,
        record: &Record,
        answer: Option<&Answer>,
    ) {
        // What is rendered has the scale that it has.
        if case.purpose == Purpose::Rendered || data.left.columns() < NARROW {
            return;
        }
        let is_by_truth = data.protocol.iter().any(|line| line == RANGE_BY_TRUTH);
        let is_known = self.flat.last().is_some_and(|(id, _)| *id == case.id);
        if is_by_truth && data.range.max() < NEAR_NOTHING && data.range.min() == 0 && !is_known {
            self.flat.push((case.id.clone(), data.range.max()));
        }
        let (Some(truth), Some(answer)) = (&data.truth, answer) else { return };
        let factor = suspected(&answer.disparity, truth, data);
        let of_engine = self.engines.entry(record.engine.clone()).or_default();
        of_engine.push((case.id.clone(), factor));
    }

    /// What to warn of, a line each.
    pub fn told(&self) -> Vec<String> {
        let mut told: Vec<String> = (self.flat.iter())
            .map(|(scene, end)| {
                format!(
                    "{scene}: no true disparity is larger than {end}, and no further was searched: is that the truth's \
                     scale? (KITTI's PNG holds 256ths, catalogues name it as \"truth_encoding\")"
                )
            })
            .collect();
        // By scene, and by factor as a text, since floats have no order.
        let mut of_scenes: BTreeMap<(&str, String), Vec<&str>> = BTreeMap::new();
        for (engine, answers) in &self.engines {
            let suspected: Vec<(&str, f64)> =
                answers.iter().filter_map(|(scene, factor)| Some((&**scene, (*factor)?))).collect();
            let Some(&(_, factor)) = suspected.first() else { continue };
            let are_alike = suspected.iter().all(|&(_, other)| other == factor);
            // Who is off everywhere, where others are not, is off by itself.
            let is_everywhere = suspected.len() == answers.len() && answers.len() > 1;
            if are_alike && is_everywhere && self.others_agree(engine, &suspected) {
                told.push(format!(
                    "{engine}: most of its disparities are bad on all {} scenes, but would not be {}",
                    answers.len(),
                    in_words(factor)
                ));
                continue;
            }
            for (scene, factor) in suspected {
                of_scenes.entry((scene, in_words(factor))).or_default().push(engine);
            }
        }
        let factors = |scene: &str| of_scenes.keys().filter(|(other, _)| *other == scene).count();
        for ((scene, remedy), engines) in &of_scenes {
            // Engines that are off by different factors acquit the truth.
            let truth = match factors(scene) {
                1 => "; or the truth is off by that: look at its scale",
                _ => "",
            };
            let engines = engines.join(", ");
            told.push(format!(
                "{scene}: most disparities of {engines} are bad, but would not be {remedy}{truth}"
            ));
        }
        told
    }

    /// Whether all other engines are at the truth's scale on these scenes.
    fn others_agree(&self, engine: &str, suspected: &[(&str, f64)]) -> bool {
        let others = self.engines.iter().filter(|(other, _)| *other != engine);
        others.flat_map(|(_, answers)| answers).all(|(scene, factor)| {
            factor.is_none() || suspected.iter().all(|(suspected, _)| suspected != scene)
        })
    }
}

fn suspected(disparity: &Plane<f32>, truth: &Plane<f32>, data: &CaseData) -> Option<f64> {
    let region = Region::whole().within(Some(data.bounds));
    suspected_scale(&Pixels::select(disparity, truth, &region).ok()?)
}

fn in_words(factor: f64) -> String {
    match factor {
        -1.0 => "with the other sign (disparities are left less right)".into(),
        1.0.. => format!("if they were divided by {factor}"),
        _ => format!("if they were multiplied by {}", (1.0 / factor).round()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an engine, for each scene.
    type Answers<'a> = &'a [(&'a str, Option<f64>)];

    fn told(answers: &[(&str, Answers<'_>)]) -> Vec<String> {
        let of = |answers: Answers<'_>| {
            answers.iter().map(|&(scene, factor)| (scene.to_owned(), factor)).collect()
        };
        let engines =
            answers.iter().map(|&(engine, answers)| (engine.to_owned(), of(answers))).collect();
        Scales { engines, flat: Vec::new() }.told()
    }

    #[test]
    fn a_scene_or_an_engine_is_told_whichever_is_off() {
        let (right, off) = (None, Some(16.0));
        assert_eq!(told(&[("a", &[("one", right), ("two", right)])]), [] as [String; 0]);
        // One engine is off on all scenes, the other is not.
        let [line] =
            told(&[("a", &[("one", off), ("two", off)]), ("b", &[("one", right), ("two", right)])])
                .try_into()
                .unwrap();
        assert!(line.starts_with("a: ") && line.ends_with("divided by 16"), "{line}");
        // All engines are off on one scene.
        let quarter = Some(0.25);
        let [line] = told(&[
            ("a", &[("one", quarter), ("two", right)]),
            ("b", &[("one", quarter), ("two", right)]),
        ])
        .try_into()
        .unwrap();
        assert!(line.starts_with("one: most disparities of a, b are bad"), "{line}");
        assert!(line.contains("multiplied by 4; or the truth"), "{line}");
        let lines = told(&[("a", &[("one", Some(4.0))]), ("b", &[("one", quarter)])]);
        let expected = [
            "one: most disparities of a are bad, but would not be if they were divided by 4",
            "one: most disparities of b are bad, but would not be if they were multiplied by 4",
        ];
        assert_eq!(lines, expected);
        let [line] = told(&[("a", &[("one", Some(-1.0))])]).try_into().unwrap();
        assert!(line.starts_with("one: ") && line.contains("other sign"), "{line}");
    }
}
