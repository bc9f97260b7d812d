//! `hazcam match` on pairs that it must answer.

use std::process::Stdio;

use raster::{Image, Plane};
use serde_json::Value;

use crate::folder::{Folder, disparities};

fn sidecar(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.path(name)).unwrap()).unwrap()
}

/// The share of values within one pixel of 3, right of the strip that only the left camera sees.
fn share_at_three(map: &Plane<f32>) -> f64 {
    let right: Vec<f32> = (0..map.rows()).flat_map(|y| map.row(y)[3..].to_vec()).collect();
    right.iter().filter(|v| (*v - 3.0).abs() <= 1.0).count() as f64 / right.len() as f64
}

#[test]
fn every_matcher_finds_a_wall_and_records_what_it_did() {
    let folder = Folder::with_pair(64, 40);
    for matcher in ["fast", "balanced", "best"] {
        let outcome = folder
            .run(&format!("match left.png right.png -o d.pfm --matcher {matcher} -d 12"))
            .done();
        assert_eq!(outcome.stdout, "", "the answer is in the file");
        assert!(outcome.stderr.contains("disparities 0 to 12"), "{}", outcome.stderr);
        let map = disparities(folder.path("d.pfm"));
        assert_eq!(map.size(), (64, 40));
        assert!(map.samples().iter().all(|v| (0.0..=12.0).contains(v)), "all filled");
        assert!(share_at_three(&map) > 0.95, "{matcher}: {}", share_at_three(&map));

        let record = sidecar(&folder, "d.pfm.json");
        assert_eq!(record["options"]["matcher"], matcher);
        assert_eq!(record["options"]["box"], "0,0,63,39");
        assert_eq!(record["left"]["sha256"].as_str().unwrap().len(), 64);
        assert!(record["time"]["wall_s"].as_f64().unwrap() >= 0.0);
        let shares: f64 =
            record["reasons"].as_object().unwrap().values().map(|v| v.as_f64().unwrap()).sum();
        assert!((shares - 1.0).abs() < 1e-9);
    }
}

/// Makes other images of both of a pair, which are grey and of 8 bits.
fn remake(folder: &Folder, change: impl Fn(&str, Plane<u8>) -> Image) {
    for name in ["left.png", "right.png"] {
        let Image::Grey8(image) = formats::read_image(folder.path(name)).unwrap() else {
            panic!("the wall is grey");
        };
        formats::write_image(folder.path(name), &change(name, image)).unwrap();
    }
}

#[test]
fn vertical_disparity_is_mended_told_and_recorded() {
    let folder = Folder::with_pair(200, 122);
    // The right image begins two rows lower, so that all of it stands two rows higher.
    remake(&folder, |name, image| {
        let top = if name == "left.png" { 0 } else { 2 };
        Image::Grey8(Plane::from_fn(200, 120, |x, y| image.row(y + top)[x]))
    });
    for matcher in ["balanced", "best"] {
        let arguments = format!("match left.png right.png -o d.pfm -d 12 --matcher {matcher}");
        let outcome = folder.run(&arguments).done();
        let told = "right.png: things stand up to 2.0 px higher or lower than on the left";
        assert!(outcome.stderr.contains(told), "{}", outcome.stderr);
        let map = disparities(folder.path("d.pfm"));
        assert!(share_at_three(&map) > 0.95, "{matcher}: {}", share_at_three(&map));
        let recorded = &sidecar(&folder, "d.pfm.json")["vertical_disparity"];
        for field in ["root_mean_square", "largest"] {
            assert!((recorded[field].as_f64().unwrap() - 2.0).abs() < 0.05, "{recorded}");
        }
        let coefficients = &recorded["coefficients"];
        for (field, expected) in
            [("constant", -2.0), ("x", 0.0), ("y", 0.0), ("xy", 0.0), ("yy", 0.0), ("xx", 0.0)]
        {
            let off = coefficients[field].as_f64().unwrap() - expected;
            assert!(off.abs() < 0.2, "{field}: {recorded}");
        }
    }
    let folder = Folder::with_pair(200, 120);
    let outcome = folder.run("match left.png right.png -o d.pfm -d 12").done();
    assert!(!outcome.stderr.contains("higher or lower"), "{}", outcome.stderr);
    assert_eq!(sidecar(&folder, "d.pfm.json")["vertical_disparity"], Value::Null);
}

