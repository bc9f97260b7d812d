//! What every matcher promises of its answers, on images of any size and ranges of any kind.

use matching::{Holes, Ingredient, Matcher, Options, Preset};
use raster::{BoundingBox, DisparityMap, DisparityRange, Image, Plane, Reason};

/// Texture that repeats nowhere nearby.
fn texture(x: i64, y: i64) -> u8 {
    let v = (x * 0x9E37 + y * 0x79B9).wrapping_mul(0x2545_F491_4F6C_DD1D);
    // Twice, or equal steps in x would be equal steps in the value.
    ((v ^ v >> 29).wrapping_mul(0x5851_F42D_4C95_7F2D) >> 40) as u8
}

/// Two views of a wall at this disparity.
fn wall(columns: usize, rows: usize, disparity: i64) -> [Image; 2] {
    [0, disparity].map(|shift| {
        Image::Grey8(Plane::from_fn(columns, rows, |x, y| texture(x as i64 + shift, y as i64)))
    })
}

fn options(preset: Preset, range: (i32, i32)) -> Options {
    let mut options = Options::new(preset, DisparityRange::new(range.0, range.1).unwrap());
    options.threads = 2;
    options
}

fn compute(
    options: Options,
    [left, right]: &[Image; 2],
    bounds: Option<BoundingBox>,
) -> DisparityMap {
    Matcher::new(options).unwrap().compute(left, right, bounds).unwrap().clone()
}

/// Every pixel of the box has a value in the range and a reason for it, every other one has none.
fn check_complete(preset: Preset, map: &DisparityMap, bounds: BoundingBox, range: (i32, i32)) {
    for y in 0..map.values.rows() {
        for x in 0..map.values.columns() {
            let (value, reason) = (map.values.row(y)[x], map.reasons.row(y)[x]);
            let sure = map.confidence.row(y)[x];
            if bounds.contains(x, y) {
                let inside = range.0 as f32 <= value && value <= range.1 as f32;
                assert!(inside, "{value} at {x}, {y}: outside {range:?}");
                assert!(reason.has_value(), "{reason:?} at {x}, {y}");
                assert!((0.0..=1.0).contains(&sure), "confidence {sure} at {x}, {y}");
                // Only where a judge has looked is anything known of what was filled.
                let is_known = reason == Reason::Matched || preset != Preset::Fast;
                assert!(is_known || sure == 0.0, "{preset} is sure of {reason:?}: {sure}");
            } else {
                assert!(value.is_nan() && reason == Reason::OutsideBox && sure == 0.0);
            }
        }
    }
}

#[test]
fn every_size_and_range_is_answered_completely() {
    let sizes = [(1, 1), (1, 9), (9, 1), (2, 3), (5, 5), (8, 30), (9, 9), (40, 6), (67, 33)];
    let ranges = [(0, 0), (0, 3), (0, 63), (0, 200), (-5, 5), (-40, -8), (7, 9), (50, 300)];
    for (columns, rows) in sizes {
        let images = wall(columns, rows, 3);
        let [Image::Grey8(left), Image::Grey8(right)] = &images else { unreachable!() };
        let deep = [left, right].map(|i| Image::Grey16(i.map(|&v| u16::from(v) * 257)));
        for (preset, range) in Preset::ALL.into_iter().flat_map(|p| ranges.map(|r| (p, r))) {
            // All of a range outside the images is refused.
            if !DisparityRange::new(range.0, range.1).unwrap().meets(columns) {
                continue;
            }
            let map = compute(options(preset, range), &images, None);
            check_complete(preset, &map, BoundingBox::whole(columns, rows), range);
            let of_16_bit = compute(options(preset, range), &deep, None);
            assert_eq!(of_16_bit.values, map.values, "{preset}, {columns} x {rows}, {range:?}");
        }
    }
}

