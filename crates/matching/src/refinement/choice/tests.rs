//! What the stages of a choice make together, held to definitions on a board before a wall.

use raster::Reason;

use super::judge::Layers;
use super::notes::Sources;
use super::reach::{NARROW, WIDE};
use super::strip::Strip;
use super::*;
use crate::Preset;
use crate::chance::Chance;

const COLUMNS: usize = 90;
const ROWS: usize = 40;
const FIRST: usize = 10;
const WIDTH: usize = 104;

/// All that a scene borrows: a board at 12 before a wall at 4, both of noise. Some columns of the
/// image are not mapped.
struct World {
    values: Plane<f32>,
    reasons: Plane<Reason>,
    doubtful: Plane<bool>,
    certainty: Plane<u8>,
    grey: [Plane<u8>; 2],
    right: Plane<f32>,
    strip: Strip,
}

fn truth(x: usize) -> f32 {
    if (40..64).contains(&x) { 12.0 } else { 4.0 }
}

impl World {
    fn new(values: Plane<f32>) -> Self {
        Self::textured(values, 200.0)
    }

    /// With noise of so many grey levels.
    fn textured(values: Plane<f32>, texture: f32) -> Self {
        let mut chance = Chance(3);
        let grey = Plane::from_fn(WIDTH + 20, ROWS, |_, _| (texture * chance.share()) as u8);
        let shade = |x: usize, y: usize, d: f32| grey.row(y)[x].saturating_add(4 * d as u8);
        let left = Plane::from_fn(WIDTH, ROWS, |x, y| shade(x, y, truth(x)));
        let right = Plane::from_fn(WIDTH, ROWS, |x, y| {
            let d = if (40..64).contains(&(x + 12)) { 12.0 } else { 4.0 };
            shade(x + d as usize, y, d)
        });
        let mut world = Self {
            reasons: values.map(|_| Reason::Matched),
            doubtful: values.map(|_| false),
            certainty: values.map(|_| CERTAIN / 2),
            grey: [left, right],
            right: Plane::from_fn(WIDTH, ROWS, |m, _| {
                let x = WIDTH - 1 - m;
                if (40..64).contains(&(x + 12)) { 12.0 } else { 4.0 }
            }),
            strip: Strip::default(),
            values,
        };
        world.see(&WIDE, &world.values.clone());
        world
    }

    /// Looks at the images again, and at what is known of the pixels; slopes are those of a map.
    fn see(&mut self, reach: &Reach, slopes_of: &Plane<f32>) {
        let level = Level::available()[0];
        let mut strip = Strip::default();
        let given = self.given();
        strip.look(level, &given, reach, self.values.size(), &(0..self.values.rows()));
        let rows = 0..self.values.rows();
        let Strip { slopes, grey, edges, notes, .. } = &mut strip;
        let (values, certainty, reasons) = (&self.values, &self.certainty, &self.reasons);
        let doubtful = &self.doubtful;
        slopes.compute(level, slopes_of, reach.every, rows);
        let sources = Sources { values, certainty, reasons, doubtful, grey, slopes, edges };
        notes.take(level, 0, sources);
        self.strip = strip;
    }

    fn given(&self) -> Given<'_> {
        Given {
            doubtful: &self.doubtful,
            grey: self.grey.each_ref().map(Plane::view),
            right: &self.right,
            first: FIRST,
            top: 0,
            least: 0.0,
            most: 20.0,
        }
    }

    fn scene<'a>(&'a self, given: &'a Given<'a>) -> Scene<'a> {
        Scene {
            values: &self.values,
            reasons: &self.reasons,
            certainty: &self.certainty,
            strip: &self.strip,
            given,
        }
    }

    /// What a judge makes of it, with its certainty.
    fn judged(
        &self,
        level: Level,
        judge: (&Reach, &Judge),
        threads: usize,
    ) -> (Plane<f32>, Plane<u8>) {
        self.judged_where(None, level, judge, threads)
    }

    /// The same where it moved.
    fn judged_where(
        &self,
        moved: Option<&Moved>,
        level: Level,
        judge: (&Reach, &Judge),
        threads: usize,
    ) -> (Plane<f32>, Plane<u8>) {
        let columns = self.values.columns();
        let (mut out, mut certainty) =
            (Plane::filled(columns, ROWS, 0.0), Plane::filled(columns, ROWS, 0));
        let mut workers: Vec<Worker> = (0..threads).map(|_| Worker::default()).collect();
        workers.iter_mut().for_each(|worker| worker.reset(columns, WIDTH));
        let given = self.given();
        let scene = self.scene(&given);
        let all = 0..ROWS;
        choose(level, judge, &scene, moved, all, &mut workers, &mut certainty, &mut out);
        (out, certainty)
    }
}