#[test]
fn few_of_16_bits_are_told_and_widened_on_request() {
    // As a camera of 10 bits gives a dark scene: it uses 6.
    let folder = Folder::with_pair(64, 40);
    remake(&folder, |_, image| Image::Grey16(image.map(|&v| u16::from(v) / 4)));
    let outcome = folder.run("match left.png right.png -o faint.pfm -d 12 -m fast").done();
    let told = "left.png and right.png: of 16 bits the upper 10 are never used";
    assert!(outcome.stderr.contains(told), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("say --bits 6"), "{}", outcome.stderr);
    assert_eq!(sidecar(&folder, "faint.pfm.json")["options"]["bits"], Value::Null);
    let outcome = folder.run("match left.png right.png -o d.pfm -d 12 -m fast --bits 10").done();
    assert!(!outcome.stderr.contains("never used"), "{}", outcome.stderr);
    assert_eq!(sidecar(&folder, "d.pfm.json")["options"]["bits"], 10);
    let [faint, widened] =
        ["faint.pfm", "d.pfm"].map(|name| share_at_three(&disparities(folder.path(name))));
    assert!(widened > 0.95 && widened > faint, "{faint} of the wall, then {widened}");

    let folder = Folder::with_pair(64, 40);
    remake(&folder, |_, image| Image::Grey16(image.map(|_| 0)));
    let outcome = folder.run("match left.png right.png -o d.pfm -d 12 -m fast").done();
    assert!(!outcome.stderr.contains("--bits"), "{}", outcome.stderr);
}

#[test]
fn the_recorded_hash_is_that_of_the_file() {
    let folder = Folder::with_pair(16, 16);
    std::fs::write(folder.path("left.pgm"), b"P5 3 1 255\nabc").unwrap();
    folder.run("match left.pgm left.pgm -o d.npy -d 1").done();
    // From `sha256sum`.
    assert_eq!(
        sidecar(&folder, "d.npy.json")["left"]["sha256"],
        "5ce6bf4d1d6c40fdf30467e4dc29d165efbda02b361be8eeb9046fd7c2a41253"
    );
    // Filled pixels are told of where the record is that of the map.
    let stderr = folder.run("depth d.npy --focal 700 --baseline 0.1 --doffs 1").done().stderr;
    assert!(stderr.contains("were filled in without a match"), "{stderr}");
}

#[test]
fn the_format_follows_the_extension() {
    let folder = Folder::with_pair(32, 20);
    folder.run("match left.png right.png -o d.pfm -d 8").done();
    let expected = disparities(folder.path("d.pfm"));
    for name in ["d.npy", "d.tiff"] {
        folder.run(&format!("match left.png right.png -o {name} -d 8")).done();
        assert_eq!(disparities(folder.path(name)), expected, "{name}");
    }
    folder.run("match left.png right.png -o d.png -d 8").done();
    let coarse = disparities(folder.path("d.png"));
    for (a, b) in coarse.samples().iter().zip(expected.samples()) {
        // KITTI's files have steps of 1/256, and no 0: it would say that there is no disparity.
        assert!((a - b).abs() <= 1.0 / 256.0, "{a} is not {b}");
    }
}

#[test]
fn other_files_come_on_request() {
    let folder = Folder::with_pair(32, 20);
    folder
        .run(
            "match left.png right.png -o d.pfm -d 8 --preview p.png --confidence c.npy \
             --reasons r.ppm",
        )
        .done();
    let expected = ["c.npy", "d.pfm", "d.pfm.json", "left.png", "p.png", "r.ppm", "right.png"];
    assert_eq!(folder.names(), expected);
    let confidence = disparities(folder.path("c.npy"));
    assert!(confidence.samples().iter().all(|v| (0.0..=1.0).contains(v)));
    assert_eq!(formats::read_image(folder.path("p.png")).unwrap().size(), (32, 20));
    folder.run("match left.png right.png -o d.pfm -d 8 --confidence c.png").done();
    let picture = formats::read_image(folder.path("c.png")).unwrap();
    assert!(matches!(picture, Image::Grey8(_)), "a confidence is a grey picture");
}