#[test]
fn a_box_is_answered_inside_and_nowhere_else() {
    let images = wall(70, 40, 6);
    for (x0, y0, x1, y1) in [(0, 0, 69, 39), (20, 10, 60, 30), (69, 39, 69, 39), (0, 5, 3, 5)] {
        let bounds = BoundingBox::new(x0, y0, x1, y1).unwrap();
        let ranges = [(0, 15), (-20, 20), (0, 200)];
        for (preset, range) in Preset::ALL.into_iter().flat_map(|p| ranges.map(|r| (p, r))) {
            let map = compute(options(preset, range), &images, Some(bounds));
            check_complete(preset, &map, bounds, range);
        }
    }
    // Away from its border a box is a crop of the whole to what looks at windows alone.
    let bounds = BoundingBox::new(20, 10, 60, 30).unwrap();
    let (whole, part) = (
        compute(options(Preset::Fast, (0, 15)), &images, None),
        compute(options(Preset::Fast, (0, 15)), &images, Some(bounds)),
    );
    for y in 12..=28 {
        assert_eq!(whole.values.row(y)[22..=58], part.values.row(y)[22..=58], "row {y}");
    }
}

#[test]
fn a_wall_has_its_disparity() {
    let disparities = [-7, 0, 1, 8, 13];
    for (preset, disparity) in Preset::ALL.into_iter().flat_map(|p| disparities.map(|d| (p, d))) {
        let map = compute(options(preset, (-10, 15)), &wall(90, 40, disparity), None);
        let columns = 20..70;
        for y in 0..40 {
            for x in columns.clone() {
                let error = (map.values.row(y)[x] - disparity as f32).abs();
                assert!(error < 0.5, "{preset}, {disparity}: off by {error} at {x}, {y}");
                assert_eq!(map.reasons.row(y)[x], Reason::Matched);
            }
        }
    }
}

#[test]
fn images_that_show_nothing_or_not_the_same_are_answered_completely() {
    let (columns, rows) = (70, 30);
    let flat = |grey: u8| Plane::filled(columns, rows, grey);
    let noise = |seed: i64| {
        Plane::from_fn(columns, rows, |x, y| texture(x as i64 + 1000 * seed, y as i64 - 500 * seed))
    };
    let pairs = [
        [flat(0), flat(0)],
        [flat(255), flat(255)],
        [flat(0), flat(255)],
        [flat(9), noise(1)],
        [noise(1), flat(9)],
        [noise(1), noise(2)],
    ];
    let bounds = BoundingBox::whole(columns, rows);
    for pair in pairs {
        let images = pair.map(Image::Grey8);
        for (preset, range) in Preset::ALL.into_iter().flat_map(|p| [(p, (0, 31)), (p, (-9, 2))]) {
            let map = compute(options(preset, range), &images, None);
            check_complete(preset, &map, bounds, range);
        }
    }
}

#[test]
fn what_shows_nothing_is_not_matched_but_filled_from_around_it() {
    let (columns, rows) = (220, 80);
    let bounds = BoundingBox::whole(columns, rows);
    let blank = |grey: u8| Image::Grey8(Plane::filled(columns, rows, grey));
    // A wall with texture, but for a part of it.
    let half_blank = |x: i64, y: i64| {
        if (70..150).contains(&x) && (20..60).contains(&y) { 128 } else { texture(x, y) }
    };
    let pair = [0, 12].map(|shift| {
        Image::Grey8(Plane::from_fn(columns, rows, |x, y| half_blank(x as i64 + shift, y as i64)))
    });
    let compute_blank = |preset, range| {
        let matched = [0, 128, 255].map(|grey| {
            let map = compute(options(preset, range), &[blank(grey), blank(grey)], None);
            map.reasons.samples().iter().filter(|r| **r == Reason::Matched).count()
        });
        assert_eq!(matched, [0; 3], "{preset}, {range:?}");
    };
    for preset in Preset::ALL {
        // Of one, two or three disparities too, none of which has another one but its neighbours.
        for range in [(7, 7), (0, 1), (0, 2), (-1, 1)] {
            compute_blank(preset, range);
        }
    }
    for (preset, least) in Preset::ALL.into_iter().flat_map(|p| [(p, 0), (p, -5), (p, 4)]) {
        let range = (least, 40);
        compute_blank(preset, range);
        let map = compute(options(preset, range), &pair, None);
        check_complete(preset, &map, bounds, range);
        for y in 25..55 {
            for (x, found) in map.values.row(y)[50..200].iter().enumerate() {
                assert!((found - 12.0).abs() < 1.0, "{preset}, from {least}: {found} at {x}, {y}");
            }
        }
    }
}

