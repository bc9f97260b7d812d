//! Every measure against a second, deliberately naive computation over random maps, boxes and
//! masks. The naive side shares no code with the crate: it loops over pixels, once per measure.

use arbtest::arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use raster::{BoundingBox, Plane};
use score::{
    Evaluation, RankedError, Region, Scores, evaluate, fill_from_background, sparsification,
};

/// A random scene: about one pixel in eight has no truth, one in eight no estimate.
struct Case {
    estimate: Plane<f32>,
    truth: Plane<f32>,
    confidence: Plane<f32>,
    mask: Plane<bool>,
    bounds: BoundingBox,
}

/// Whole or quarter pixels, so that errors fall on thresholds.
fn disparity(u: &mut Unstructured<'_>) -> Result<f32> {
    Ok(match u.int_in_range(0..=7)? {
        0 => [f32::NAN, f32::INFINITY][usize::from(u.ratio(1, 4)?)],
        1..=4 => u.int_in_range(-4..=40)? as f32,
        _ => u.int_in_range(0..=480)? as f32 / 4.0,
    })
}

fn plane<T>(
    u: &mut Unstructured<'_>,
    (columns, rows): (usize, usize),
    mut sample: impl FnMut(&mut Unstructured<'_>) -> Result<T>,
) -> Result<Plane<T>> {
    let samples: Result<Vec<T>> = (0..columns * rows).map(|_| sample(u)).collect();
    Ok(Plane::new(columns, rows, samples?).unwrap())
}

impl Case {
    fn random(u: &mut Unstructured<'_>) -> Result<Self> {
        let size = (u.int_in_range(1..=12)?, u.int_in_range(1..=8)?);
        let truth = plane(u, size, disparity)?;
        let mut estimate = plane(u, size, disparity)?;
        // Mostly close to the truth, or every measure would sit at its worst.
        for (e, &t) in estimate.samples_mut().iter_mut().zip(truth.samples()) {
            if u.ratio(2, 3)? {
                *e = t + u.int_in_range(-24..=24)? as f32 / 8.0;
            }
        }
        let (x0, y0) = (u.choose_index(size.0)?, u.choose_index(size.1)?);
        let bounds = BoundingBox::new(
            x0,
            y0,
            u.int_in_range(x0..=size.0 - 1)?,
            u.int_in_range(y0..=size.1 - 1)?,
        );
        Ok(Self {
            estimate,
            truth,
            // Few levels, so that ties are common.
            confidence: plane(u, size, |u| Ok(u.int_in_range(0..=5)? as f32 / 5.0))?,
            mask: plane(u, size, |u| u.ratio(3, 4))?,
            bounds: bounds.unwrap(),
        })
    }

    fn region(&self) -> Region<'_> {
        Region::masked("random", &self.mask).within(Some(self.bounds))
    }

    fn scores(&self) -> Option<Scores> {
        evaluate(&self.estimate, &self.truth, &self.region()).ok()
    }

    /// `(x, y, estimate, truth)` of the scored pixels.
    fn pixels(&self) -> Vec<(usize, usize, f64, f64)> {
        let mut found = Vec::new();
        for y in self.bounds.y0..=self.bounds.y1 {
            for x in self.bounds.x0..=self.bounds.x1 {
                let (e, t) = (f64::from(self.estimate.row(y)[x]), f64::from(self.truth.row(y)[x]));
                if t.is_finite() && self.mask.row(y)[x] {
                    found.push((x, y, e, t));
                }
            }
        }
        found
    }
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} is not {b}");
}

fn close_or_both_none(a: Option<f64>, b: Option<f64>) {
    match (a, b) {
        (Some(a), Some(b)) => close(a, b),
        _ => assert_eq!(a, b),
    }
}

#[test]
fn the_courses_numbers() {
    arbtest(|u| {
        let case = Case::random(u)?;
        let pixels = case.pixels();
        let Some(scores) = case.scores() else {
            assert!(pixels.is_empty());
            return Ok(());
        };
        let (mut n, mut sum, mut bad) = (0.0, 0.0, 0.0);
        for (_, _, e, t) in pixels {
            if t == 0.0 {
                continue;
            }
            n += 1.0;
            if e.is_finite() {
                sum += (e - t) * (e - t);
                if (e - t).abs() > 2.0 {
                    bad += 1.0;
                }
            } else {
                sum += t * t;
                bad += 1.0;
            }
        }
        match scores.course {
            Some(course) => {
                close(course.e_rms, f64::sqrt(sum / n));
                close(course.p_bad, bad / n);
                assert_eq!(course.pixels as f64, n);
            }
            None => assert_eq!(n, 0.0),
        }
        Ok(())
    });
}

