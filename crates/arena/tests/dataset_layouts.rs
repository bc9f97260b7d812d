//! Scenes are found by the layouts in which data sets are distributed, and by their catalogue.

use std::fs;
use std::path::Path;

use arena::dataset::{self, Case, DatasetError, Purpose};
use formats::{npy, write_disparity, write_image};
use raster::{Image, Plane};

const SIZE: (usize, usize) = (20, 10);

fn grey8(path: &Path, value: u8) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    write_image(path, &Image::Grey8(Plane::filled(SIZE.0, SIZE.1, value))).unwrap();
}

fn grey16(path: &Path, value: u16) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    write_image(path, &Image::Grey16(Plane::filled(SIZE.0, SIZE.1, value))).unwrap();
}

fn case<'a>(cases: &'a [Case], id: &str) -> &'a Case {
    let ids: Vec<_> = cases.iter().map(|case| case.id.as_str()).collect();
    cases.iter().find(|case| case.id == id).unwrap_or_else(|| panic!("{id} is not in {ids:?}"))
}

fn known(plane: &Plane<f32>) -> usize {
    plane.samples().iter().filter(|value| value.is_finite()).count()
}

#[test]
fn the_course_hand_out_with_its_boxes_and_ranges() {
    let root = tempfile::tempdir().unwrap();
    let at = |path: &str| root.path().join("rob501").join(path);
    for scene in ["cones", "teddy"] {
        grey8(&at(&format!("images/{scene}/{scene}_image_02.png")), 10);
        grey8(&at(&format!("images/{scene}/{scene}_image_06.png")), 10);
        grey8(&at(&format!("images/{scene}/{scene}_disp_02.png")), 40);
    }
    for side in ["image_0", "image_1", "colored_0", "colored_1"] {
        grey8(&at(&format!("images/kitti/{side}/000070_10.png")), 10);
    }
    grey16(&at("images/kitti/disp_occ/000070_10.png"), 512);
    grey16(&at("images/kitti/disp_noc/000070_10.png"), 0);
    grey8(&at("images/mars/spirit-01l.png"), 10);
    grey8(&at("images/mars/spirit-01r.png"), 10);
    fs::create_dir(at("data")).unwrap();
    for scene in ["cones_02", "teddy_02", "kitti_070"] {
        let bounds = Plane::new(2, 2, vec![3i32, 12, 1, 8]).unwrap();
        npy::write(at(&format!("data/{scene}_bounds.npy")), &bounds).unwrap();
    }

    let cases = dataset::open(root.path()).unwrap();
    let ids: Vec<_> = cases.iter().map(|case| case.id.as_str()).collect();
    assert_eq!(ids, ["course/cones", "course/teddy", "course/kitti", "course/mars/spirit-01"]);
    let cones = case(&cases, "course/cones");
    assert_eq!((cones.purpose, cones.family()), (Purpose::Test, "course"));
    let data = cones.load().unwrap();
    assert_eq!((data.range.min(), data.range.max()), (0, 55));
    assert_eq!(data.bounds.to_string(), "3,1,12,8");
    assert_eq!(data.truth.unwrap().samples()[0], 10.0);
    let kitti = case(&cases, "course/kitti").load().unwrap();
    assert_eq!((kitti.range.max(), kitti.truth.unwrap().samples()[0]), (150, 2.0));
    let names: Vec<_> = kitti.regions.iter().map(|region| region.name).collect();
    assert_eq!(names, ["non-occluded", "occluded"]);
    let non_occluded = kitti.regions[0].truth.as_ref().unwrap();
    assert_eq!(known(non_occluded), 0, "0 is no truth in a PNG");
    let mars = case(&cases, "course/mars/spirit-01");
    assert_eq!((mars.purpose, mars.has_truth()), (Purpose::Rover, false));
    let data = mars.load().unwrap();
    assert_eq!(data.range.max(), 5);
    assert!(data.protocol.iter().any(|line| line == "range: a quarter of the width"));
}