#[test]
fn a_wall_of_tiles_is_not_sure() {
    let (columns, rows, disparity) = (200, 90, 30);
    let tiled = |period: i64| {
        [0, disparity].map(|shift| {
            Image::Grey8(Plane::from_fn(columns, rows, |x, y| {
                let (x, y) = (x as i64, y as i64);
                // Tiles of two samples each way, so that a fraction of a pixel is no other texture; noise of its own.
                let tile = texture((x + shift) % period / 2, y % 17 / 2) / 8 * 7;
                tile + texture(x + 1000 * (1 + shift), y) / 64
            }))
        })
    };
    let sure = |preset, period, range| {
        let map = compute(options(preset, range), &tiled(period), None);
        map.confidence.samples().iter().filter(|&&sure| sure >= 0.5).count()
    };
    for preset in Preset::ALL {
        for period in [8, 13, 22] {
            assert_eq!(sure(preset, period, (0, 63)), 0, "{preset}, {period} columns");
            // Where the range has one period alone, there is no doubt.
            let least = columns * rows / 2;
            let known = sure(preset, period, (disparity as i32 - 4, disparity as i32 + 3));
            assert!(known > least, "{preset}, {period} columns: {known}");
        }
    }
}

#[test]
fn the_left_strip_is_said_to_lie_outside_the_right_image() {
    for preset in Preset::ALL {
        let map = compute(options(preset, (0, 15)), &wall(90, 40, 12), None);
        for y in 0..40 {
            let strip = &map.reasons.row(y)[..11];
            let outside = strip.iter().all(|r| *r == Reason::OutsideRightFilled);
            assert!(outside, "{preset}, row {y}: {strip:?}");
        }
    }
}

#[test]
fn narrow_boxes_are_checked_against_all_that_the_right_image_shows() {
    for (disparity, range) in [(12, (0, 40)), (-12, (-40, 0)), (50, (0, 80)), (-50, (-80, 0))] {
        let pair = wall(300, 80, disparity);
        // At the end where the right image does not show what the left one does, and inside.
        for (preset, inside) in
            Preset::ALL.into_iter().flat_map(|preset| [(preset, false), (preset, true)])
        {
            for columns in [1, 4, 8, 12, 21] {
                let first = match () {
                    () if inside => 140,
                    () if disparity > 0 => 0,
                    () => 300 - columns,
                };
                let bounds = BoundingBox::new(first, 0, first + columns - 1, 79).unwrap();
                let map = compute(options(preset, range), &pair, Some(bounds));
                let pixels = map.values.samples().iter().zip(map.reasons.samples());
                let wrong = pixels.filter(|(d, reason)| {
                    let claimed = **reason == Reason::Matched || inside && reason.has_value();
                    claimed && (*d - disparity as f32).abs() > 1.0
                });
                assert_eq!(wrong.count(), 0, "{preset}, {range:?}, {bounds}");
            }
        }
    }
}