#[test]
fn only_the_box_is_answered() {
    let folder = Folder::with_pair(40, 24);
    folder.run("match left.png right.png -o d.pfm -d 8 --box 10,5,29,14").done();
    let map = disparities(folder.path("d.pfm"));
    for y in 0..24 {
        for x in 0..40 {
            let inside = (10..=29).contains(&x) && (5..=14).contains(&y);
            assert_eq!(map.row(y)[x].is_finite(), inside, "at {x}, {y}");
        }
    }
    let box_file = Plane::new(2, 2, vec![10i32, 29, 5, 14]).unwrap();
    formats::npy::write(folder.path("bounds.npy"), &box_file).unwrap();
    folder.run("match left.png right.png -o e.pfm -d 8 --box bounds.npy").done();
    let bytes = |name| std::fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("d.pfm"), bytes("e.pfm"));
}

#[test]
fn holes_can_be_kept() {
    let folder = Folder::with_pair(64, 40);
    folder.run("match left.png right.png -o d.pfm -d 12 --holes keep").done();
    let record = sidecar(&folder, "d.pfm.json");
    let reasons = record["reasons"].as_object().unwrap();
    assert!(reasons.keys().all(|name| name == "matched" || name.ends_with("-hole")), "{reasons:?}");
    let holes = disparities(folder.path("d.pfm")).samples().iter().filter(|v| v.is_nan()).count();
    let matched = reasons["matched"].as_f64().unwrap();
    assert_eq!(holes, (64.0 * 40.0 * (1.0 - matched)).round() as usize);
}

#[test]
fn matches_that_do_not_thin_out_towards_the_end_of_the_range_are_warned_of() {
    let folder = Folder::new();
    let noise = |x: usize, y: usize| {
        let mixed = (x as u32 * 7919 + y as u32 * 104_729 + 1).wrapping_mul(2_654_435_761);
        ((mixed ^ mixed >> 15).wrapping_mul(2_246_822_519) >> 24) as u8
    };
    // Rows 0 to 59 are far, up to 71 near the end of the range, below them the right image shows something else.
    let right = |x: usize, y: usize| match y {
        0..60 => noise(x + 7, y),
        60..72 => noise(x + 29, y),
        _ => noise(x, y + 1000),
    };
    for (name, image) in [
        ("left.png", Plane::from_fn(160, 120, noise)),
        ("right.png", Plane::from_fn(160, 120, right)),
    ] {
        formats::write_image(folder.path(name), &Image::Grey8(image)).unwrap();
    }
    for (more, words) in [
        ("-d 31", "31: there may be nearer things, which are filled as if they were far; raise"),
        ("-d 31 --holes keep", "31: there may be nearer things that are missed; raise --max-dis"),
    ] {
        let told = folder.run(&format!("match left.png right.png -o d.pfm -m fast {more}")).done();
        assert!(told.stderr.contains(words), "{more}: {}", told.stderr);
    }
    let told = folder.run("match left.png right.png -o d.pfm -m fast -d 63").done().stderr;
    assert!(!told.contains("warning"), "{told}");
}

#[test]
fn a_largest_disparity_of_zero_is_answered() {
    let folder = Folder::with_pair(24, 16);
    folder.run("match left.png right.png -o d.pfm --max-disparity 0").done();
    assert!(disparities(folder.path("d.pfm")).samples().iter().all(|&v| v == 0.0));
}

#[test]
fn a_largest_disparity_past_the_width_is_answered() {
    let folder = Folder::with_pair(24, 16);
    folder.run("match left.png right.png -o d.pfm --max-disparity 100").done();
    let map = disparities(folder.path("d.pfm"));
    assert!(map.samples().iter().all(|v| (0.0..=100.0).contains(v)));
}

#[test]
fn images_of_one_pixel_are_answered() {
    let folder = Folder::with_pair(1, 1);
    for matcher in ["fast", "balanced", "best"] {
        folder.run(&format!("match left.png right.png -o d.npy -d 4 -m {matcher}")).done();
        let map = disparities(folder.path("d.npy"));
        assert_eq!(map.size(), (1, 1));
        assert!((0.0..=4.0).contains(&map.samples()[0]));
    }
}