#[test]
fn what_is_known_of_a_pixel_beside_an_edge() {
    // The board has grown by four columns: pixel 66 of the image is the wall's.
    let mut world = World::new(Plane::from_fn(COLUMNS, ROWS, |x, _| {
        if (40..68).contains(&(x + FIRST)) { 12.0 } else { 4.0 }
    }));
    let (x, y) = (66 - FIRST, 20);
    world.reasons.row_mut(y)[x] = Reason::MismatchedFilled;
    world.doubtful.row_mut(y)[x] = true;
    world.see(&WIDE, &world.values.clone());
    let known = Known::of(Level::detect(), &world.scene(&world.given()), &WIDE, (x, y));
    let known = known.expect("there is a choice");
    let at = |d: f32| known.disparities.iter().position(|&other| other == d).unwrap();
    let (own, wall) = (at(12.0), at(4.0));
    assert_eq!(own, 0);
    // The wall lies 8 below: 0.4 for each of three pixels and 0.05 for each of all.
    assert_eq!([hint::APART, hint::FAR].map(|i| known.of_each[i][wall]), [-1.6, 1.6]);
    let sure = certainty::share(CERTAIN / 2);
    let from = [hint::CONFIDENCE, hint::FILLED, hint::DOUBT];
    assert_eq!(from.map(|i| known.of_each[i][own]), [sure, 1.0, 1.0]);
    assert_eq!(from.map(|i| known.of_each[i][wall]), [sure, 0.0, 0.0]);
    assert!(
        known.of_each[hint::CENSUS][wall] < known.of_each[hint::CENSUS][own],
        "the wall fits better"
    );
    assert_eq!(known.of_each[hint::CENSUS_HERE][wall], 0.0);
    // The right view says 4 where the wall's match lies.
    assert_eq!([hint::RIGHT_APART, hint::RIGHT_FAR].map(|i| known.of_each[i][wall]), [0.0, 0.0]);
    assert_eq!(
        [hint::ABOVE_SMALLEST, hint::BELOW_LARGEST].map(|i| known.of_each[i][wall]),
        [0.0, 1.6]
    );
    assert_eq!(known.of_each[hint::OUTSIDE], [0.0; 32]);
    assert_eq!(known.of_each[hint::CHANGES][0], 0.0);
    let mut edges = known.of_each[hint::CHANGES].iter().zip(&known.inside).skip(1);
    assert!(edges.all(|(&edges, &inside)| !inside || edges > 0.0), "all of it is noise");
    assert_eq!(known.of_pixel[..5], [sure, 0.0, 1.0, 0.0, 1.0]);
    let inside = known.inside.iter().filter(|&&inside| inside).count() as f32;
    assert!(inside < 32.0, "some lie above and below the map");
    let votes: f32 = known.of_each[hint::VOTES][wall] + known.of_each[hint::VOTES][own];
    assert!(votes > 1.5 && votes <= 3.0, "most say one or the other: {votes}");
}

/// Whether a pixel is not settled: by its reason, in doubt, or by the planes of its inner rings.
fn is_undecided(scene: &Scene<'_>, reach: &Reach, (x, y): (usize, usize)) -> bool {
    let (columns, rows) = scene.values.size();
    let mut planes = vec![scene.values.row(y)[x]];
    for place in &reach.places[..reach.inner] {
        let (u, v) = (x as i32 + place.columns, y as i32 + place.rows);
        if (0..columns as i32).contains(&u) && (0..rows as i32).contains(&v) {
            let (u, v) = (u as usize, v as usize);
            let slope = scene.strip.slopes.row(v)[u];
            let plane = scene.values.row(v)[u] - slopes::rise(slope, place.pixels(reach.every));
            planes.push(plane.clamp(scene.given.least, scene.given.most));
        }
    }
    planes.sort_by(f32::total_cmp);
    scene.reasons.row(y)[x] != Reason::Matched
        || scene.given.doubtful.row(y)[x]
        || planes[planes.len() - 1] - planes[0] > reach.settled
}

