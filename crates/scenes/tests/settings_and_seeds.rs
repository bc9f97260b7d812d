//! A seed is a scene: the same bits everywhere and for any number of threads, another seed another
//! scene; and each setting does what it says and nothing else.

use raster::{Image, Plane};
use scenes::{Channels, Depth, Kind, Scene, Settings, demo_scenes, render, stress_scenes};

fn tiny(kind: Kind, seed: u64) -> Settings {
    let mut settings = Settings::new(kind, seed);
    (settings.columns, settings.rows, settings.max_disparity) = (96, 72, 20);
    settings
}

fn rendered(change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = tiny(Kind::Cards, 4);
    change(&mut settings);
    render(&settings).unwrap()
}

/// FNV-1a (Fowler, Noll & Vo) over bytes.
fn fnv(hash: u64, bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes
        .into_iter()
        .fold(hash, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

fn checksum(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325;
    for image in [&scene.left, &scene.right] {
        let Image::Rgb8(plane) = image else { panic!("8-bit colour is the default") };
        hash = fnv(hash, plane.samples().as_flattened().iter().copied());
    }
    for truth in [&scene.truth_left, &scene.truth_right] {
        hash = fnv(hash, truth.samples().iter().flat_map(|d| d.to_bits().to_le_bytes()));
    }
    let hard = [&scene.discontinuity, &scene.textureless, &scene.thin, &scene.repeated];
    for mask in [&scene.occluded].into_iter().chain(hard) {
        hash = fnv(hash, mask.samples().iter().map(|&set| u8::from(set)));
    }
    hash
}

/// Scenes are the same bits on every machine. When a scene is changed on purpose, these numbers
/// change with it, and published scores of rendered scenes with them.
#[test]
fn scenes_are_the_same_bits_on_every_machine() {
    let found = Kind::NAMED.map(|kind| checksum(&render(&tiny(kind, 1)).unwrap()));
    let plane = Kind::Plane { offset: 5.5, per_column: 0.02, per_row: 0.1 };
    let found = [&found[..], &[checksum(&render(&tiny(plane, 1)).unwrap())]].concat();
    let expected: [u64; 5] = [
        0x5a3f_7ca2_7470_0f43,
        0xe6d2_cb6f_3b22_4243,
        0xc1ac_f3fa_f922_47f9,
        0x1049_2727_edf9_a78c,
        0x0723_e151_3bfd_ac23,
    ];
    assert_eq!(found, expected, "found {found:#018x?}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let settings = tiny(Kind::Clutter, 9);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| render(&settings).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn every_seed_is_another_scene() {
    for kind in Kind::NAMED {
        let [a, b] = [1, 2].map(|seed| render(&tiny(kind, seed)).unwrap());
        assert_ne!(a.left, b.left, "{kind}");
        assert_ne!(a.truth_left, b.truth_left, "{kind}");
        assert_ne!(a.name, b.name, "{kind}");
    }
}

fn mean(image: &Image) -> f64 {
    let Image::Rgb8(plane) = image else { panic!("8-bit colour is the default") };
    let samples = plane.samples().as_flattened();
    samples.iter().map(|&v| f64::from(v)).sum::<f64>() / samples.len() as f64
}

#[test]
fn what_is_asked_of_the_right_camera_leaves_the_left_one_alone() {
    let plain = rendered(|_| ());
    for (change, brighter) in [
        ((|s| s.right_exposure = 0.5) as fn(&mut Settings), false),
        (|s| s.right_exposure = 1.5, true),
        (|s| s.right_gain = 0.7, false),
        (|s| s.right_gamma = 1.6, false),
        (|s| s.right_gamma = 0.6, true),
    ] {
        let changed = rendered(change);
        assert_eq!(changed.left, plain.left);
        assert_eq!(changed.truth_left, plain.truth_left);
        assert_eq!(mean(&changed.right) > mean(&plain.right) + 5.0, brighter);
        assert_eq!(mean(&changed.right) < mean(&plain.right) - 5.0, !brighter);
    }
}

#[test]
fn noise_exposure_and_depth_leave_the_truth_alone() {
    let plain = rendered(|_| ());
    for change in [
        (|s| s.noise = 12.0) as fn(&mut Settings),
        |s| s.exposure = 4.0,
        |s| s.depth = Depth::Sixteen,
        |s| s.channels = Channels::Grey,
    ] {
        let changed = rendered(change);
        assert_ne!(changed.left, plain.left);
        assert_eq!(changed.truth_left, plain.truth_left);
        assert_eq!(changed.occluded, plain.occluded);
    }
}

#[test]
fn without_contrast_nothing_has_texture_and_much_light_saturates() {
    let blank = rendered(|s| s.contrast = 0.0);
    let share = |mask: &Plane<bool>| {
        mask.samples().iter().filter(|&&set| set).count() as f64 / mask.samples().len() as f64
    };
    let plain = rendered(|_| ());
    assert!(share(&blank.textureless) > 0.95 && share(&plain.textureless) < 0.3);
    let Image::Rgb8(bright) = rendered(|s| s.exposure = 16.0).left else { panic!("8-bit colour") };
    let full = bright.samples().iter().filter(|v| **v == [255; 3]).count();
    assert!(full > bright.samples().len() / 4, "{full}");
}

#[test]
fn every_extreme_size_and_range_is_rendered() {
    for (columns, rows, min, max) in [
        (1, 1, 0, 0),
        (1, 9, 0, 5),
        (9, 1, 0, 64),
        (3, 2, -4, -4),
        (40, 30, 0, 511),
        (7, 5, -30, 0),
    ] {
        for kind in Kind::NAMED {
            let mut settings = Settings::new(kind, 1);
            (settings.columns, settings.rows) = (columns, rows);
            (settings.min_disparity, settings.max_disparity) = (min, max);
            let scene = render(&settings).unwrap();
            assert_eq!(scene.left.size(), (columns, rows));
            assert_eq!((scene.range.min(), scene.range.max()), (min, max));
            let inside = |d: &f32| (min as f32..=max as f32).contains(d);
            assert!(scene.truth_left.samples().iter().all(inside), "{kind} {columns} x {rows}");
        }
    }
}

#[test]
fn what_cannot_be_rendered_is_refused_by_name() {
    for (change, field, words) in [
        ((|s| s.columns = 0) as fn(&mut Settings), "columns", "from 1 to 16384"),
        (|s| s.rows = 20_000, "rows", "from 1 to 16384"),
        (|s| (s.columns, s.rows) = (16_384, 16_384), "rows", "at most 4096"),
        (|s| s.max_disparity = -1, "max_disparity", "at least min_disparity, which is 0"),
        (|s| s.max_disparity = 9000, "max_disparity", "from -8192 to 8192"),
        (|s| s.noise = f64::NAN, "noise", "from 0 to 128"),
        (|s| s.contrast = 1.1, "contrast", "from 0 to 1"),
        (|s| s.right_gamma = 0.0, "right_gamma", "from 0.1 to 10"),
        (|s| s.vertical_offset = 65.0, "vertical_offset", "from -64 to 64"),
        (
            |s| s.kind = Kind::Plane { offset: 60.0, per_column: 0.5, per_row: 0.0 },
            "offset",
            "must lie within",
        ),
    ] {
        let mut settings = tiny(Kind::Cards, 1);
        change(&mut settings);
        let error = render(&settings).unwrap_err();
        assert_eq!(error.field, field);
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn the_shared_sets_can_be_rendered_and_their_names_differ() {
    let demo = demo_scenes().into_iter().map(|settings| (settings.name(), settings));
    for set in [demo.collect(), stress_scenes()] {
        let mut names: Vec<&str> = set.iter().map(|(name, _)| name.as_str()).collect();
        for (name, settings) in &set {
            settings.check().unwrap_or_else(|error| panic!("{name}: {error}"));
        }
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