#[test]
fn negative_disparities_are_legal() {
    let folder = Folder::with_pair(64, 40);
    // Swapped, the wall lies at -3.
    folder.run("match right.png left.png -o d.pfm --min-disparity -8 -d 0").done();
    let map = disparities(folder.path("d.pfm"));
    let right = map.samples().iter().filter(|v| (*v + 3.0).abs() <= 1.0).count();
    assert!(right as f64 > 0.9 * map.samples().len() as f64, "{right}");
}

#[test]
fn what_was_assumed_is_told_unless_told_not_to() {
    let folder = Folder::with_pair(100, 16);
    let outcome = folder.run("match left.png right.png -o d.pfm").done();
    assert!(outcome.stderr.contains("disparities from 0 to 31 were assumed from the width of 100"));
    assert_eq!(sidecar(&folder, "d.pfm.json")["options"]["max_disparity"], 31);
    let outcome = folder.run("match left.png right.png -o d.pfm --quiet").done();
    assert_eq!(outcome.stderr, "");
}

#[test]
fn what_is_assumed_of_wide_images_fits_into_a_png() {
    let folder = Folder::with_pair(1242, 12);
    let outcome = folder.run("match left.png right.png -o d.png -m fast").done();
    assert!(outcome.stderr.contains("disparities from 0 to 255 were"), "{}", outcome.stderr);
}

#[test]
fn a_pair_that_is_none_is_warned_of_though_notes_are_off() {
    let folder = Folder::with_pair(100, 60);
    let told = "warning: only ";
    let outcome = folder.run("match left.png right.png -o d.pfm -d 20").done();
    assert!(!outcome.stderr.contains(told), "{}", outcome.stderr);
    for (left, right, range) in
        [("right.png", "left.png", "-d 20"), ("left.png", "right.png", "-d 30 --min-disparity 8")]
    {
        for matcher in ["fast", "balanced", "best"] {
            let arguments = format!("-q match {left} {right} -o d.pfm {range} -m {matcher}");
            let outcome = folder.run(&arguments).done();
            assert!(outcome.stderr.starts_with(told), "{arguments}: {}", outcome.stderr);
            for part in [left, "exchange", "--max-disparity", "rectified", "texture"] {
                assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
            }
        }
    }
    let dark =
        formats::write_image(folder.path("dark.png"), &Image::Grey8(Plane::filled(100, 60, 0)));
    dark.unwrap();
    let outcome = folder.run("match dark.png dark.png -o d.pfm -d 20").done();
    assert!(outcome.stderr.contains("warning: only 0.0 % of the pixels"), "{}", outcome.stderr);
    let outcome = folder.run("-q match left.png left.png -o d.pfm -d 20").done();
    let told = "warning: left.png and left.png hold the same image";
    assert!(outcome.stderr.starts_with(told), "{}", outcome.stderr);
}

#[test]
fn what_is_wrong_with_the_pictures_is_told() {
    let folder = Folder::with_pair(160, 120);
    let Ok(Image::Grey8(right)) = formats::read_image(folder.path("right.png")) else {
        panic!("the pair is grey")
    };
    let write = |name: &str, grey: &dyn Fn(usize, usize) -> u32| {
        let plane = Plane::from_fn(right.columns(), right.rows(), |x, y| grey(x, y) as u8);
        formats::write_image(folder.path(name), &Image::Grey8(plane)).unwrap();
    };
    let at = |x: usize, y: usize| u32::from(right.row(y)[x.min(right.columns() - 1)]);
    write("soft.png", &|x, y| (0..5).map(|i| at(x + i, y)).sum::<u32>() / 5);
    let soft = folder.run("match left.png soft.png -o d.pfm -d 20").done().stderr;
    assert!(soft.contains("times as much fine detail as soft.png"), "{soft}");
    let blocks = |x: usize, y: usize| (8 + (x / 8 * 5 + y / 8 * 3) % 7) as u32;
    write("blocks.png", &|x, y| at(x, y) / 64 + blocks(x, y));
    let told = folder.run("match blocks.png blocks.png -o d.pfm -d 20").done().stderr;
    assert!(told.contains("the blocks of 8 x 8 pixels of a compression"), "{told}");
    let told = folder.run("match left.png right.png -o d.pfm -d 20").done().stderr;
    assert!(!told.contains("compression") && !told.contains("fine detail"), "{told}");
}