#[test]
fn marked_pixels_that_are_not_settled_are_found_at_every_level() {
    let mut chance = Chance(5);
    for (columns, reach) in
        [1, 3, 31, 32, 33, COLUMNS].into_iter().flat_map(|n| [(n, &NARROW), (n, &WIDE)])
    {
        let reach = &Reach { every: 1, ..*reach };
        // Parts lie above the range and parts below, where planes differ by nothing but what lies beyond it.
        let mut world = World::new(Plane::from_fn(columns, ROWS, |x, _| match x / 12 % 4 {
            0 => 25.0 + 9.0 * chance.share(),
            1 => -5.0 - 9.0 * chance.share(),
            _ if x % 7 == 0 => truth(x + FIRST) + 5.0 * chance.share(),
            _ => truth(x + FIRST),
        }));
        world.reasons = world.values.map(|_| match chance.below(20) {
            0 => Reason::OccludedFilled,
            _ => Reason::Matched,
        });
        world.doubtful = world.values.map(|_| chance.below(20) == 0);
        world.see(reach, &world.values.clone());
        let given = world.given();
        let scene = world.scene(&given);
        let (first, rows) = (11, 5);
        for nobody in [false, true] {
            let marks: Vec<bool> =
                (0..rows * columns).map(|_| !nobody && chance.below(3) > 0).collect();
            let places = (first..first + rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
            let expected: Vec<undecided::At> = (places.zip(&marks))
                .filter(|&(place, marked)| *marked && is_undecided(&scene, reach, place))
                .map(|((x, y), _)| [x as i32, y as i32])
                .collect();
            assert!(nobody || columns < 31 || !expected.is_empty());
            for level in Level::available() {
                let mut found = vec![[0; 2]; rows * columns];
                let count = undecided::undecided(level, &scene, reach, first, &marks, &mut found);
                assert_eq!(found[..count], expected, "{columns} columns, {}", level.name());
            }
        }
    }
}

#[test]
fn beyond_the_ends_of_the_map_its_rows_are_repeated() {
    let mut chance = Chance(7);
    let level = Level::detect();
    let mut world = World::new(Plane::from_fn(COLUMNS, ROWS, |_, _| 20.0 * chance.share()));
    world.certainty = world.values.map(|_| chance.bits(8) as u8);
    world.doubtful = world.values.map(|_| true);
    world.see(&WIDE, &world.values.clone());
    let mut outside = 0;
    for (y, x) in (0..ROWS).flat_map(|y| (0..COLUMNS).map(move |x| (y, x))) {
        let known = Known::of(level, &world.scene(&world.given()), &WIDE, (x, y)).unwrap();
        for (k, place) in WIDE.places.iter().enumerate() {
            let (column, row) = (x as i32 + place.columns, y as i32 + place.rows);
            let v = if (0..ROWS as i32).contains(&row) { row as usize } else { y };
            let u = column.clamp(0, COLUMNS as i32 - 1) as usize;
            let is_inside = (u as i32, v as i32) == (column, row);
            assert_eq!(known.inside[k], is_inside, "candidate {k} of ({x}, {y})");
            let sure = certainty::share(world.certainty.row(v)[u]);
            let [there, here] = [(u, v), (x, y)].map(|(x, y)| world.grey[0].row(y)[x + FIRST]);
            let shade = f32::from(there.abs_diff(here)) * 0.05;
            let found = [hint::CONFIDENCE, hint::SHADE].map(|hint| known.of_each[hint][k]);
            assert_eq!(found, [sure, shade], "candidate {k} of ({x}, {y})");
            outside += usize::from(!is_inside);
        }
    }
    assert!(outside > 10_000, "{outside} candidates come from beyond the ends");
}

#[test]
fn flat_ground_and_settled_matches_have_nothing_to_choose() {
    let has_choice = |world: &World, pixel| {
        Known::of(Level::detect(), &world.scene(&world.given()), &WIDE, pixel).is_some()
    };
    let flat = World::new(Plane::filled(COLUMNS, ROWS, 4.0));
    assert!(!has_choice(&flat, (30, 20)));
    // The edge is twelve columns away: only pixels that were filled, or in doubt, look that far.
    let mut world =
        World::new(Plane::from_fn(COLUMNS, ROWS, |x, _| if x < 40 { 4.0 } else { 12.0 }));
    assert!(!has_choice(&world, (52, 20)));
    world.doubtful.row_mut(20)[52] = true;
    world.see(&WIDE, &world.values.clone());
    assert!(has_choice(&world, (52, 20)));
}

/// A judge that was taught nothing.
fn judge_by_chance(reach: &Reach, layers: Layers, chance: &mut Chance) -> Judge {
    let numbers = Judge::numbers(reach, layers);
    Judge::new(reach, layers, (0..numbers).map(|_| chance.share() - 0.5))
}

#[test]
fn every_level_and_number_of_threads_chooses_the_same() {
    let mut chance = Chance(9);
    let narrow = Reach { every: 1, ..NARROW };
    let shapes = [
        (&narrow, Layers { context: 0, first: 16, second: 8 }),
        (&WIDE, Layers { context: 32, first: 32, second: 16 }),
    ];
    let judges = shapes.map(|(reach, layers)| (reach, judge_by_chance(reach, layers, &mut chance)));
    for (columns, (reach, judge)) in
        [3, 15, 17, 37, COLUMNS].into_iter().flat_map(|n| judges.iter().map(move |j| (n, j)))
    {
        let mut world = World::new(Plane::from_fn(columns, ROWS, |x, _| {
            truth(x + FIRST) + 3.0 * chance.share()
        }));
        for (i, reason) in world.reasons.samples_mut().iter_mut().enumerate() {
            *reason = [Reason::Matched, Reason::OccludedFilled, Reason::OutsideRightFilled][i % 3];
        }
        world.see(&WIDE, &world.values.clone());
        let choices = |level, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| world.judged(level, (*reach, judge), threads))
        };
        let expected = choices(Level::available()[0], 1);
        assert!(expected.0 != world.values, "nothing was chosen");
        for level in Level::available() {
            eprintln!("{columns} columns, level {}", level.name());
            assert!(choices(level, 2) == expected);
        }
    }
}

