//! Small obstacles in real scenes: pieces of a scene, cut out and laid somewhere else, nearer than what is there.
//!
//! Hardly anything in data sets with truth is as small as the stone that stops a rover, and nothing that is rendered
//! looks like a camera's picture. Both views of a piece are moved here, by a whole number of pixels each, so that its
//! texture, its noise and how its light differs between the cameras stay those of the scene. Pinggera et al. (*Lost and
//! Found: detecting small road hazards for self-driving vehicles*, IROS 2016) put real ones on real roads.

use arena::dataset::{Case, CaseData, Obstacles};
use raster::{BoundingBox, DisparityRange, Image, Plane};
use scenes::Random;

/// Widths of pieces in pixels, their heights as a multiple of that, and by how many pixels of disparity they are nearer.
const WIDTHS: (f64, f64) = (6.0, 32.0);
const HEIGHTS: (f64, f64) = (0.6, 1.6);
const STEPS: (f64, f64) = (0.7, 8.0);
/// So many are round.
const ROUND: f64 = 0.7;
/// They cover so much of the image.
const COVERED: f64 = 0.1;
/// So often a place is tried for each that would cover so much if all were as large as the mean.
const TRIALS: usize = 12;
/// All known disparities of a piece lie so near to one plane, in pixels, of which there must be some.
const FLAT: f32 = 0.5;
const KNOWN: usize = 6;
/// A plane's disparity changes by less than so much from column to column.
const STEEPEST: f32 = 0.5;
/// What is nearer by no more than this is the same surface, in pixels.
const SAME: f32 = 1.0;
/// Every pixel of a piece is nearer than what is behind it by at least so much.
const NEARER: f32 = 0.3;

/// The case with obstacles.
pub fn with_obstacles(case: Case) -> Case {
    let id = format!("obstacles/{}", case.id);
    Case::rendered(id, move || {
        let data = case.load().map_err(|error| error.to_string())?;
        let mut random = Random::new(1, &case.id);
        lay(&data, &mut random).ok_or_else(|| {
            "no piece of it can be laid over it: its truth is known of too few surfaces".to_owned()
        })
    })
}

/// Grey images, the left one's truth, and what lies at each pixel of the right one: the largest disparity, or -infinity
/// where none is known.
#[derive(Clone)]
struct Scene {
    left: Plane<f32>,
    right: Plane<f32>,
    truth: Plane<f32>,
    nearest: Plane<f32>,
}

/// `d = at + across x + down y`.
#[derive(Clone, Copy)]
struct Surface {
    at: f32,
    across: f32,
    down: f32,
}

/// Part of a scene that lies in a plane, and where it goes.
struct Piece {
    /// Its rows: each from one column to another one, both inclusive.
    rows: Vec<(usize, usize, usize)>,
    size: [usize; 2],
    surface: Surface,
    /// By how many columns and rows it moves, and by how many pixels it comes nearer.
    moves: [isize; 2],
    nearer: f32,
}

/// A pair with truth and obstacles; `None` where not one can be laid.
fn lay(data: &CaseData, random: &mut Random) -> Option<CaseData> {
    let from = Scene::new(data)?;
    let (columns, rows) = from.truth.size();
    let (mut scene, mut widths) = (from.clone(), Plane::filled(columns, rows, 0));
    let most = (COVERED * (columns * rows) as f64) as usize;
    let mut covered = 0;
    for _ in 0..TRIALS * most / (WIDTHS.0 * WIDTHS.1) as usize {
        if covered >= most {
            break;
        }
        if let Some(piece) = Piece::by_chance(&from, &scene, random)
            && scene.has_room(&piece, data.range)
        {
            scene.take(&from, &piece);
            for (x, y) in piece.pixels() {
                let (x, y) = piece.moved(x, y);
                widths.row_mut(y)[x] = piece.size[0].min(piece.size[1]) as u16;
                covered += 1;
            }
        }
    }
    if covered == 0 {
        return None;
    }
    let image =
        |grey: &Plane<f32>| Image::Grey8(grey.map(|grey| grey.round().clamp(0.0, 255.0) as u8));
    let mut laid = CaseData::new(image(&scene.left), image(&scene.right), data.range);
    laid.bounds = data.bounds;
    laid.truth = Some(scene.truth);
    laid.obstacles = Some(Obstacles { behind: from.truth, widths });
    laid.protocol = vec!["pieces of the scene lie before it; grey of 8 bits".into()];
    Some(laid)
}

impl Scene {
    fn new(data: &CaseData) -> Option<Self> {
        let (left, right) = (data.left.to_grey_f32(), data.right.to_grey_f32());
        let truth = data.truth.clone()?;
        let mut nearest = Plane::filled(right.columns(), right.rows(), f32::NEG_INFINITY);
        for (x, y) in BoundingBox::whole(truth.columns(), truth.rows()).pixels() {
            let disparity = truth.row(y)[x];
            if let Some(column) = seen_at(x as f32 - disparity, right.columns()) {
                let place = &mut nearest.row_mut(y)[column];
                *place = place.max(disparity);
            }
        }
        Some(Self { left, right, truth, nearest })
    }