#[test]
fn middlebury_2005_is_scaled_by_its_size_and_cross_checked() {
    let root = tempfile::tempdir().unwrap();
    for size in ["ThirdSize", "HalfSize", "FullSize", "other"] {
        let at = |file: &str| root.path().join("middlebury2005").join(size).join("Art").join(file);
        grey8(&at("view1.png"), 9);
        grey8(&at("view5.png"), 9);
        grey8(&at("disp1.png"), 12);
        grey8(&at("disp5.png"), 12);
    }
    let cases = dataset::open(root.path()).unwrap();
    for (size, disparity) in [("ThirdSize", 4.0), ("HalfSize", 6.0), ("FullSize", 12.0)] {
        let case = case(&cases, &format!("middlebury2005/{size}/Art"));
        let data = case.load().unwrap();
        let truth_right = case.truth_right(&data).unwrap().unwrap();
        assert_eq!(truth_right.samples()[0], disparity);
        assert_eq!(data.truth.unwrap().samples()[0], disparity);
        assert_eq!(data.range.max(), disparity as i32);
        // The left strip is hidden from the right camera.
        let hidden = &data.regions[1];
        assert_eq!((hidden.name, hidden.mask.row(0)[0]), ("occluded", true));
        assert!(!hidden.mask.row(0)[SIZE.0 - 1]);
    }
    let other = case(&cases, "middlebury2005/other/Art");
    assert!(!other.has_truth());
    assert!(other.files().unwrap().unscaled.as_ref().unwrap().ends_with("other/Art/disp1.png"));
    // The root may be the folder that tells, and other exposures lie below the truth.
    let third = root.path().join("middlebury2005/ThirdSize");
    for image in ["view1.png", "view5.png"] {
        grey8(&third.join("Art/Illum1/Exp0").join(image), 5);
    }
    let cases = dataset::open(&third).unwrap();
    for id in ["Art", "Art/Illum1/Exp0"] {
        assert_eq!(case(&cases, id).load().unwrap().truth.unwrap().samples()[0], 4.0, "{id}");
    }
}

#[test]
fn middlebury_2001_and_2003_are_scaled_by_their_scenes() {
    let root = tempfile::tempdir().unwrap();
    for (scene, image, truth) in [
        ("cones", "png", "png"),
        ("TeddyH", "ppm", "pgm"),
        ("sawtooth", "ppm", "pgm"),
        ("kitchen", "png", "png"),
    ] {
        let at = |name: &str| root.path().join("middlebury").join(scene).join(name);
        for view in ["im2", "im6"] {
            let path = at(&format!("{view}.{image}"));
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            let colour = Image::Rgb8(Plane::filled(SIZE.0, SIZE.1, [9; 3]));
            write_image(path, &colour).unwrap();
        }
        for truth in [format!("disp2.{truth}"), format!("disp6.{truth}")] {
            grey8(&at(&truth), 16);
        }
    }
    let cases = dataset::open(root.path()).unwrap();
    for (scene, disparity, purpose) in [
        ("cones", 4.0, Purpose::Test),
        ("TeddyH", 8.0, Purpose::Test),
        ("sawtooth", 2.0, Purpose::Tuning),
    ] {
        let case = case(&cases, &format!("middlebury/{scene}"));
        let data = case.load().unwrap();
        assert_eq!(
            (data.truth.unwrap().samples()[0], case.purpose),
            (disparity, purpose),
            "{scene}"
        );
    }
    let other = case(&cases, "middlebury/kitchen");
    assert!(!other.has_truth() && other.files().unwrap().unscaled.is_some());
}

#[test]
fn both_years_of_kitti_may_lie_in_one_folder() {
    let root = tempfile::tempdir().unwrap();
    let at = |path: &str| root.path().join("training").join(path).join("000000_10.png");
    for view in ["image_0", "image_1", "image_2", "image_3"] {
        grey8(&at(view), 9);
    }
    grey16(&at("disp_occ_0"), 1024);
    let cases = dataset::open(root.path()).unwrap();
    let ids: Vec<_> = cases.iter().map(|case| (case.id.as_str(), case.has_truth())).collect();
    assert_eq!(ids, [("2012/000000", false), ("2015/000000", true)]);
    grey16(&at("disp_noc"), 512);
    let cases = dataset::open(root.path()).unwrap();
    let truth = |id| case(&cases, id).load().unwrap().truth.unwrap().samples()[0];
    assert_eq!((truth("2012/000000"), truth("2015/000000")), (2.0, 4.0));
}

#[test]
fn the_truth_of_eth3d_may_lie_beside_its_scenes() {
    let root = tempfile::tempdir().unwrap();
    let scenes = root.path().join("two_view_training");
    for image in ["im0.png", "im1.png"] {
        grey8(&scenes.join("delivery").join(image), 9);
    }
    let truth = root.path().join("two_view_training_gt/delivery");
    grey8(&truth.join("mask0nocc.png"), 255);
    write_disparity(truth.join("disp0GT.pfm"), &Plane::filled(SIZE.0, SIZE.1, 3.5f32)).unwrap();
    for root in [root.path(), &scenes] {
        let data = case(&dataset::open(root).unwrap(), "delivery").load().unwrap();
        assert_eq!((data.truth.unwrap().samples()[0], data.regions[0].name), (3.5, "non-occluded"));
    }
}