/// Every second column of every second row.
fn second<T: Clone>(plane: &Plane<T>) -> Plane<T> {
    let (columns, rows) = plane.size();
    let sample = |x: usize, y: usize| plane.row(2 * y)[2 * x].clone();
    Plane::from_fn(columns.div_ceil(2), rows.div_ceil(2), sample)
}

#[test]
fn of_every_second_pixel_is_known_what_would_be_of_all() {
    let mut chance = Chance(4);
    let level = Level::detect();
    // The same places, counted in pixels.
    let twice = |place: &reach::Place| reach::Place {
        columns: 2 * place.columns,
        rows: 2 * place.rows,
        ..*place
    };
    let places: Vec<_> = NARROW.places.iter().map(twice).collect();
    let wide = Reach { every: 1, places: Box::leak(places.into_boxed_slice()), ..NARROW };
    let values = Plane::from_fn(COLUMNS, ROWS, |x, _| truth(x + FIRST) + 9.0 * chance.share());
    let mut all = World::new(values);
    all.reasons = all.values.map(|_| match chance.bits(1) {
        0 => Reason::Matched,
        _ => Reason::OccludedFilled,
    });
    all.certainty = all.values.map(|_| chance.bits(8) as u8);
    all.doubtful = all.values.map(|_| chance.bits(1) > 0);
    let mut some = World::new(second(&all.values));
    some.grey = all.grey.clone();
    some.right =
        Plane::from_fn(all.right.columns(), some.values.rows(), |x, y| all.right.row(2 * y)[x]);
    some.reasons = second(&all.reasons);
    some.certainty = second(&all.certainty);
    some.doubtful = second(&all.doubtful);
    for (world, reach) in [(&mut all, &wide), (&mut some, &NARROW)] {
        // Between pixels nothing is known of slopes.
        world.see(reach, &world.values.map(|_| 5.0));
    }
    let mut known = 0;
    for (y, x) in (0..ROWS / 2).flat_map(|y| (0..COLUMNS / 2).map(move |x| (y, x))) {
        let of = |world: &World, reach, (x, y)| {
            let mut known = Known::of(level, &world.scene(&world.given()), reach, (x, y))?;
            // Nor of edges. What comes from outside the map does not count.
            for i in [hint::CHANGES, hint::VOTES_WITHOUT_EDGE] {
                known.of_each[i].fill(0.0);
            }
            for of_each in &mut known.of_each {
                let outside = of_each.iter_mut().zip(&known.inside).filter(|(_, inside)| !**inside);
                outside.for_each(|(hint, _)| *hint = 0.0);
            }
            Some(known)
        };
        let found = of(&some, &NARROW, (x, y));
        assert_eq!(found, of(&all, &wide, (2 * x, 2 * y)), "column {x}, row {y}");
        known += usize::from(found.is_some());
    }
    assert!(known > 500, "{known} pixels have a choice");
}