    /// Whether both cameras see all of a piece before what is behind it, in the range.
    fn has_room(&self, piece: &Piece, range: DisparityRange) -> bool {
        let range = range.min() as f32..=range.max() as f32;
        piece.pixels().all(|(x, y)| {
            let disparity = piece.surface.disparity(x, y) + piece.nearer;
            let (x, y) = piece.moved(x, y);
            let seen = seen_at(x as f32 - disparity, self.right.columns());
            // What is not known is not nearer.
            let is_behind = |other: f32| other.is_nan() || other + NEARER <= disparity;
            range.contains(&disparity)
                && is_behind(self.truth.row(y)[x])
                && seen.is_some_and(|column| is_behind(self.nearest.row(y)[column]))
        })
    }

    /// Takes a piece of another scene.
    fn take(&mut self, from: &Scene, piece: &Piece) {
        for &(y, first, last) in &piece.rows {
            let [start, end] =
                [first, last].map(|x| (x as f32 - piece.surface.disparity(x, y)).round());
            for column in start as usize..=end as usize {
                let to = column as isize + piece.moves[0] - piece.nearer as isize;
                let row = self.right.row_mut((y as isize + piece.moves[1]) as usize);
                if let Some(sample) = usize::try_from(to).ok().and_then(|to| row.get_mut(to)) {
                    *sample = from.right.row(y)[column];
                }
            }
            for x in first..=last {
                let (to, to_row) = piece.moved(x, y);
                let disparity = piece.surface.disparity(x, y) + piece.nearer;
                self.left.row_mut(to_row)[to] = from.left.row(y)[x];
                self.truth.row_mut(to_row)[to] = from.truth.row(y)[x] + piece.nearer;
                if let Some(column) = seen_at(to as f32 - disparity, self.right.columns()) {
                    self.nearest.row_mut(to_row)[column] = disparity;
                }
            }
        }
    }
}

/// The column of an image that this place lies in, if it does.
fn seen_at(place: f32, columns: usize) -> Option<usize> {
    let column = place.round();
    // What is NaN is in no range.
    (0.0..columns as f32).contains(&column).then_some(column as usize)
}

impl Piece {
    /// One of a scene that could lie in another, by chance; `None` where it is no plane, or not seen by both cameras, or
    /// nobody knows what would be behind it.
    fn by_chance(from: &Scene, to: &Scene, random: &mut Random) -> Option<Self> {
        let (columns, rows) = from.truth.size();
        let width = WIDTHS.0 * (WIDTHS.1 / WIDTHS.0).powf(random.unit());
        let height = (width * random.between(HEIGHTS.0, HEIGHTS.1)).round() as usize;
        let width = width.round() as usize;
        let step = STEPS.0 * (STEPS.1 / STEPS.0).powf(random.unit());
        let is_round = random.chance(ROUND);
        let mut place =
            |size: usize, end: usize| Some(random.below(end.checked_sub(size).filter(|&n| n > 0)?));
        let [x, to_x] = [place(width, columns)?, place(width, columns)?];
        let [y, to_y] = [place(height, rows)?, place(height, rows)?];
        let rows = outline(x, y, width, height, is_round);
        let mut piece = Self {
            surface: Surface::of(from, &rows)?,
            rows,
            size: [width, height],
            moves: [to_x as isize - x as isize, to_y as isize - y as isize],
            nearer: 0.0,
        };
        let behind = piece.pixels().map(|(x, y)| piece.moved(x, y));
        let behind = behind.map(|(x, y)| to.truth.row(y)[x]).filter(|d| d.is_finite());
        let mut behind: Vec<f32> = behind.collect();
        behind.sort_by(f32::total_cmp);
        let median = behind.get(behind.len() / 2).filter(|_| behind.len() >= KNOWN)?;
        let middle = piece.surface.disparity(x + width / 2, y + height / 2);
        piece.nearer = (median + step as f32 - middle).round();
        Some(piece)
    }

    fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        pixels(&self.rows)
    }

    /// Where one of its pixels goes.
    fn moved(&self, x: usize, y: usize) -> (usize, usize) {
        let [across, down] = self.moves;
        ((x as isize + across) as usize, (y as isize + down) as usize)
    }
}

/// The rows of an ellipse or a box.
fn outline(
    x: usize,
    y: usize,
    width: usize,
    height: usize,
    is_round: bool,
) -> Vec<(usize, usize, usize)> {
    let half = 0.5 * width as f64;
    let rows = (0..height).filter_map(|row| {
        let off = if is_round { (2 * row + 1) as f64 / height as f64 - 1.0 } else { 0.0 };
        let reach = half * (1.0 - off * off).sqrt();
        let (first, end) = ((half - reach).round() as usize, (half + reach).round() as usize);
        (first < end).then(|| (y + row, x + first, x + end - 1))
    });
    rows.collect()
}

fn pixels(rows: &[(usize, usize, usize)]) -> impl Iterator<Item = (usize, usize)> + '_ {
    rows.iter().flat_map(|&(y, first, last)| (first..=last).map(move |x| (x, y)))
}