#[test]
fn middleburys_numbers() {
    arbtest(|u| {
        let case = Case::random(u)?;
        let largest = if u.ratio(1, 2)? { Some(f64::from(u.int_in_range(0..=60)?)) } else { None };
        let evaluation = Evaluation::new(&case.estimate, &case.truth).unwrap();
        let pixels = case.pixels();
        let Ok(scores) = evaluation.clipped_to(largest).scores(&case.region()) else {
            assert!(pixels.is_empty());
            return Ok(());
        };
        let got = scores.middlebury;
        let n = pixels.len() as f64;
        let mut errors = Vec::new();
        for &(_, _, e, t) in &pixels {
            if e.is_finite() {
                let clipped = if let Some(largest) = largest { e.max(0.0).min(largest) } else { e };
                errors.push(f64::abs(clipped - t));
            }
        }
        let v = errors.len() as f64;
        for (i, threshold) in [0.5, 1.0, 2.0, 4.0].into_iter().enumerate() {
            let mut wrong = 0.0;
            for &error in &errors {
                if error > threshold {
                    wrong += 1.0;
                }
            }
            assert_eq!(got.bad[i].threshold, threshold);
            close(got.bad[i].bad, wrong / n);
            close(got.bad[i].totbad, 1.0 - (v - wrong) / n);
            close_or_both_none(got.bad[i].of_estimates, (v > 0.0).then_some(wrong / v));
        }
        close(got.density, v / n);
        let (mut sum, mut squares) = (0.0, 0.0);
        for &error in &errors {
            sum += error;
            squares += error * error;
        }
        close_or_both_none(got.avgerr, (v > 0.0).then_some(sum / v));
        close_or_both_none(got.rms, (v > 0.0).then_some(f64::sqrt(squares / v)));
        for (quantile, percent) in
            [(got.a50, 50.0), (got.a90, 90.0), (got.a95, 95.0), (got.a99, 99.0)]
        {
            // The smallest error that covers enough, found by trying all.
            let mut best = None;
            for &candidate in &errors {
                let covered = errors.iter().filter(|&&error| error <= candidate).count() as f64;
                if covered * 100.0 >= percent * v && best.is_none_or(|b| candidate < b) {
                    best = Some(candidate);
                }
            }
            assert_eq!(quantile, best);
        }
        Ok(())
    });
}

/// The value KITTI's kit gives a pixel, looked for pixel by pixel.
fn kittis_fill(map: &Plane<f32>, x: usize, y: usize) -> Option<f32> {
    let has = |y: usize| map.row(y).iter().any(|v| v.is_finite());
    let row = if has(y) {
        y
    } else {
        let above = (0..y).rev().find(|&y| has(y));
        let below = (y + 1..map.rows()).find(|&y| has(y));
        match (above, below) {
            (Some(row), None) | (None, Some(row)) => row,
            _ => return None,
        }
    };
    let row = map.row(row);
    if row[x].is_finite() {
        return Some(row[x]);
    }
    let left = (0..x).rev().map(|x| row[x]).find(|v| v.is_finite());
    let right = (x + 1..row.len()).map(|x| row[x]).find(|v| v.is_finite());
    match (left, right) {
        (Some(left), Some(right)) => Some(if left < right { left } else { right }),
        (one, other) => one.or(other),
    }
}

#[test]
fn kittis_numbers() {
    arbtest(|u| {
        let case = Case::random(u)?;
        let filled = fill_from_background(&case.estimate);
        for y in 0..filled.rows() {
            for x in 0..filled.columns() {
                let got = Some(filled.row(y)[x]).filter(|v| v.is_finite());
                assert_eq!(got, kittis_fill(&case.estimate, x, y));
            }
        }
        let pixels = case.pixels();
        let Some(scores) = case.scores() else {
            assert!(pixels.is_empty());
            return Ok(());
        };
        let outlier = |e: f64, t: f64| (e - t).abs() > 3.0 && (e - t).abs() / t.abs() > 0.05;
        let (mut all, mut estimated, mut wrong) = (0.0, 0.0, 0.0);
        for &(x, y, e, t) in &pixels {
            if kittis_fill(&case.estimate, x, y).is_none_or(|v| outlier(f64::from(v), t)) {
                all += 1.0;
            }
            if e.is_finite() {
                estimated += 1.0;
                wrong += if outlier(e, t) { 1.0 } else { 0.0 };
            }
        }
        close(scores.kitti.d1, all / pixels.len() as f64);
        close_or_both_none(scores.kitti.d1_est, (estimated > 0.0).then_some(wrong / estimated));
        for out in &scores.kitti.out {
            let is_out = |&&(x, y, _, t): &&(usize, usize, f64, f64)| {
                let filled = kittis_fill(&case.estimate, x, y);
                filled.is_none_or(|v| (f64::from(v) - t).abs() > out.threshold)
            };
            let wrong = pixels.iter().filter(is_out).count();
            close(out.share, wrong as f64 / pixels.len() as f64);
        }
        Ok(())
    });
}

