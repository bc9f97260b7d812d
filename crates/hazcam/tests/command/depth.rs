//! `hazcam depth` on disparities whose depth is known.

use formats::Encoding;
use raster::{Image, Plane};
use serde_json::Value;

use crate::folder::{Folder, disparities};

/// Focal length times baseline is 200: depths of 4, 2, none, none and 20 m.
const CAMERA: &str = "--focal 1000 --baseline 0.2";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[50.0, 100.0, f32::NAN, 0.0, 10.0]);
    folder.disparities("sure.pfm", &[1.0, 0.2, 1.0, 1.0, 0.9]);
    folder
}

#[test]
fn how_far_depth_is_good_is_printed() {
    let outcome = folder().run(&format!("depth d.pfm {CAMERA}")).done();
    insta::assert_snapshot!(outcome.stdout);
    assert_eq!(outcome.stderr, "");
}

#[test]
fn without_a_map_it_tells_what_a_camera_can_do() {
    let folder = folder();
    let outcome = folder.run(&format!("depth {CAMERA} --disparity-error 0.5")).done();
    assert!(outcome.stdout.starts_with("camera  focal length 1000.00 px"), "{}", outcome.stdout);
    let good =
        "with 0.5 px, depth is good to 1 % up to 4.00 m, 5 % up to 20.00 m, 10 % up to 40.00 m";
    assert!(outcome.stdout.contains(good), "{}", outcome.stdout);
    let calibration = "cam0=[1000 0 320; 0 1000 900; 0 0 1]\ncam1=[1000 0 320; 0 1000 900; 0 0 1]\n\
                       doffs=0\nbaseline=200\n";
    std::fs::write(folder.path("calib.txt"), calibration).unwrap();
    let of_file = folder.run("depth --calibration calib.txt --disparity-error 0.5").done();
    assert_eq!((of_file.stdout, of_file.stderr), (outcome.stdout, String::new()));
    for (more, words) in [
        (format!("{CAMERA} -o depth.pfm"), "<DISPARITY>"),
        (String::new(), "depth needs a camera"),
        ("--calibration calib.txt --doffs 3".into(), "cannot be used with '--doffs <PX>'"),
        ("--calibration calib.txt --baseline 3".into(), "cannot be used with '--baseline <M>'"),
    ] {
        let told = folder.run(&format!("depth {more}"));
        assert!(told.stderr.contains(words), "{more}: {}", told.stderr);
    }
}