#[test]
fn middeval_and_eth3d_with_mask_and_calibration() {
    let root = tempfile::tempdir().unwrap();
    let at = |file: &str| root.path().join("MiddEval3/trainingQ/Pipes").join(file);
    grey8(&at("im0.png"), 9);
    grey8(&at("im1.png"), 9);
    grey8(&at("mask0nocc.png"), 255);
    let mut truth = Plane::filled(SIZE.0, SIZE.1, 3.5f32);
    truth.row_mut(0)[0] = f32::NAN;
    // Infinitely far, and known to be.
    truth.row_mut(0)[1] = 0.0;
    write_disparity(at("disp0GT.pfm"), &truth).unwrap();
    let calibration = "cam0=[100 0 9; 0 100 4; 0 0 1]\ncam1=[100 0 9; 0 100 4; 0 0 1]\ndoffs=0\n\
                       baseline=100\nwidth=20\nheight=10\nndisp=8\n";
    fs::write(at("calib.txt"), calibration).unwrap();
    let cases = dataset::open(root.path()).unwrap();
    let data = case(&cases, "MiddEval3/trainingQ/Pipes").load().unwrap();
    assert_eq!(data.range.max(), 7);
    assert_eq!(known(&data.truth.unwrap()), 199);
    assert!(data.regions[0].mask.samples().iter().all(|&both| both));
    assert!(data.protocol.contains(&"non-occluded where Pipes/mask0nocc.png is 255".to_owned()));
}

#[test]
fn kitti_2015_says_when_its_truth_is_non_occluded_only() {
    let root = tempfile::tempdir().unwrap();
    let at = |path: &str| root.path().join("kitti2015/training").join(path);
    for frame in ["000000_10.png", "000001_10.png"] {
        grey8(&at("image_2").join(frame), 9);
        grey8(&at("image_3").join(frame), 9);
        grey16(&at("disp_noc_0").join(frame), 1024);
    }
    grey8(&at("image_2/000000_11.png"), 9);
    grey16(&at("disp_occ_0/000000_10.png"), 1024);
    let cases = dataset::open(root.path()).unwrap();
    assert_eq!(cases.len(), 2);
    let both = case(&cases, "kitti2015/000000").load().unwrap();
    assert_eq!((both.range.max(), both.regions.len()), (4, 2));
    let noc = case(&cases, "kitti2015/000001").load().unwrap();
    assert_eq!(noc.regions.len(), 1);
    assert!(noc.protocol.contains(&"the truth holds non-occluded pixels only".to_owned()));
}

#[test]
fn frames_of_kitti_without_their_right_image_are_named_when_they_are_loaded() {
    let root = tempfile::tempdir().unwrap();
    let at = |path: &str| root.path().join("kitti2015/training").join(path);
    for frame in ["000000_10.png", "000001_10.png"] {
        grey8(&at("image_2").join(frame), 9);
        grey16(&at("disp_occ_0").join(frame), 1024);
    }
    grey8(&at("image_2/000002_10.png"), 9);
    for some in [false, true] {
        if some {
            grey8(&at("image_3/000000_10.png"), 9);
        }
        let cases = dataset::open(root.path()).unwrap();
        assert_eq!(cases.len(), 2, "one of the three has neither a right image nor truth");
        assert_eq!(case(&cases, "kitti2015/000000").load().is_ok(), some);
        let error = case(&cases, "kitti2015/000001").load().unwrap_err().to_string();
        assert!(error.contains("image_3/000001_10.png"), "{error}");
    }
}

#[test]
fn what_the_course_measures_with_is_a_test_in_the_data_sets_that_it_comes_from() {
    let root = tempfile::tempdir().unwrap();
    let frame = |folder: &str, sides: [&str; 2], frame: &str| {
        for side in sides {
            grey8(&root.path().join(format!("{folder}/training/{side}/{frame}_10.png")), 9);
        }
    };
    for number in ["000069", "000070"] {
        frame("kitti2012", ["image_0", "image_1"], number);
        frame("kitti2015", ["image_2", "image_3"], number);
    }
    for scene in ["Teddy", "Pipes"] {
        for image in ["im0.png", "im1.png"] {
            grey8(&root.path().join(format!("MiddEval3/trainingQ/{scene}/{image}")), 9);
        }
    }
    let cases = dataset::open(root.path()).unwrap();
    let tests = cases.iter().filter(|case| case.purpose == Purpose::Test);
    let tests: Vec<_> = tests.map(|case| case.id.as_str()).collect();
    assert_eq!(tests, ["MiddEval3/trainingQ/Teddy", "kitti2012/000070"]);
    assert_eq!(cases.len(), 6);
}

