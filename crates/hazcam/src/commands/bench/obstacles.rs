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
/// All known disparities of a piece lie so near to one plane, in pixels; there are so many and at least this share of all,
/// and they are spread over so much of its width and height.
const FLAT: f32 = 0.5;
const KNOWN: usize = 6;
const SHARE: f64 = 0.1;
const SPREAD: f64 = 0.75;
/// A plane's disparity changes by less than so much from column to column and from row to row.
const STEEPEST: f32 = 0.5;
/// What is nearer by no more than this is the same surface, in pixels.
const SAME: f32 = 1.0;
/// Every pixel of a piece is nearer than what is behind it by at least so much.
const NEARER: f32 = 0.3;

/// The case with obstacles.
pub fn with_obstacles(case: Case) -> Case {
    let (id, purpose) = (format!("obstacles/{}", case.id), case.purpose);
    let mut laid = Case::rendered(id, move || {
        let data = case.load().map_err(|error| error.to_string())?;
        let mut random = Random::new(1, &case.id);
        lay(&data, &mut random).ok_or_else(|| {
            "no obstacle fits in: the image is small, or its known truth nowhere lies in a plane, or the disparities \
             to search leave nothing that is nearer"
                .to_owned()
        })
    });
    laid.purpose = purpose;
    laid
}

/// Grey images, the left one's truth, and what lies at each pixel of the right one: the largest disparity, or -infinity
/// where none is known.
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

/// Columns of a row, the last one included.
#[derive(Clone, Copy)]
struct Run {
    row: usize,
    first: usize,
    last: usize,
}

impl Run {
    fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        (self.first..=self.last).map(move |x| (x, self.row))
    }
}

/// Part of a scene that lies in a plane, and where it goes.
struct Piece {
    /// What the left image shows of it, from top to bottom, and the right one.
    runs: Vec<[Run; 2]>,
    size: [usize; 2],
    surface: Surface,
    /// By how many columns and rows it moves, and by how many pixels it comes nearer.
    moves: [isize; 2],
    nearer: isize,
}

/// A scene that obstacles are laid over.
struct Laid<'a> {
    scene: &'a Scene,
    images: [Plane<f32>; 2],
    truth: Plane<f32>,
    things: Plane<u32>,
    widths: Vec<usize>,
    /// Pixels of the right image that show one.
    taken: Plane<bool>,
}

/// A pair with truth and obstacles; `None` where not one can be laid.
fn lay(data: &CaseData, random: &mut Random) -> Option<CaseData> {
    let scene = Scene::new(data)?;
    let (columns, rows) = scene.truth.size();
    let mut laid = Laid {
        scene: &scene,
        images: [scene.left.clone(), scene.right.clone()],
        truth: scene.truth.clone(),
        things: Plane::filled(columns, rows, 0),
        widths: Vec::new(),
        taken: scene.nearest.map(|_| false),
    };
    let most = (COVERED * (columns * rows) as f64) as usize;
    let mut covered = 0;
    for _ in 0..TRIALS * most / (WIDTHS.0 * WIDTHS.1) as usize {
        if covered >= most {
            break;
        }
        if let Some(piece) = Piece::by_chance(&scene, random)
            && laid.has_room(&piece, data.range)
        {
            laid.add(&piece);
            covered += piece.pixels().count();
        }
    }
    if covered == 0 {
        return None;
    }
    let image =
        |grey: &Plane<f32>| Image::Grey8(grey.map(|grey| grey.round().clamp(0.0, 255.0) as u8));
    let [left, right] = laid.images.each_ref().map(image);
    let mut after = CaseData::new(left, right, data.range);
    (after.bounds, after.truth) = (data.bounds, Some(laid.truth));
    after.obstacles =
        Some(Obstacles { behind: scene.truth.clone(), things: laid.things, widths: laid.widths });
    after.protocol = data.protocol.clone();
    after.protocol.push("pieces of the scene lie before it; grey of 8 bits".into());
    Some(after)
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
}

