//! Accuracy over CPU time, and the front: those whom nobody beats in both.

use super::anchor;
use crate::board::Standing;
use formats::markup::escaped;
use unicode_width::UnicodeWidthChar;

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 290.0;
/// Room for the axes' numbers and names.
const LEFT: f64 = 52.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;

/// One entrant in the plot.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    /// Its place in the list.
    at: usize,
    cpu: f64,
    score: f64,
}

pub(super) fn figure(standings: &[Standing]) -> String {
    let mut points: Vec<Point> = standings
        .iter()
        .enumerate()
        .filter_map(|(at, standing)| {
            let cpu = standing.entry.holdout.usage.cpu_seconds?;
            // Less than a millisecond cannot be told apart.
            Some(Point { at, cpu: cpu.max(1e-3), score: standing.score? })
        })
        .collect();
    if points.is_empty() {
        return String::new();
    }
    points.sort_by(|a, b| a.cpu.total_cmp(&b.cpu).then(a.score.total_cmp(&b.score)));
    let front = front(&points);
    let axes = Axes::around(&points);
    let steps: String = front.iter().enumerate().fold(String::new(), |path, (n, point)| {
        let (x, y) = axes.place(point);
        match n {
            0 => format!("M{x:.1} {y:.1}"),
            _ => format!("{path} H{x:.1} V{y:.1}"),
        }
    });
    // The last of the front is the best for anybody with more time.
    let steps = format!("{steps} H{:.1}", WIDTH - RIGHT);
    let mut labels = Labels::around(points.iter().map(|point| axes.place(point)).collect());
    let marks: String = points
        .iter()
        .map(|point| {
            let standing = &standings[point.at];
            let name = &standing.entry.secret_id;
            let label = front.contains(point).then(|| labels.place(axes.place(point), name));
            mark(
                point,
                standing,
                &axes,
                front.contains(point),
                &label.flatten().unwrap_or_default(),
            )
        })
        .collect();
    format!(
        "<figure class=\"scroll\">\n<svg class=\"pareto\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         role=\"group\" aria-label=\"Score over CPU time\">\n{}<path class=\"front\" d=\"{steps}\"/>\n\
         {marks}</svg>\n<figcaption>Score on the hold-out over its CPU time: lower and further left \
         is better. The line joins those whom nobody beats in both.</figcaption>\n</figure>\n",
        axes.draw()
    )
}

/// Those for whom nobody is at least as quick and as accurate, by rising time. `points` are sorted
/// by time, then score.
fn front(points: &[Point]) -> Vec<Point> {
    let mut best = f64::INFINITY;
    points
        .iter()
        .filter(|point| {
            let leads = point.score < best;
            best = best.min(point.score);
            leads
        })
        .copied()
        .collect()
}

fn mark(point: &Point, standing: &Standing, axes: &Axes, leads: bool, label: &str) -> String {
    let (x, y) = axes.place(point);
    let name = escaped(&standing.entry.secret_id);
    let class = match (standing.entry.baseline, leads) {
        (true, _) => "baseline",
        (false, true) => "leads",
        (false, false) => "",
    };
    format!(
        "<a href=\"#{}\" class=\"{class}\"><title>{name}: score {:.3}, {:.2} CPU s</title>\
         <circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>{label}</a>\n",
        anchor(point.at),
        point.score,
        point.cpu
    )
}

/// Where names stand, so that they cover neither each other nor a point.
struct Labels {
    /// Left, top, right, bottom of what is taken.
    taken: Vec<[f64; 4]>,
}

impl Labels {
    fn around(points: Vec<(f64, f64)>) -> Self {
        let of_point = |(x, y)| [x - 6.0, y - 6.0, x + 6.0, y + 6.0];
        Self { taken: points.into_iter().map(of_point).collect() }
    }

    /// The name beside its point; `None` where there is no room.
    fn place(&mut self, (x, y): (f64, f64), name: &str) -> Option<String> {
        let width: f64 = name.chars().map(width).sum();
        for (right, below) in [(true, false), (false, false), (true, true), (false, true)] {
            let baseline = if below { y + 19.0 } else { y - 9.0 };
            let start = if right { x + 7.0 } else { x - 7.0 - width };
            let own = [start, baseline - 11.0, start + width, baseline + 3.0];
            let inside = own[0] > LEFT && own[2] < WIDTH - RIGHT && own[1] > 0.0;
            let covers = |other: &[f64; 4]| {
                own[0] < other[2] && other[0] < own[2] && own[1] < other[3] && other[1] < own[3]
            };
            if inside && baseline < HEIGHT - BOTTOM && !self.taken.iter().any(covers) {
                self.taken.push(own);
                let (at, align) = if right { (x + 7.0, "start") } else { (x - 7.0, "end") };
                return Some(format!(
                    "<text x=\"{at:.1}\" y=\"{baseline:.1}\" text-anchor=\"{align}\">{}</text>",
                    escaped(name)
                ));
            }
        }
        None
    }
}

/// How wide a letter may be, in the plot's units.
fn width(letter: char) -> f64 {
    match letter {
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 13.0,
        _ if letter.width() == Some(2) => 15.0,
        _ if letter.is_uppercase() => 10.0,
        _ => 7.5,
    }
}