#[test]
fn guesses_are_told_of_where_nobody_leaves_them_out() {
    let folder = folder();
    let told = |more: &str| folder.run(&format!("depth d.pfm {CAMERA} {more}")).done().stderr;
    assert_eq!(told(""), "");
    let some = r#"{"matched": 0.6, "occluded-filled": 0.15, "mismatched-hole": 0.25}"#;
    folder.record("d.pfm", some);
    assert!(told("").contains("20.0 % of the disparities were filled in"), "{}", told(""));
    assert!(told("").starts_with("note: "), "{}", told(""));
    folder.record("d.pfm", r#"{"matched": 0.2, "mismatched-filled": 0.8}"#);
    assert!(told("").starts_with("warning: 80.0 % of the disparities"), "{}", told(""));
    folder.record("d.pfm", some);
    assert_eq!(told("--confidence sure.pfm --min-confidence 0.5"), "");
    // Guesses are as sure as that.
    let low = told("--confidence sure.pfm --min-confidence 0.05");
    assert!(low.contains("a --min-confidence above 0.05"), "{low}");
    folder.record("d.pfm", r#"{"matched": 1}"#);
    assert_eq!(told(""), "");
    for record in [&format!(r#"{{"reasons": {some}}}"#), "[1, 2", "{}"] {
        std::fs::write(folder.path("d.pfm.json"), record).unwrap();
        assert_eq!(told(""), "", "{record}");
    }
    // Somebody else writes a map in its place.
    folder.record("d.pfm", some);
    let found = disparities(folder.path("d.pfm"));
    formats::write_disparity(folder.path("d.pfm"), &found.map(|d| d + 1.0)).unwrap();
    assert_eq!(told(""), "");
}

#[test]
fn a_map_without_any_depth_is_warned_of() {
    let folder = folder();
    let told = folder.run(&format!("depth d.pfm {CAMERA} --max-depth 0.001")).done().stderr;
    assert!(told.starts_with("warning: d.pfm: no pixel has a depth: "), "{told}");
    assert!(told.contains(" are too far away; raise --max-depth"), "{told}");
}

#[test]
fn a_map_of_confidence_is_told_from_one_of_disparities() {
    let folder = Folder::new();
    folder.disparities("sure.pfm", &[0.5, 1.0, f32::NAN, 0.1]);
    let told = folder.run(&format!("depth sure.pfm {CAMERA}")).done().stderr;
    assert!(
        told.contains("all disparities lie between 0 and 1 px: is it a map of confidence"),
        "{told}"
    );
}

#[test]
fn a_disparity_of_0_has_no_depth_in_a_png_either() {
    let folder = Folder::new();
    folder.disparities("d.png", &[50.0, 0.0, f32::NAN, 10.0]);
    let json = folder.run(&format!("depth d.png {CAMERA} --json")).done().stdout;
    let reach: Value = serde_json::from_str(&json).unwrap();
    let counts = ["kept", "behind", "without_disparity"].map(|name| reach["pixels"][name].as_u64());
    assert_eq!(counts, [Some(2), Some(1), Some(1)], "{json}");
}

#[test]
fn pictures_that_use_few_of_their_bits_have_colours_too() {
    let folder = folder();
    let image = Image::Grey16(Plane::from_fn(5, 1, |x, _| 1000 * x as u16));
    formats::write_image(folder.path("dark.png"), &image).unwrap();
    let run = folder.run(&format!("depth d.pfm {CAMERA} --image dark.png --points p.ply")).done();
    assert!(
        run.stderr.contains("dark.png: of 16 bits the upper 4 are never used"),
        "{}",
        run.stderr
    );
    let points = std::fs::read(folder.path("p.ply")).unwrap();
    // The last pixel has 4000 of 4095, which is 250 of 255.
    assert_eq!(points[points.len() - 3..], [250, 250, 250]);
}

#[test]
fn the_right_image_of_a_pair_is_told_from_the_left_one() {
    let folder = folder();
    for (name, at) in [("l.png", 0), ("r.png", 2)] {
        let image = Image::Grey8(Plane::from_fn(40, 12, |x, y| ((x + at) * 83 % 97 + y) as u8));
        formats::write_image(folder.path(name), &image).unwrap();
    }
    folder.run("match l.png r.png -o m.pfm -m fast --max-disparity 5").done();
    let told = |image: &str| {
        let more = format!("--image {image} --points p.ply");
        folder.run(&format!("depth m.pfm {CAMERA} {more}")).done().stderr
    };
    let right = told("r.png");
    let words = "warning: r.png is the right image of the pair that m.pfm was matched from";
    assert!(right.contains(words) && right.contains("give l.png"), "{right}");
    assert!(!told("l.png").contains("the right image"));
    std::fs::remove_file(folder.path("m.pfm.json")).unwrap();
    assert!(!told("r.png").contains("the right image"));
}

#[test]
fn a_picture_of_uncertainties_says_how_far_it_reaches() {
    let folder = folder();
    // Z^2 e / 200: at 20 m 60 m, at 4 m 2.4 m.
    let written = format!("depth d.pfm {CAMERA} --uncertainty u.png --disparity-error");
    folder.run(&format!("{written} 30")).done();
    let reach = "depths of more than 18.1 m are off by more than the 65.535 m";
    folder.refuses(
        &format!("{written} 40"),
        &["--uncertainty u.png", reach, "the farthest is 20.0 m"],
    );
    folder.run(&format!("{written} 70 --max-depth 5")).done();
}

#[test]
fn depth_its_uncertainty_and_points_are_written() {
    let folder = folder();
    folder.image("left.png", 5, 1, 0);
    let run = folder.run(&format!(
        "depth d.pfm {CAMERA} --image left.png -o z.npy --uncertainty u.pfm --points p.ply --disparity-error 1 \
         --confidence sure.pfm --min-confidence 0.5 --max-depth 50 --json"
    ));
    let report: Value = serde_json::from_str(&run.done().stdout).unwrap();
    assert_eq!(report["pixels"]["kept"], 2);
    assert_eq!(report["pixels"]["unsure"], 1);
    assert_eq!(report["depth_m"]["most"], 20.0);
    let read = |name: &str| -> Plane<f32> {
        formats::read_disparity(folder.path(name), Encoding::Auto).unwrap().values
    };
    let (depth, error) = (read("z.npy"), read("u.pfm"));
    assert_eq!((depth.samples()[0], depth.samples()[4]), (4.0, 20.0));
    // Z^2 / 200.
    assert_eq!((error.samples()[0], error.samples()[4]), (0.08, 2.0));
    assert!(
        [1, 2, 3]
            .iter()
            .all(|&i: &usize| depth.samples()[i].is_nan() && error.samples()[i].is_nan())
    );
    let points = std::fs::read(folder.path("p.ply")).unwrap();
    assert!(points.starts_with(b"ply\n"));
    assert!(String::from_utf8_lossy(&points).contains("element vertex 2\n"));
}

#[test]
fn the_folder_of_a_picture_tells_its_camera_however_it_is_named() {
    let folder = folder();
    std::fs::create_dir(folder.path("image_2")).unwrap();
    folder.image("image_2/0.png", 5, 1, 0);
    let matrices = [("P0", 0.0), ("P1", -378.0), ("P2", 42.0), ("P3", -329.0)];
    let line = |(name, shift)| format!("{name}: 700 0 2 {shift} 0 700 0 0 0 0 1 0\n");
    std::fs::write(folder.path("calib.txt"), matrices.map(line).concat()).unwrap();
    // A picture that lies elsewhere belongs to the folder from which it is named.
    folder.image("stored.png", 5, 1, 0);
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.path("stored.png"), folder.path("image_2/1.png")).unwrap();
    let stored = if cfg!(unix) { "image_2/1.png" } else { "image_2/0.png" };
    for (from, image) in
        [("", "image_2/0.png"), ("", stored), ("image_2", "0.png"), ("image_2", "./0.png")]
    {
        let here = folder.path(from);
        let at = |name: &str| folder.path(name).into_os_string();
        let mut command = folder.command();
        command.current_dir(here).arg("depth").arg(at("d.pfm"));
        command.arg("--calibration").arg(at("calib.txt")).args(["--image", image]);
        let told = String::from_utf8(command.output().unwrap().stdout).unwrap();
        assert!(told.contains("baseline 0.5300 m"), "{from} {image}: {told}");
    }
}

#[test]
fn a_calibration_of_another_size_is_refused() {
    let folder = folder();
    let calibration = "cam0=[1000 0 2; 0 1000 0; 0 0 1]\ncam1=[1000 0 2; 0 1000 0; 0 0 1]\ndoffs=0\n\
                       baseline=200\nwidth=5\nheight=1\nndisp=100\n";
    std::fs::write(folder.path("calib.txt"), calibration).unwrap();
    folder.run("depth d.pfm --calibration calib.txt -o z.pfm").done();
    let of_kitti = "S_rect_00: 10 1\nP_rect_00: 700 0 2 0 0 700 0 0 0 0 1 0\n\
                    P_rect_01: 700 0 2 -378 0 700 0 0 0 0 1 0\n";
    let wide = calibration.replace("width=5", "width=10");
    for text in [&wide, &wide.replace("height=1\n", ""), of_kitti] {
        std::fs::write(folder.path("calib.txt"), text).unwrap();
        let outcome = folder.run("depth d.pfm --calibration calib.txt -o other.pfm");
        assert_eq!(outcome.status, 2);
        assert!(outcome.stderr.contains("calib.txt is for images of 10 x 1, but the map is 5 x 1"));
        assert!(!folder.names().contains(&"other.pfm".into()));
    }
}

#[test]
fn what_a_calibration_leaves_open_is_told() {
    let folder = folder();
    let colour = "P2: 700 0 2 42 0 700 0 0 0 0 1 0\nP3: 700 0 2 -329 0 700 0 0 0 0 1 0\n";
    let matrix = |shift: f64| {
        format!(
            "!!opencv-matrix\n   rows: 3\n   cols: 4\n   dt: d\n   data: [ 700., 0., 2., {shift},\n       \
             0., 700., 0., 0., 0., 0., 1., 0. ]\n"
        )
    };
    let opencv = format!("%YAML:1.0\n---\nP1: {}P2: {}", matrix(0.0), matrix(-84.0));
    let grey = colour.replace("P2", "P0").replace("P3", "P1");
    for (text, told) in [
        (
            format!("{grey}{}", colour.replace("-329", "-330")),
            "cameras 0 and 1, the grey ones, were assumed",
        ),
        (colour.to_owned(), ""),
        (opencv.replace("-84", "-84000"), "the baseline is 120 m, which is unusual"),
        (opencv, "the baseline of 0.12 is taken as metres"),
    ] {
        std::fs::write(folder.path("camera"), text).unwrap();
        let outcome = folder.run("depth d.pfm --calibration camera").done();
        assert!(outcome.stderr.contains(told), "{}", outcome.stderr);
        assert!(!told.is_empty() || outcome.stderr.is_empty(), "{}", outcome.stderr);
    }
}

#[test]
fn what_cannot_be_done_is_said_and_nothing_is_written() {
    let folder = folder();
    folder.disparities("small.pfm", &[1.0]);
    let grey = Plane::filled(5, 1, 200u8);
    formats::write_image(folder.path("sure.png"), &Image::Grey8(grey)).unwrap();
    let before = folder.names();
    for (arguments, expected) in [
        ("depth d.pfm", "give --calibration FILE, or --focal in pixels and --baseline in metres"),
        ("depth d.pfm --focal 1000", "--baseline"),
        ("depth d.pfm --focal -1 --baseline 0.2", "the camera's focal length in pixels is -1"),
        ("depth d.pfm --focal 9 --baseline 1 --max-depth 0", "give a number above 0"),
        ("depth d.pfm --focal 9 --baseline 1 --principal 4", "give a column and a row"),
        ("depth d.pfm --focal 9 --baseline 1 -o z.bmp", "use one of .pfm"),
        ("depth d.pfm --focal 9 --baseline 1 -o z.pfm --points z.pcd", "use one of .ply"),
        ("depth d.pfm --focal 9 --baseline 1 -o z.pfm --uncertainty ./z.pfm", "both name ./z.pfm"),
        ("depth d.pfm --focal 9 --baseline 1 -o d.pfm", "would replace an input"),
        ("depth d.pfm --focal 90000 --baseline 1 -o z.png", "millimetres holds 0 to 65.535 m"),
        (
            "depth d.pfm --focal 9 --baseline 1 --confidence small.pfm --min-confidence 0.5",
            "small.pfm is 1 x 1 but d.pfm is 5 x 1",
        ),
        (
            "depth d.pfm --focal 9 --baseline 1 --confidence sure.png --min-confidence 0.5",
            "sure.png holds no confidence: the pixel at column 0, row 0 is 200, but it must be from 0 to 1",
        ),
    ] {
        let outcome = folder.run(arguments);
        assert_eq!(outcome.status, 2, "{arguments}");
        assert!(outcome.stderr.contains(expected), "{arguments}: {}", outcome.stderr);
        assert_eq!(folder.names(), before, "{arguments}");
    }
}