impl Laid<'_> {
    /// Whether both cameras see all of a piece before what is behind it and beside all others, in the range.
    fn has_room(&self, piece: &Piece, range: DisparityRange) -> bool {
        let range = range.min() as f32..=range.max() as f32;
        // What is not known is not nearer.
        let is_behind = |other: f32, disparity: f32| other.is_nan() || other + NEARER <= disparity;
        piece.runs.iter().all(|[left, right]| {
            let disparity = |x: usize| piece.surface.disparity(x, left.row) + piece.nearer as f32;
            let left_fits = (left.first..=left.last).all(|x| {
                let (to, row) = piece.moved(x, left.row);
                let behind = self.scene.truth.row(row)[to];
                range.contains(&disparity(x))
                    && self.things.row(row)[to] == 0
                    && is_behind(behind, disparity(x))
            });
            let farthest = disparity(left.first).min(disparity(left.last));
            left_fits
                && (right.first..=right.last).all(|x| {
                    let to = piece.moved_in_right(x, right.row);
                    to.is_some_and(|(to, row)| {
                        let nearest = self.scene.nearest.row(row).get(to);
                        nearest.is_some_and(|&nearest| is_behind(nearest, farthest))
                            && !self.taken.row(row)[to]
                    })
                })
        })
    }

    /// Adds a piece that has room.
    fn add(&mut self, piece: &Piece) {
        let [left, right] = &mut self.images;
        self.widths.push(piece.size[0].min(piece.size[1]));
        for &[of_left, of_right] in &piece.runs {
            for x in of_left.first..=of_left.last {
                let (to, row) = piece.moved(x, of_left.row);
                left.row_mut(row)[to] = self.scene.left.row(of_left.row)[x];
                self.truth.row_mut(row)[to] =
                    self.scene.truth.row(of_left.row)[x] + piece.nearer as f32;
                self.things.row_mut(row)[to] = self.widths.len() as u32;
            }
            for x in of_right.first..=of_right.last {
                if let Some((to, row)) = piece.moved_in_right(x, of_right.row) {
                    right.row_mut(row)[to] = self.scene.right.row(of_right.row)[x];
                    self.taken.row_mut(row)[to] = true;
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
    /// One of a scene that may lie somewhere else in it, by chance; `None` where it is no plane, or not seen by both
    /// cameras, or nobody knows what would be behind it.
    fn by_chance(scene: &Scene, random: &mut Random) -> Option<Self> {
        let (columns, rows) = scene.truth.size();
        let width = WIDTHS.0 * (WIDTHS.1 / WIDTHS.0).powf(random.unit());
        let height = (width * random.between(HEIGHTS.0, HEIGHTS.1)).round() as usize;
        let width = width.round() as usize;
        let step = STEPS.0 * (STEPS.1 / STEPS.0).powf(random.unit());
        let is_round = random.chance(ROUND);
        let mut place =
            |size: usize, end: usize| Some(random.below(end.checked_sub(size).filter(|&n| n > 0)?));
        let [x, to_x] = [place(width, columns)?, place(width, columns)?];
        let [y, to_y] = [place(height, rows)?, place(height, rows)?];
        let outline = outline(x, y, width, height, is_round);
        let surface = Surface::of(scene, &outline, [width, height])?;
        let runs = outline.iter().map(|&run| Some([run, surface.seen(scene, run)?]));
        let mut piece = Self {
            runs: runs.collect::<Option<_>>()?,
            size: [width, height],
            surface,
            moves: [to_x as isize - x as isize, to_y as isize - y as isize],
            nearer: 0,
        };
        let behind = piece.pixels().map(|(x, y)| piece.moved(x, y));
        let behind = behind.map(|(x, y)| scene.truth.row(y)[x]).filter(|d| d.is_finite());
        let mut behind: Vec<f32> = behind.collect();
        behind.sort_by(f32::total_cmp);
        let median = behind.get(behind.len() / 2).filter(|_| behind.len() >= KNOWN)?;
        let middle = surface.disparity(x + width / 2, y + height / 2);
        piece.nearer = (median + step as f32 - middle).round() as isize;
        Some(piece)
    }

    fn pixels(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.runs.iter().flat_map(|[of_left, _]| of_left.pixels())
    }

    /// Where one of its pixels goes.
    fn moved(&self, x: usize, y: usize) -> (usize, usize) {
        let [across, down] = self.moves;
        ((x as isize + across) as usize, (y as isize + down) as usize)
    }

    /// The same in the right image, whose first column may lie beyond that.
    fn moved_in_right(&self, x: usize, y: usize) -> Option<(usize, usize)> {
        let [across, down] = self.moves;
        let to = usize::try_from(x as isize + across - self.nearer).ok()?;
        Some((to, (y as isize + down) as usize))
    }
}

/// The rows of an ellipse or a box.
fn outline(x: usize, y: usize, width: usize, height: usize, is_round: bool) -> Vec<Run> {
    let half = 0.5 * width as f64;
    let runs = (0..height).filter_map(|row| {
        let off = if is_round { (2 * row + 1) as f64 / height as f64 - 1.0 } else { 0.0 };
        let reach = half * (1.0 - off * off).sqrt();
        let (first, end) = ((half - reach).round() as usize, (half + reach).round() as usize);
        (first < end).then(|| Run { row: y + row, first: x + first, last: x + end - 1 })
    });
    runs.collect()
}

impl Surface {
    /// The plane that all known disparities within an outline of this size lie on.
    fn of(scene: &Scene, outline: &[Run], size: [usize; 2]) -> Option<Self> {
        let pixels = || outline.iter().flat_map(|run| run.pixels());
        let known = pixels().map(|(x, y)| [x as f64, y as f64, f64::from(scene.truth.row(y)[x])]);
        let known: Vec<[f64; 3]> = known.filter(|known| known[2].is_finite()).collect();
        let count = known.len() as f64;
        let extent = |i: usize| {
            let places = known.iter().map(|known| known[i]);
            places.clone().fold(f64::NEG_INFINITY, f64::max) - places.fold(f64::INFINITY, f64::min)
                + 1.0
        };
        let is_spread = (0..2).all(|i| extent(i) >= SPREAD * size[i] as f64);
        if known.len() < KNOWN || count < SHARE * pixels().count() as f64 || !is_spread {
            return None;
        }
        let mean = |i: usize| known.iter().map(|known| known[i]).sum::<f64>() / count;
        let means = [0, 1, 2].map(mean);
        let product = |i: usize, j: usize| -> f64 {
            known.iter().map(|known| (known[i] - means[i]) * (known[j] - means[j])).sum()
        };
        let (xx, xy, yy, xd, yd) =
            (product(0, 0), product(0, 1), product(1, 1), product(0, 2), product(1, 2));
        let determinant = xx * yy - xy * xy;
        let (across, down) = ((xd * yy - yd * xy) / determinant, (yd * xx - xd * xy) / determinant);
        let at = means[2] - across * means[0] - down * means[1];
        let surface = Self { at: at as f32, across: across as f32, down: down as f32 };
        let is_flat = |known: &[f64; 3]| {
            (surface.disparity(known[0] as usize, known[1] as usize) - known[2] as f32).abs()
                <= FLAT
        };
        // Of what lies in a line no plane is a number, and flat.
        let is_gentle = surface.across.abs() < STEEPEST && surface.down.abs() < STEEPEST;
        (is_gentle && known.iter().all(is_flat)).then_some(surface)
    }

    /// What the right image shows of a run, if all of it does.
    fn seen(&self, scene: &Scene, run: Run) -> Option<Run> {
        let Run { row, first, last } = run;
        let column = |x: usize| seen_at(x as f32 - self.disparity(x, row), scene.right.columns());
        let seen = Run { row, first: column(first)?, last: column(last)? };
        let nearest = self.disparity(first, row).max(self.disparity(last, row));
        let is_seen = |x: usize| scene.nearest.row(row)[x] <= nearest + SAME;
        (seen.first..=seen.last).all(is_seen).then_some(seen)
    }

    fn disparity(&self, x: usize, y: usize) -> f32 {
        self.at + self.across * x as f32 + self.down * y as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (200, 120);

    /// A wall with the grey of its columns, which lean by so much: the right view shows where each comes from.
    fn wall(across: f32, known: impl Fn(usize, usize) -> bool) -> CaseData {
        let (columns, rows) = SIZE;
        // Disparity 9 + across x + .05 y of column x is seen at column x - d.
        let disparity = |x: f32, y: usize| 9.0 + across * x + 0.05 * y as f32;
        let left = Image::Grey8(Plane::from_fn(columns, rows, |x, _| x as u8));
        let right = Image::Grey8(Plane::from_fn(columns, rows, |x, y| {
            let place = (x as f32 + disparity(0.0, y)) / (1.0 - across);
            place.round().clamp(0.0, 255.0) as u8
        }));
        let mut data = CaseData::new(left, right, DisparityRange::new(-90, 120).unwrap());
        data.truth = Some(Plane::from_fn(columns, rows, |x, y| {
            if known(x, y) { disparity(x as f32, y) } else { f32::NAN }
        }));
        data.protocol = vec!["drawn".into()];
        data
    }

    #[test]
    fn both_cameras_see_an_obstacle_where_its_truth_says() {
        let all = |_: usize, _: usize| true;
        let few = |x: usize, y: usize| (7 * x + 13 * y).is_multiple_of(4);
        for (across, known) in
            [(0.0, &all as &dyn Fn(usize, usize) -> bool), (0.3, &all), (-0.3, &all), (0.0, &few)]
        {
            let before = wall(across, known);
            let after = lay(&before, &mut Random::new(1, "test")).unwrap();
            let obstacles = after.obstacles.as_ref().unwrap();
            let [left, right] = [&after.left, &after.right].map(Image::to_grey_f32);
            let [truth, old] = [&after, &before].map(|data| data.truth.as_ref().unwrap());
            assert!(obstacles.behind.map(|d| d.to_bits()) == old.map(|d| d.to_bits()));
            assert_eq!(after.protocol[0], "drawn");
            let (mut covered, mut beside) = (0, 0);
            for (x, y) in BoundingBox::whole(SIZE.0, SIZE.1).pixels() {
                let (d, behind) = (truth.row(y)[x], old.row(y)[x]);
                if obstacles.things.row(y)[x] == 0 {
                    assert!(d.to_bits() == behind.to_bits() && left.row(y)[x] == x as f32);
                    continue;
                }
                covered += 1;
                // The median of what is behind is nearer by STEPS, a half more or less for whole pixels; both lean.
                let step = d - behind;
                assert!(step.is_nan() || (NEARER..STEPS.1 as f32 + 25.0).contains(&step), "{step}");
                if d.is_nan() {
                    continue;
                }
                // What is seen there comes from the same column, by rounding and as slopes stretch it.
                let seen = right.row(y)[(x as f32 - d).round() as usize];
                beside += usize::from((seen - left.row(y)[x]).abs() > 2.0);
            }
            assert!(covered > SIZE.0 * SIZE.1 / 30, "{covered} pixels are covered");
            // Halfway between two columns the end of a row may be either.
            assert!(100 * beside < covered, "{across}: {beside} of {covered} are not seen");
        }
    }

    #[test]
    fn nothing_is_laid_where_little_is_known() {
        for known in
            [|_: usize, _: usize| false, |x: usize, y: usize| (7 * x + 13 * y).is_multiple_of(29)]
        {
            assert!(lay(&wall(0.0, known), &mut Random::new(1, "test")).is_none());
        }
        let small = Image::Grey8(Plane::filled(5, 5, 9));
        let mut data = CaseData::new(small.clone(), small, DisparityRange::new(0, 3).unwrap());
        data.truth = Some(Plane::filled(5, 5, 1.0));
        assert!(lay(&data, &mut Random::new(1, "test")).is_none());
    }
}