#[test]
fn only_those_are_asked_again_that_see_where_the_map_moved() {
    let mut chance = Chance(6);
    let judge = judge_by_chance(&WIDE, Layers { context: 0, first: 16, second: 8 }, &mut chance);
    let level = Level::detect();
    let values = Plane::from_fn(COLUMNS, ROWS, |x, _| truth(x + FIRST) + 3.0 * chance.share());
    let world = World::new(values);
    let all = world.judged(level, (&WIDE, &judge), 1);
    // One pixel has moved.
    let (x, y) = (40, 17);
    let mut before = world.values.clone();
    before.row_mut(y)[x] += 9.0;
    let mut moved = Moved::default();
    moved.find(level, &before, &world.values);
    let some = world.judged_where(Some(&moved), level, (&WIDE, &judge), 2);
    let mut asked = 0;
    for (v, u) in (0..ROWS).flat_map(|v| (0..COLUMNS).map(move |u| (v, u))) {
        let is = |place: &reach::Place| {
            (place.columns, place.rows) == (x as i32 - u as i32, y as i32 - v as i32)
        };
        let of = |(out, sure): &(Plane<f32>, Plane<u8>)| (out.row(v)[u], sure.row(v)[u]);
        let expected = match WIDE.places.iter().any(is) {
            true => of(&all),
            false => (world.values.row(v)[u], world.certainty.row(v)[u]),
        };
        assert_eq!(of(&some), expected, "pixel ({u}, {v})");
        asked += usize::from(WIDE.places.iter().any(is));
    }
    // Two places lie above and below the map.
    assert!(asked > 20, "{asked} pixels see that one");
}

#[test]
fn the_shipped_judges_give_back_what_was_filled_from_the_wrong_side() {
    // Where every pixel is a step away from the next, edges say nothing, and less is mended.
    for (texture, most) in [(60.0, 0.2), (200.0, 0.8)] {
        let grown = |x: usize| if (40..70).contains(&x) { 12.0 } else { 4.0 };
        let grown = Plane::from_fn(COLUMNS, ROWS, |x, _| grown(x + FIRST));
        let mut world = World::textured(grown, texture);
        for y in 0..ROWS {
            world.reasons.row_mut(y)[64 - FIRST..70 - FIRST].fill(Reason::OccludedFilled);
            world.certainty.row_mut(y)[64 - FIRST..70 - FIRST].fill(0);
        }
        world.see(&WIDE, &world.values.clone());
        let wrong = |values: &Plane<f32>| {
            let rows = 5..ROWS - 5;
            let pixels = rows.flat_map(|y| (0..COLUMNS).map(move |x| (x, y)));
            pixels.filter(|&(x, y)| (values.row(y)[x] - truth(x + FIRST)).abs() > 2.0).count()
        };
        for preset in [Preset::Balanced, Preset::Best] {
            let jury = Jury::of(preset);
            // Every pixel is asked.
            let reach = Reach { every: 1, ..*jury.reach };
            let judge = (&reach, &jury.judges[0]);
            let (out, _) = world.judged(Level::detect(), judge, 1);
            let [before, after] = [&world.values, &out].map(wrong);
            eprintln!("{preset}, texture {texture}: of {before} wrong pixels {after} are left");
            assert!((after as f32) < most * before as f32, "{preset}: {after} of {before}");
        }
    }
}