#[test]
fn a_range_that_ends_where_things_are_is_told() {
    let folder = Folder::with_pair(100, 60);
    let told = |range: &str| {
        let arguments = format!("match left.png right.png -o d.pfm {range}");
        folder.run(&arguments).done().stderr
    };
    let both = told("--min-disparity -15 -d 20");
    assert!(!both.contains("there may be"), "{both}");
    let nearer = told("--min-disparity -15 -d 3");
    assert!(nearer.contains("at the largest disparity, 3"), "{nearer}");
    assert!(nearer.contains("raise --max-disparity"), "{nearer}");
    let farther = told("--min-disparity 3 -d 20");
    assert!(farther.contains("at the smallest disparity, 3"), "{farther}");
    assert!(farther.contains("lower --min-disparity"), "{farther}");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let folder = Folder::with_pair(64, 40);
    let bytes = |options: &str| {
        folder.run(&format!("match left.png right.png -o d.pfm -d 12 {options}")).done();
        std::fs::read(folder.path("d.pfm")).unwrap()
    };
    assert_eq!(bytes("--threads 1"), bytes("--threads 3"));
}

#[test]
fn a_limit_to_the_memory_changes_nothing() {
    let folder = Folder::with_pair(200, 400);
    let bytes = |options: &str| {
        folder.run(&format!("match left.png right.png -o d.pfm -d 63 {options}")).done();
        std::fs::read(folder.path("d.pfm")).unwrap()
    };
    assert_eq!(bytes(""), bytes("--memory 8MB"));
    assert_eq!(sidecar(&folder, "d.pfm.json")["options"]["memory"], 8_000_000);
}

#[test]
fn a_profile_names_the_stages_with_their_work_and_adds_up() {
    let folder = Folder::with_pair(300, 100);
    for (matcher, stage) in
        [("fast", "windows"), ("balanced", "eight paths"), ("best", "choices in the right view")]
    {
        let outcome = folder
            .run(&format!("match left.png right.png -o d.pfm -d 12 -m {matcher} --profile"))
            .done();
        let text = &outcome.stdout;
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("stage") && text.contains(stage), "{text}");
        let headings: Vec<&str> = lines[0].split("  ").map(str::trim).collect();
        let named = ["stage", "ms", "share", "MB", "Mop", "Mmac", "limit ms", "due to", "times"];
        assert!(named.iter().all(|name| headings.contains(name)), "{text}");
        // The first numbers after the name: milliseconds, share, megabytes.
        let number = |line: &str, place: usize| -> f64 {
            line.split_whitespace().filter_map(|word| word.parse().ok()).nth(place).unwrap()
        };
        let at = lines.iter().position(|line| line.starts_with("all")).unwrap();
        for (place, unit) in [(0, 0.001), (2, 0.1)] {
            let sum: f64 = lines[1..at].iter().map(|line| number(line, place)).sum();
            let rounding = unit * at as f64;
            assert!((number(lines[at], place) - sum).abs() <= rounding, "{text}");
        }
        assert!(number(lines[at], 2) > 0.0 && number(lines[at], 3) > 0.0, "{text}");
        let [rate, bytes, limit, measured] = lines[at + 1..] else { panic!("{text}") };
        assert!(rate.contains("MDE/s; threads: ") && bytes.starts_with("MB: "), "{text}");
        assert!(limit.starts_with("limit: ") && measured.contains("Gop/s"), "{text}");
    }
}