impl Surface {
    /// The plane that all known disparities within an outline lie on, if both cameras see all of it.
    fn of(scene: &Scene, rows: &[(usize, usize, usize)]) -> Option<Self> {
        let known = || {
            let known =
                pixels(rows).map(|(x, y)| [x as f64, y as f64, f64::from(scene.truth.row(y)[x])]);
            known.filter(|known| known[2].is_finite())
        };
        let count = known().count();
        if count < KNOWN {
            return None;
        }
        let mean = |i: usize| known().map(|known| known[i]).sum::<f64>() / count as f64;
        let means = [0, 1, 2].map(mean);
        let product = |i: usize, j: usize| -> f64 {
            known().map(|known| (known[i] - means[i]) * (known[j] - means[j])).sum()
        };
        let (xx, xy, yy, xd, yd) =
            (product(0, 0), product(0, 1), product(1, 1), product(0, 2), product(1, 2));
        let determinant = xx * yy - xy * xy;
        let (across, down) = ((xd * yy - yd * xy) / determinant, (yd * xx - xd * xy) / determinant);
        let at = means[2] - across * means[0] - down * means[1];
        let surface = Self { at: at as f32, across: across as f32, down: down as f32 };
        let is_flat = |known: [f64; 3]| {
            (surface.disparity(known[0] as usize, known[1] as usize) - known[2] as f32).abs()
                <= FLAT
        };
        let is_seen = |(x, y): (usize, usize)| {
            let disparity = surface.disparity(x, y);
            seen_at(x as f32 - disparity, scene.right.columns())
                .is_some_and(|column| scene.nearest.row(y)[column] <= disparity + SAME)
        };
        // Of what lies in a line no plane is a number, and flat.
        let is_plane = known().all(is_flat) && surface.across.abs() < STEEPEST;
        (is_plane && pixels(rows).all(is_seen)).then_some(surface)
    }

    fn disparity(&self, x: usize, y: usize) -> f32 {
        self.at + self.across * x as f32 + self.down * y as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A textured wall that leans, whose right view is exact but for rounding.
    fn wall() -> CaseData {
        let (columns, rows) = (200, 120);
        let grey = |x: f32, y: usize| {
            128.0 + 60.0 * (x / 2.3 + y as f32).sin() + 50.0 * (x / 5.1 - 0.7 * y as f32).sin()
        };
        let disparity = |y: usize| 6.0 + 0.05 * y as f32;
        let image = |of: &dyn Fn(usize, usize) -> f32| {
            Image::Grey8(Plane::from_fn(columns, rows, |x, y| of(x, y).round() as u8))
        };
        let left = image(&|x, y| grey(x as f32, y));
        let right = image(&|x, y| grey(x as f32 + disparity(y), y));
        let mut data = CaseData::new(left, right, DisparityRange::new(0, 30).unwrap());
        data.truth = Some(Plane::from_fn(columns, rows, |_, y| disparity(y)));
        data
    }

    #[test]
    fn both_cameras_see_an_obstacle_where_its_truth_says() {
        let before = wall();
        let after = lay(&before, &mut Random::new(1, "test")).unwrap();
        let obstacles = after.obstacles.as_ref().unwrap();
        let (left, right) = (after.left.to_grey_f32(), after.right.to_grey_f32());
        let truth = after.truth.as_ref().unwrap();
        let (mut covered, mut fits) = (0, 0);
        for (x, y) in BoundingBox::whole(200, 120).pixels() {
            let step = truth.row(y)[x] - obstacles.behind.row(y)[x];
            if obstacles.widths.row(y)[x] == 0 {
                assert_eq!(step, 0.0);
                continue;
            }
            // The median of what is behind is nearer by STEPS, a half more or less for whole pixels; it leans.
            assert!((NEARER..STEPS.1 as f32 + 2.0).contains(&step), "{step}");
            covered += 1;
            let place = x as f32 - truth.row(y)[x];
            let row = right.row(y);
            let [a, b] = [0, 1].map(|i| row[place.floor() as usize + i]);
            fits += usize::from((a + place.fract() * (b - a) - left.row(y)[x]).abs() < 25.0);
        }
        assert!(covered > 200 * 120 / 20, "{covered} pixels are covered");
        // At the ends of a piece the pixel beside it is another one.
        assert!(fits as f64 > 0.9 * covered as f64, "{fits} of {covered} fit");
    }

    #[test]
    fn nothing_is_laid_where_nothing_is_known() {
        let mut data = wall();
        data.truth = Some(Plane::filled(200, 120, f32::NAN));
        assert!(lay(&data, &mut Random::new(1, "test")).is_none());
        let small = Image::Grey8(Plane::filled(5, 5, 9));
        let mut data = CaseData::new(small.clone(), small, DisparityRange::new(0, 3).unwrap());
        data.truth = Some(Plane::filled(5, 5, 1.0));
        assert!(lay(&data, &mut Random::new(1, "test")).is_none());
    }
}