#[test]
fn end_point_errors() {
    arbtest(|u| {
        let case = Case::random(u)?;
        let pixels = case.pixels();
        let Some(scores) = case.scores() else {
            assert!(pixels.is_empty());
            return Ok(());
        };
        let mut errors = Vec::new();
        for (_, _, e, t) in pixels {
            if e.is_finite() {
                errors.push(e - t);
            }
        }
        let v = errors.len() as f64;
        let some = |value: f64, n: f64| (n > 0.0).then_some(value / n);
        let got = scores.end_point;
        close_or_both_none(got.mean, some(errors.iter().map(|e| e.abs()).sum(), v));
        close_or_both_none(got.bias, some(errors.iter().sum(), v));
        if let Some(median) = got.median {
            let below = errors.iter().filter(|e| e.abs() < median).count() as f64;
            let above = errors.iter().filter(|e| e.abs() > median).count() as f64;
            assert!(below <= v / 2.0 && above <= v / 2.0);
        }
        let (mut n, mut sum, mut signed, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for e in errors {
            if (-1.0..=1.0).contains(&e) {
                n += 1.0;
                sum += e.abs();
                signed += e;
                squares += e * e;
            }
        }
        assert_eq!(got.sub_pixel.pixels as f64, n);
        close_or_both_none(got.sub_pixel.mean, some(sum, n));
        close_or_both_none(got.sub_pixel.bias, some(signed, n));
        close_or_both_none(got.sub_pixel.rms, some(squares, n).map(f64::sqrt));
        Ok(())
    });
}

/// The area under the curve as the mean over all orders that agree with the confidence would give
/// it: of the k most confident, whole groups count fully and the last group by its share.
fn naive_area(ranked: &[(f64, f64)]) -> f64 {
    let n = ranked.len();
    let mut area = 0.0;
    for k in 1..=n {
        let (mut kept, mut sum) = (0.0, 0.0);
        let mut levels: Vec<f64> = ranked.iter().map(|r| r.0).collect();
        levels.sort_by(|a, b| b.partial_cmp(a).unwrap());
        levels.dedup();
        for level in levels {
            let group: Vec<f64> = ranked.iter().filter(|r| r.0 == level).map(|r| r.1).collect();
            let size = group.len() as f64;
            let take = size.min(k as f64 - kept);
            kept += take;
            sum += group.iter().sum::<f64>() * take / size;
        }
        area += sum / k as f64;
    }
    area / n as f64
}

#[test]
fn areas_under_the_sparsification_curve() {
    arbtest(|u| {
        let case = Case::random(u)?;
        let evaluation = Evaluation::new(&case.estimate, &case.truth).unwrap();
        let Ok(pixels) = evaluation.pixels(&case.region()) else {
            assert!(case.pixels().is_empty());
            return Ok(());
        };
        for error in [RankedError::EndPoint, RankedError::Bad(1.0)] {
            let mut ranked = Vec::new();
            for (x, y, e, t) in case.pixels() {
                if e.is_finite() {
                    let size = match error {
                        RankedError::EndPoint => (e - t).abs(),
                        RankedError::Bad(limit) if (e - t).abs() > limit => 1.0,
                        RankedError::Bad(_) => 0.0,
                    };
                    ranked.push((f64::from(case.confidence.row(y)[x]), size));
                }
            }
            let got = sparsification(&pixels, &case.confidence, error);
            if ranked.is_empty() {
                assert!(got.is_err());
                continue;
            }
            let got = got.unwrap();
            close(got.auc, naive_area(&ranked));
            let oracle: Vec<_> = ranked.iter().map(|&(_, error)| (-error, error)).collect();
            close(got.optimal_auc, naive_area(&oracle));
            assert!(got.ause >= -1e-12, "nothing beats the oracle");
            let last = got.curve.last().unwrap();
            close(last.error, last.oracle);
            close(last.density, 1.0);
        }
        Ok(())
    });
}