#[test]
fn a_catalogue_is_believed() {
    let root = tempfile::tempdir().unwrap();
    grey8(&root.path().join("a.png"), 9);
    grey8(&root.path().join("t.png"), 20);
    let mut truth = Plane::filled(SIZE.0, SIZE.1, 3.5f32);
    truth.row_mut(0)[1] = 0.0;
    write_disparity(root.path().join("t.pfm"), &truth).unwrap();
    let write = |text: &str| fs::write(root.path().join("scenes.json"), text).unwrap();
    write(
        r#"[{"id": "x/one", "use": "tuning", "left": "a.png", "right": "a.png", "truth": "t.png",
            "truth_encoding": "png8/4", "min_disparity": -2, "max_disparity": 6, "terms": "free"},
           {"id": "x/two", "use": "tuning", "left": "a.png", "right": "a.png", "truth": "t.pfm"},
           {"id": "course/cones", "use": "test", "left": "a.png", "right": "a.png"}]"#,
    );
    let cases = dataset::open(root.path()).unwrap();
    assert_eq!(cases[0].id, "course/cones", "the course's scenes come first");
    let data = case(&cases, "x/one").load().unwrap();
    assert_eq!((data.range.min(), data.range.max()), (-2, 6));
    assert_eq!(data.truth.unwrap().samples()[0], 5.0);
    let data = case(&cases, "x/two").load().unwrap();
    assert_eq!(known(&data.truth.unwrap()), 199, "0 is no truth in a catalogue");
    let beyond = |protocol: &[String]| protocol.iter().any(|line| line.starts_with("100.0 % of"));
    assert!(!beyond(&data.protocol));
    write(
        r#"[{"id": "x/far", "use": "tuning", "left": "a.png", "right": "a.png", "truth": "t.pfm",
            "max_disparity": 3}]"#,
    );
    let data = dataset::open(root.path()).unwrap()[0].load().unwrap();
    assert!(!beyond(&data.protocol), "a pixel beyond is still found: {:?}", data.protocol);
    write(
        r#"[{"id": "x/far", "use": "tuning", "left": "a.png", "right": "a.png", "truth": "t.pfm",
            "min_disparity": 5, "max_disparity": 9}]"#,
    );
    let data = dataset::open(root.path()).unwrap()[0].load().unwrap();
    assert!(beyond(&data.protocol), "{:?}", data.protocol);

    let pair = r#""left": "a.png", "right": "a.png""#;
    for (text, words) in [
        ("{".into(), "is no catalogue of scenes"),
        ("[]".into(), "it lists no scene"),
        (format!(r#"[{{"id": "x", "use": "play", {pair}}}]"#), "unknown variant `play`"),
        (format!(r#"[{{"id": "x", "use": "test", {pair}, "colour": 1}}]"#), "unknown field"),
        (format!(r#"[{{"id": "../x", "use": "test", {pair}}}]"#), "FAMILY/SCENE"),
        (
            format!(
                r#"[{{"id": "x", "use": "test", {pair}, "truth": "t.png", "truth_encoding": "png8"}}]"#
            ),
            "scene `x`: `png8` is not an encoding",
        ),
        (
            format!(r#"[{{"id": "x", "use": "test", {pair}, "max_disparity": -1}}]"#),
            "scene `x`: the disparity range 0 to -1 is empty",
        ),
        (
            format!(
                r#"[{{"id": "x", "use": "test", {pair}}}, {{"id": "x", "use": "test", {pair}}}]"#
            ),
            "`x` is there twice",
        ),
    ] {
        write(&text);
        let error = dataset::open(root.path()).unwrap_err().to_string();
        assert!(error.contains("scenes.json") && error.contains(words), "{error}");
    }
}

#[test]
fn files_that_do_not_belong_together_are_named() {
    let root = tempfile::tempdir().unwrap();
    let at = |file: &str| root.path().join("one").join(file);
    grey8(&at("im0.png"), 9);
    write_image(at("im1.png"), &Image::Grey8(Plane::filled(3, 3, 0))).unwrap();
    let error = dataset::open(root.path()).unwrap()[0].load().unwrap_err();
    assert!(matches!(error, DatasetError::SizesDiffer { .. }), "{error}");
    assert!(error.to_string().contains("im1.png is 3 x 3, but the left image is 20 x 10"));
    grey16(&at("im1.png"), 0);
    let error = dataset::open(root.path()).unwrap()[0].load().unwrap_err().to_string();
    let words = "im1.png is grey of 16 bits, but the left image is grey of 8 bits";
    assert!(error.contains(words), "{error}");
    fs::write(at("im1.png"), "not an image").unwrap();
    let error = dataset::open(root.path()).unwrap()[0].load().unwrap_err();
    assert!(error.to_string().contains("im1.png"), "{error}");
    let empty = tempfile::tempdir().unwrap();
    let error = dataset::open(empty.path()).unwrap_err().to_string();
    assert!(error.starts_with("no scene was found"), "{error}");
    let error = dataset::open(&empty.path().join("nothing")).unwrap_err().to_string();
    assert!(error.ends_with("is not a folder"), "{error}");
}

#[test]
fn a_box_that_leaves_the_images_is_named() {
    let root = tempfile::tempdir().unwrap();
    for side in ["left", "right"] {
        grey8(&root.path().join(format!("{side}.png")), 9);
    }
    let bounds = Plane::new(2, 2, vec![3i32, 20, 1, 8]).unwrap();
    npy::write(root.path().join("far.npy"), &bounds).unwrap();
    let scene = r#"{"id": "a", "left": "left.png", "right": "right.png", "box": "far.npy", "use": "tuning"}"#;
    fs::write(root.path().join("scenes.json"), format!("[{scene}]")).unwrap();
    let error = dataset::open(root.path()).unwrap()[0].load().unwrap_err().to_string();
    assert!(error.contains("far.npy: the box 3,1,20,8 leaves the image of 20 x 10"), "{error}");
}

#[test]
fn a_range_by_truth_begins_below_0_only_where_more_than_a_few_pixels_do() {
    let root = tempfile::tempdir().unwrap();
    grey8(&root.path().join("a.png"), 9);
    let scene =
        r#"{"id": "a", "left": "a.png", "right": "a.png", "truth": "t.pfm", "use": "tuning"}"#;
    fs::write(root.path().join("scenes.json"), format!("[{scene}]")).unwrap();
    for (below, least) in [(1, 0), (40, -19)] {
        let truth = |x: usize, y: usize| if x + SIZE.0 * y < below { -2e4 } else { 5.5f32 };
        let truth = Plane::from_fn(SIZE.0, SIZE.1, truth);
        write_disparity(root.path().join("t.pfm"), &truth).unwrap();
        let range = dataset::open(root.path()).unwrap()[0].load().unwrap().range;
        assert_eq!((range.min(), range.max()), (least, 6));
    }
}

#[test]
fn what_a_file_system_keeps_for_itself_holds_no_scenes() {
    let root = tempfile::tempdir().unwrap();
    for side in ["left", "right"] {
        grey8(&root.path().join("lost+found").join(format!("{side}.png")), 9);
    }
    assert!(matches!(dataset::open(root.path()), Err(DatasetError::NoScenes { .. })));
}

#[test]
fn two_scenes_by_one_id_are_named() {
    let root = tempfile::tempdir().unwrap();
    for folder in ["a/s", "a/training/s"] {
        grey8(&root.path().join(folder).join("im0.png"), 9);
        grey8(&root.path().join(folder).join("im1.png"), 9);
    }
    let error = dataset::open(root.path()).unwrap_err().to_string();
    for words in ["a/s/im0.png", "a/training/s/im0.png", "would both be the scene a/s"] {
        assert!(error.contains(words), "{error}");
    }
}

#[cfg(unix)]
#[test]
fn links_to_folders_are_no_files() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);
    fs::create_dir(at("folder")).unwrap();
    for name in ["left.png", "right.png"] {
        std::os::unix::fs::symlink(at("folder"), at(name)).unwrap();
    }
    assert!(matches!(dataset::open(root.path()), Err(DatasetError::NoScenes { .. })));
}

#[test]
fn real_data_is_read_where_there_is_some() {
    let Some(root) = std::env::var_os("HAZCAM_DATA") else {
        println!("not tested: HAZCAM_DATA is not set");
        return;
    };
    let cases = dataset::open(Path::new(&root)).unwrap();
    let mut families = Vec::new();
    for case in &cases {
        let data = case.load().unwrap_or_else(|error| panic!("{}: {error}", case.id));
        assert_eq!(data.truth.is_some(), case.has_truth());
        if !families.contains(&case.family()) {
            println!(
                "{}: {} to {}; {}",
                case.id,
                data.range.min(),
                data.range.max(),
                data.protocol.join("; ")
            );
            families.push(case.family());
        }
    }
}