#[test]
fn where_hardly_anything_can_be_searched_pixels_say_what_lies_outside() {
    let pair = wall(64, 8, 3);
    for preset in Preset::ALL {
        for range in [(63, 127), (-127, -63)] {
            let map = compute(options(preset, range), &pair, None);
            for y in 0..8 {
                for x in 0..64 {
                    let right = x as f32 - map.values.row(y)[x];
                    let is_outside = !(0.0..=63.0).contains(&right);
                    let reason = map.reasons.row(y)[x];
                    assert_eq!(
                        reason == Reason::OutsideRightFilled,
                        is_outside,
                        "{preset}, {range:?}, column {x}: {reason:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_brighter_right_image_changes_nothing() {
    let darker =
        |shift: i64| Plane::from_fn(80, 30, |x, y| texture(x as i64 + shift, y as i64) / 2);
    let right = darker(5);
    let brighter = right.map(|&v| v + 100);
    for preset in Preset::ALL {
        let [plain, lit] = [&right, &brighter].map(|right| {
            let images = [darker(0), right.clone()].map(Image::Grey8);
            compute(options(preset, (0, 15)), &images, None)
        });
        assert_eq!(plain, lit, "{preset}");
    }
}

#[test]
fn kept_holes_are_the_filled_pixels() {
    // A near square hides part of the wall; noise below has no match.
    let grey = |x: i64, y: i64, shift: i64| match () {
        () if y > 30 => texture(x * 3 + shift * 1000, y),
        () if (40..60).contains(&(x + 9 * shift)) && (5..25).contains(&y) => {
            texture(x + 9 * shift, y + 500)
        }
        () => texture(x + 2 * shift, y),
    };
    let images = [0, 1]
        .map(|shift| Image::Grey8(Plane::from_fn(90, 40, |x, y| grey(x as i64, y as i64, shift))));
    for preset in Preset::ALL {
        let filled = compute(options(preset, (0, 15)), &images, None);
        let mut keep = options(preset, (0, 15));
        keep.holes = Holes::Keep;
        let kept = compute(keep, &images, None);
        let pairs = kept.values.samples().iter().zip(filled.values.samples());
        let reasons = kept.reasons.samples().iter().zip(filled.reasons.samples());
        let told = reasons.zip(kept.confidence.samples().iter().zip(filled.confidence.samples()));
        let mut holes = [0; 8];
        for ((kept, filled), ((reason, filled_reason), (sure, filled_sure))) in pairs.zip(told) {
            holes[*reason as usize] += 1;
            assert_eq!(reason.has_value(), !kept.is_nan());
            assert!(reason.has_value() || *sure == 0.0, "{preset} is sure of {reason:?}: {sure}");
            assert_eq!(reason.has_value(), *filled_reason == Reason::Matched);
            if reason.has_value() {
                assert_eq!((kept, sure), (filled, filled_sure));
            }
        }
        for reason in [Reason::Matched, Reason::OccludedHole, Reason::MismatchedHole] {
            assert!(holes[reason as usize] > 20, "{preset}: {reason:?}: {holes:?}");
        }
    }
}

#[test]
fn a_thin_thing_that_is_nearer_than_all_else_is_seen() {
    // Of disparity 100 alone before a wall of 10: a pole, and a beam that begins between two rows of a pair. What
    // a vehicle must not run into.
    let (columns, rows) = (420, 120);
    for (name, across, down) in [("pole", 260..268, 0..rows), ("beam", 200..380, 57..63)] {
        let views = [0, 1].map(|view| {
            Image::Grey8(Plane::from_fn(columns, rows, |x, y| {
                let is_near = across.contains(&(x + 100 * view)) && down.contains(&y);
                let (shift, below) = if is_near { (100, 5000) } else { (10, 0) };
                texture((x + shift * view) as i64, y as i64 + below)
            }))
        });
        for preset in [Preset::Balanced, Preset::Best] {
            let map = compute(options(preset, (0, 159)), &views, None);
            let near = down.clone().flat_map(|y| across.clone().map(move |x| (x, y)));
            let seen = near.filter(|&(x, y)| (map.values.row(y)[x] - 100.0).abs() < 2.0).count();
            let all = across.len() * down.len();
            assert!(seen * 10 > all * 8, "{preset} sees {seen} pixels of the {name}'s {all}");
        }
    }
}

#[test]
fn a_noisy_pair_is_matched_better_smoothed() {
    // A plane of gentle waves, seen by two noisy cameras.
    let (columns, rows, shift) = (200, 120, 12);
    let images = [0, 1].map(|view| {
        Image::Grey8(Plane::from_fn(columns, rows, |x, y| {
            let (u, v) = ((x + shift * view) as f32, y as f32);
            let waves =
                (0.41 * u + 0.2 * v).sin() + (0.33 * v - 0.27 * u).sin() + (0.013 * u * v).sin();
            let seen = |dx: i64| i64::from(texture(x as i64 + dx, y as i64 + 9000 * view as i64));
            let noise: i64 = (0..8).map(|i| seen(5000 * i) - 127).sum();
            (120.0 + 2.5 * waves + 0.04 * noise as f32).clamp(0.0, 255.0) as u8
        }))
    });
    let right = |without: &[Ingredient]| {
        let mut options = options(Preset::Balanced, (0, 31));
        options.without = without.to_vec();
        let map = compute(options, &images, None);
        let values = map.values.samples();
        values.iter().filter(|&&value| (value - shift as f32).abs() < 1.0).count()
    };
    let [smoothed, as_it_is] = [right(&[]), right(&[Ingredient::NoiseSmoothing])];
    let all = columns * rows;
    assert!(smoothed > as_it_is + all / 10, "{smoothed} and {as_it_is} of {all}");
}