#[test]
fn options_come_from_the_environment_and_flags_win() {
    let folder = Folder::with_pair(24, 16);
    let threads = |variable: &str, arguments: &[&str]| {
        let status = folder
            .command()
            .args(["match", "left.png", "right.png", "-o", "d.pfm", "-d", "4"])
            .args(arguments)
            .env("HAZCAM_THREADS", variable)
            .stderr(Stdio::null())
            .status();
        assert!(status.unwrap().success());
        sidecar(&folder, "d.pfm.json")["options"]["threads"].as_u64()
    };
    assert_eq!(threads("3", &[]), Some(3));
    assert_eq!(threads("3", &["--threads", "2"]), Some(2));
    // An empty one says nothing.
    assert_eq!(threads("", &["--threads", "2"]), Some(2));
    assert!(threads("", &[]) > Some(0));
}

#[test]
fn an_older_output_survives_a_failed_run() {
    let folder = Folder::with_pair(24, 16);
    folder.run("match left.png right.png -o d.pfm -d 4").done();
    let before = std::fs::read(folder.path("d.pfm")).unwrap();
    folder.refuses("match left.png gone.png -o d.pfm -d 4", &["gone.png"]);
    assert_eq!(std::fs::read(folder.path("d.pfm")).unwrap(), before);
}

#[cfg(unix)]
#[test]
fn older_outputs_survive_a_disk_that_fills_up() {
    let folder = Folder::with_pair(64, 48);
    let line = "match left.png right.png -o d.pfm --preview p.png --confidence c.npy -d 4";
    folder.run(line).done();
    let names = folder.names();
    let contents = || -> Vec<_> {
        names.iter().map(|name| std::fs::read(folder.path(name)).unwrap()).collect()
    };
    let before = contents();
    // Files of a few kB at most: what is tried beforehand fits, but no map of numbers.
    let outcome = folder.run_in_shell("ulimit -f 4", line, "");
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("cannot write d.pfm"), "{}", outcome.stderr);
    assert!(contents() == before, "an older file is another one now");
    assert_eq!(folder.names(), names);
}

#[cfg(target_os = "linux")]
#[test]
fn a_profile_that_cannot_be_printed_is_an_error_and_no_panic() {
    let folder = Folder::with_pair(24, 16);
    let line = "match left.png right.png -o d.pfm -d 4 -m fast --profile";
    let outcome = folder.run_in_shell("", line, "> /dev/full");
    assert_eq!(outcome.status, 2, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("cannot write to stdout"), "{}", outcome.stderr);
}

#[cfg(unix)]
#[test]
fn what_was_read_is_recorded_also_from_a_pipe() {
    let folder = Folder::with_pair(24, 16);
    let line = "match left.png /dev/stdin -o d.pfm -d 4 -m fast";
    folder.run_in_shell("cat right.png |", line, "").done();
    folder.run("match left.png right.png -o file.pfm -d 4 -m fast").done();
    let [piped, file] = ["d.pfm.json", "file.pfm.json"].map(|name| sidecar(&folder, name));
    for field in ["bytes", "sha256"] {
        assert_eq!(piped["right"][field], file["right"][field]);
    }
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_nothing_of_what_is_being_written() {
    use std::os::unix::process::ExitStatusExt;
    use std::time::{Duration, Instant};
    let folder = Folder::with_pair(64, 40);
    // All files are whole, and wait to be put in their places: nobody reads from the pipe.
    let pipe = std::process::Command::new("mkfifo").arg(folder.path("pipe.png")).status();
    assert!(pipe.unwrap().success());
    let arguments = "match left.png right.png -o d.pfm --preview pipe.png -m fast -q";
    let mut command = folder.command();
    let mut hazcam = command.args(arguments.split_whitespace()).spawn().unwrap();
    let passing = || folder.names().into_iter().filter(|name| name.starts_with(".hazcam-"));
    let (started, mut before) = (Instant::now(), Vec::new());
    // What is tried at the beginning is there for a moment only.
    while before.is_empty() || passing().collect::<Vec<_>>() != before {
        assert!(started.elapsed() < Duration::from_secs(60), "nothing was written");
        before = passing().collect();
        std::thread::sleep(Duration::from_millis(200));
    }
    let status = std::process::Command::new("kill").arg(hazcam.id().to_string()).status();
    assert!(status.unwrap().success());
    assert_eq!(hazcam.wait().unwrap().signal(), Some(15));
    assert_eq!(folder.names(), ["left.png", "pipe.png", "right.png"]);
}
