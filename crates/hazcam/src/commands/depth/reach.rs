//! How good depth is at which range: what an error of the disparity is worth.

use camera::{StereoCamera, widest};
use raster::Plane;
use serde::Serialize;

use super::kept::Counts;

/// Errors of the depth, as shares of it, that one asks for.
const SHARES: [f64; 3] = [0.01, 0.05, 0.1];
/// Beyond this share the derivative says little about the error any more.
const MEANINGFUL: f64 = 0.5;

/// What `hazcam depth` prints.
#[derive(Debug, Serialize)]
pub struct Reach {
    camera: Told,
    /// Of a map, where there is one.
    #[serde(flatten)]
    map: Option<OfMap>,
    /// The error of disparities that the following is for.
    disparity_error_px: f64,
    /// At round depths from the nearest to the farthest.
    at: Vec<At>,
    /// How far depth is as good as that.
    good_to: Vec<GoodTo>,
}

/// A camera, with its principal point where that is known.
#[derive(Debug, Serialize)]
struct Told {
    focal_px: f64,
    baseline_m: f64,
    doffs: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    cx: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cy: Option<f64>,
}

/// What a map has.
#[derive(Debug, Serialize)]
struct OfMap {
    pixels: Counts,
    /// In metres; none where no pixel has a depth.
    depth_m: Option<Span>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Span {
    least: f64,
    median: f64,
    most: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct At {
    depth_m: f64,
    disparity_px: f64,
    error_m: f64,
    error_share: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct GoodTo {
    error_share: f64,
    depth_m: f64,
}

/// Metres with so many decimals, or more where these would leave less than two digits.
fn digits(metres: f64, decimals: usize) -> String {
    let leading = metres.abs().log10().floor();
    let needed = if leading.is_finite() { 1.0 - leading } else { 0.0 };
    let decimals = decimals.max(needed.clamp(0.0, 12.0) as usize);
    format!("{metres:.decimals$}")
}

/// A depth in metres.
fn length(metres: f64) -> String {
    digits(metres, 2)
}

/// Without a map errors stand from this share of the depth on.
const FIRST: f64 = 0.001;

impl Reach {
    /// Of the depths of a map.
    pub fn new(
        camera: &StereoCamera,
        depths: &Plane<f32>,
        pixels: Counts,
        disparity_error_px: f64,
    ) -> Self {
        let depth_m = span(depths);
        let reach =
            Self::within(camera, depth_m, f64::from(widest(depths.columns())), disparity_error_px);
        Self { map: Some(OfMap { pixels, depth_m }), ..reach }
    }

    /// Of a camera, whatever it looks at.
    pub fn of_camera(
        camera: &StereoCamera,
        has_principal_point: bool,
        disparity_error_px: f64,
    ) -> Self {
        let [least, median, most] = [FIRST, SHARES[1], MEANINGFUL]
            .map(|share| good_to(camera, share, disparity_error_px).depth_m);
        let span = Some(Span { least, median, most });
        let reach = Self::within(camera, span, f64::INFINITY, disparity_error_px);
        match has_principal_point {
            true => reach,
            false => Self { camera: Told { cx: None, cy: None, ..reach.camera }, ..reach },
        }
    }

    fn within(
        camera: &StereoCamera,
        depth_m: Option<Span>,
        widest: f64,
        disparity_error_px: f64,
    ) -> Self {
        let at = |depth_m: f64| {
            let error_m = camera.depth_uncertainty(depth_m, disparity_error_px)?;
            let disparity_px = camera.disparity(depth_m)?;
            Some(At { depth_m, disparity_px, error_m, error_share: error_m / depth_m })
        };
        let worth = |at: &At| at.error_share <= MEANINGFUL && at.disparity_px <= widest;
        let StereoCamera { focal_px, baseline_m, doffs, cx, cy, .. } = *camera;
        Self {
            camera: Told { focal_px, baseline_m, doffs, cx: Some(cx), cy: Some(cy) },
            map: None,
            disparity_error_px,
            at: depth_m
                .map_or_else(Vec::new, round_depths)
                .into_iter()
                .filter_map(at)
                .filter(worth)
                .collect(),
            good_to: SHARES.map(|share| good_to(camera, share, disparity_error_px)).to_vec(),
        }
    }

    /// In words and numbers.
    pub fn text(&self) -> String {
        let Told { focal_px, baseline_m, doffs, .. } = self.camera;
        let mut lines = self.map.as_ref().map_or_else(Vec::new, OfMap::lines);
        lines.push(format!(
            "camera  focal length {focal_px:.2} px, baseline {} m, doffs {doffs:.2} px",
            digits(baseline_m, 4)
        ));
        lines.push(String::new());
        let error = self.disparity_error_px;
        if !self.at.is_empty() {
            lines.push(format!(
                "what an error of {error} px in disparity is worth, where that is less than half of the depth:"
            ));
            lines.push("   depth m  disparity px    error m  error %".into());
            lines.extend(self.at.iter().map(
                |At { depth_m, disparity_px, error_m, error_share }| {
                    let percent = 100.0 * error_share;
                    format!(
                        "{depth_m:>10}  {disparity_px:>12.2}  {:>9}  {percent:>7.2}",
                        digits(*error_m, 3)
                    )
                },
            ));
            lines.push(String::new());
        }
        let good = self.good_to.iter().map(|GoodTo { error_share, depth_m }| {
            format!("{} % up to {} m", 100.0 * error_share, length(*depth_m))
        });
        let good: Vec<String> = good.collect();
        lines.push(format!("with {error} px, depth is good to {}\n", good.join(", ")));
        lines.join("\n")
    }
}

impl OfMap {
    fn lines(&self) -> Vec<String> {
        let depth = match self.depth_m {
            Some(Span { least, median, most }) => {
                let [least, median, most] = [least, median, most].map(length);
                format!("{least} to {most} m, half of the pixels within {median} m")
            }
            None => "no pixel has one".into(),
        };
        vec![format!("depth   {depth}"), format!("pixels  {}", self.pixels_in_words())]
    }

    fn pixels_in_words(&self) -> String {
        let Counts { kept, without_disparity, behind, unsure, too_far } = self.pixels;
        let counts = [
            (without_disparity, "without a disparity"),
            (behind, "infinitely far or behind the cameras (disparity + doffs is not above 0)"),
            (unsure, "not sure enough"),
            (too_far, "too far away"),
        ];
        let left_out = counts.into_iter().filter(|(count, _)| *count > 0);
        let left_out: String = left_out.map(|(count, what)| format!(", {count} {what}")).collect();
        format!("{kept} with a depth{left_out}")
    }
}

/// Up to where an error of the disparity is at most this share of the depth: `share f B / error`.
fn good_to(camera: &StereoCamera, error_share: f64, disparity_error_px: f64) -> GoodTo {
    let depth_m = error_share * camera.focal_px * camera.baseline_m / disparity_error_px;
    GoodTo { error_share, depth_m }
}

fn span(depths: &Plane<f32>) -> Option<Span> {
    let mut known: Vec<f32> = depths.samples().iter().copied().filter(|d| !d.is_nan()).collect();
    let middle = known.len() / 2;
    if known.is_empty() {
        return None;
    }
    let (below, &mut median, above) = known.select_nth_unstable_by(middle, f32::total_cmp);
    let least = below.iter().copied().fold(median, f32::min);
    let most = above.iter().copied().fold(median, f32::max);
    let [least, median, most] = [least, median, most].map(f64::from);
    Some(Span { least, median, most })
}

/// So many rows tell how an error grows.
const ROWS: usize = 3;

/// 1, 2 and 5 times the powers of ten from the nearest to the farthest; where these are few, its ends and the median.
fn round_depths(span: Span) -> Vec<f64> {
    let powers = span.least.log10().floor() as i32..=span.most.log10().ceil() as i32;
    let all = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|times| round(times, power)));
    let within: Vec<f64> = all.filter(|d| (span.least..=span.most).contains(d)).collect();
    if within.len() >= ROWS {
        return within;
    }
    let mut few = [span.least, span.median, span.most].map(in_three_digits).to_vec();
    few.dedup();
    few
}

/// A number above 0.
fn in_three_digits(number: f64) -> f64 {
    let power = number.log10().floor() as i32 - 2;
    round((number / 10f64.powi(power)).round(), power)
}

/// A power of ten is exact, one below 1 is not: dividing rounds once.
fn round(times: f64, power: i32) -> f64 {
    if power < 0 { times / 10f64.powi(-power) } else { times * 10f64.powi(power) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a map of 500 columns.
    fn reach(mut depths: Vec<f32>) -> Reach {
        // f B = 200.
        let camera = StereoCamera::new(1000.0, 0.2, 10.0, 0.0, 0.0).unwrap();
        depths.resize(500, f32::NAN);
        let depths = Plane::new(500, 1, depths).unwrap();
        Reach::new(&camera, &depths, Counts { kept: 3, unsure: 2, ..Counts::default() }, 0.5)
    }

    #[test]
    fn errors_stand_at_round_depths_within_the_map() {
        let reach = reach(vec![0.4, 3.0, f32::NAN, 25.0]);
        let depths: Vec<f64> = reach.at.iter().map(|at| at.depth_m).collect();
        assert_eq!(depths, [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        // Z^2 0.5 / 200, and 200 / Z - 10.
        let at = reach.at[4];
        assert_eq!((at.disparity_px, at.error_m, at.error_share), (10.0, 0.25, 0.025));
        let good: Vec<f64> = reach.good_to.iter().map(|good| good.depth_m).collect();
        assert_eq!(good, [4.0, 20.0, 40.0]);
        assert_eq!(reach.map.unwrap().depth_m.unwrap().median, 3.0);
    }

    #[test]
    fn a_wall_between_round_depths_stands_at_its_ends_and_its_median() {
        let depths = |of: Vec<f32>| reach(of).at.iter().map(|at| at.depth_m).collect::<Vec<f64>>();
        assert_eq!(depths(vec![3.0, 4.0, 4.5]), [3.0, 4.0, 4.5]);
        assert_eq!(depths(vec![4.0, 4.0, 4.5]), [4.0, 4.5]);
        // What is nearer has its match far outside of the map.
        assert_eq!(depths(vec![0.01, 0.19, 0.21]), [0.2]);
        assert_eq!(
            [5.771_158_2, 0.034_567, 98_765.4].map(in_three_digits),
            [5.77, 0.0346, 98_800.0]
        );
    }

    #[test]
    fn a_camera_without_a_map_is_told_from_a_thousandth_to_a_half() {
        let camera = StereoCamera::new(1000.0, 0.2, 0.0, 0.0, 0.0).unwrap();
        let reach = Reach::of_camera(&camera, false, 0.5);
        let shares: Vec<f64> = reach.at.iter().map(|at| at.error_share).collect();
        assert!(shares[0] >= 0.001 && shares[0] < 0.0025, "{shares:?}");
        assert!(shares.is_sorted() && shares[shares.len() - 1] == 0.5, "{shares:?}");
        let text = reach.text();
        assert!(text.starts_with("camera  focal length 1000.00 px, baseline 0.2000 m"), "{text}");
        let json = serde_json::to_value(&reach).unwrap();
        assert!(json.get("pixels").is_none() && json["at"].is_array(), "{json}");
        let expected = serde_json::json!({ "focal_px": 1000.0, "baseline_m": 0.2, "doffs": 0.0 });
        assert_eq!(json["camera"], expected);
    }

    #[test]
    fn where_the_error_is_as_large_as_the_depth_there_is_no_row() {
        let far = reach(vec![150.0, 900.0, 9000.0]);
        assert_eq!(far.at.iter().map(|at| at.depth_m).collect::<Vec<_>>(), [200.0]);
    }

    #[test]
    fn words_tell_what_was_left_out_and_that_nothing_is_left() {
        assert!(reach(vec![3.0]).text().contains("3 with a depth, 2 not sure enough\n"));
        let nothing = reach(vec![f32::NAN]);
        assert!(nothing.text().starts_with("depth   no pixel has one\n"));
        assert!(nothing.at.is_empty());
    }
}