/// Time is logarithmic, the score begins at 0.
struct Axes {
    /// Decades of the first and last mark of time.
    first: i32,
    last: i32,
    /// The score at the top, and the distance of its marks.
    top: f64,
    step: f64,
}

impl Axes {
    fn around(points: &[Point]) -> Self {
        let low = points.iter().fold(f64::INFINITY, |low, point| low.min(point.cpu));
        let high = points.iter().fold(0.0f64, |high, point| high.max(point.cpu));
        let worst = points.iter().fold(0.0f64, |worst, point| worst.max(point.score)).max(1e-3);
        // Four to eight marks at 1, 2 or 5 times a power of ten.
        let power = 10f64.powf((worst / 8.0).log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| worst / step <= 8.0)
            .unwrap_or(10.0 * power);
        let first = low.log10().floor() as i32;
        Self {
            first,
            last: (high.log10().ceil() as i32).max(first + 1),
            top: (worst / step + 0.3).ceil() * step,
            step,
        }
    }

    fn place(&self, point: &Point) -> (f64, f64) {
        (self.x(point.cpu), self.y(point.score))
    }

    fn x(&self, cpu: f64) -> f64 {
        let part = (cpu.log10() - f64::from(self.first)) / f64::from(self.last - self.first);
        LEFT + part * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, score: f64) -> f64 {
        HEIGHT - BOTTOM - score / self.top * (HEIGHT - TOP - BOTTOM)
    }

    fn draw(&self) -> String {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        let mut svg = String::new();
        for decade in self.first..=self.last {
            let x = self.x(10f64.powi(decade));
            let digits = decade.min(0).unsigned_abs() as usize;
            svg.push_str(&format!(
                "<line x1=\"{x:.1}\" y1=\"{TOP}\" x2=\"{x:.1}\" y2=\"{bottom}\"/>\
                 <text class=\"tick\" x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">\
                 {:.digits$}</text>\n",
                bottom + 17.0,
                10f64.powi(decade)
            ));
        }
        let digits = (-self.step.log10().floor()).max(0.0) as usize;
        for mark in 0..=(self.top / self.step).round() as usize {
            let score = mark as f64 * self.step;
            let y = self.y(score);
            svg.push_str(&format!(
                "<line x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{right}\" y2=\"{y:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">\
                 {score:.digits$}</text>\n",
                LEFT - 7.0,
                y + 4.0
            ));
        }
        svg.push_str(&format!(
            "<text class=\"tick\" x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">CPU time on the \
             hold-out, s</text>\n<text class=\"tick\" transform=\"translate(13 {:.1}) rotate(-90)\" \
             text-anchor=\"middle\">Score</text>\n",
            HEIGHT - 8.0,
            (TOP + bottom) / 2.0
        ));
        svg
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, f64)]) -> Vec<Point> {
        values.iter().enumerate().map(|(at, &(cpu, score))| Point { at, cpu, score }).collect()
    }

    #[test]
    fn the_front_is_whom_nobody_beats_in_both() {
        let points =
            points(&[(0.1, 3.0), (0.1, 3.5), (0.2, 3.0), (0.5, 1.0), (9.0, 2.0), (20.0, 0.5)]);
        let front: Vec<usize> = front(&points).iter().map(|point| point.at).collect();
        assert_eq!(front, [0, 3, 5]);
    }

    #[test]
    fn names_cover_neither_each_other_nor_points() {
        let places = vec![(200.0, 100.0), (210.0, 100.0), (215.0, 104.0)];
        let mut labels = Labels::around(places.clone());
        let placed: Vec<Option<String>> =
            places.iter().map(|&place| labels.place(place, "somebody <here>")).collect();
        assert!(placed[0].as_ref().is_some_and(|text| text.contains("somebody &lt;here&gt;")));
        let taken = &labels.taken;
        for (at, own) in taken.iter().enumerate().skip(places.len()) {
            for other in &taken[..at] {
                let apart = own[2] <= other[0] || other[2] <= own[0];
                assert!(apart || own[3] <= other[1] || other[3] <= own[1], "{own:?} {other:?}");
            }
        }
        assert_eq!(labels.place((200.0, 100.0), &"x".repeat(80)), None);
        let mut labels = Labels::around(Vec::new());
        assert_eq!(labels.place((200.0, 100.0), &"W".repeat(26)), None);
    }

    #[test]
    fn every_point_lies_within_the_axes() {
        for values in [vec![(1.0, 0.0)], vec![(0.001, 12.0), (3000.0, 0.2)], vec![(10.0, 1.0)]] {
            let points = points(&values);
            let axes = Axes::around(&points);
            for point in &points {
                let (x, y) = axes.place(point);
                assert!((LEFT..=WIDTH - RIGHT).contains(&x), "{x} {point:?}");
                assert!((TOP..=HEIGHT - BOTTOM).contains(&y), "{y} {point:?}");
            }
            assert!((2..=10).contains(&((axes.top / axes.step).round() as i32)));
            // Quicker is further left, better is lower.
            let Some(&[quick, slow]) = points.as_array() else { continue };
            let ((x, y), (of_slow, lower)) = (axes.place(&quick), axes.place(&slow));
            assert!(quick.cpu < slow.cpu && x < of_slow, "{x} {of_slow}");
            assert!(quick.score > slow.score && y < lower, "{y} {lower}");
        }
    }
}
