//! Bad input, one test each: a clear message, status 2, nothing left behind.

use crate::folder::Folder;
use raster::{Image, Plane};

const MATCH: &str = "match left.png right.png -o d.pfm";

#[test]
fn images_of_different_sizes() {
    let folder = Folder::with_pair(24, 16);
    folder.image("right.png", 23, 16, 0);
    folder.refuses(MATCH, &["left.png is 24 x 16 but right.png is 23 x 16", "rectify"]);
}

#[test]
fn an_image_that_is_missing() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses("match left.png gone.png -o d.pfm", &["cannot read gone.png"]);
}

#[test]
fn an_empty_image() {
    let folder = Folder::with_pair(24, 16);
    std::fs::write(folder.path("right.png"), "").unwrap();
    folder.refuses(MATCH, &["right.png is empty", "is needed"]);
}

#[test]
fn an_image_that_was_cut_off() {
    let folder = Folder::with_pair(24, 16);
    let whole = std::fs::read(folder.path("right.png")).unwrap();
    std::fs::write(folder.path("right.png"), &whole[..whole.len() / 2]).unwrap();
    folder.refuses(MATCH, &["right.png is damaged (PNG"]);
}

#[test]
fn a_file_that_is_no_image() {
    let folder = Folder::with_pair(24, 16);
    std::fs::write(folder.path("right.png"), "once upon a time\n").unwrap();
    folder.refuses(MATCH, &["right.png is text", "PNG, PGM/PPM, JPEG"]);
    folder.refuses("match left.png . -o d.pfm", &["cannot read ."]);
}

/// The checksum of PNG (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}

#[test]
fn a_png_that_claims_to_be_enormous() {
    let folder = Folder::with_pair(24, 16);
    let mut header = b"IHDR".to_vec();
    header.extend(100_000u32.to_be_bytes());
    header.extend(100_000u32.to_be_bytes());
    header.extend([8, 0, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    file.extend(&header);
    file.extend(crc(&header).to_be_bytes());
    file.extend(b"\0\0\0\0IDAT");
    std::fs::write(folder.path("right.png"), file).unwrap();
    folder.refuses(MATCH, &["right.png is too large", "100000 x 100000", "the limit is"]);
}

#[test]
fn a_negative_largest_disparity() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses(
        &format!("{MATCH} --max-disparity -5"),
        &["the disparity range 0 to -5 is empty", "--max-disparity"],
    );
}

#[test]
fn an_inverted_range() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses(
        &format!("{MATCH} --min-disparity 9 --max-disparity 8"),
        &["the disparity range 9 to 8 is empty"],
    );
}

#[test]
fn a_range_that_is_no_number() {
    let folder = Folder::with_pair(24, 16);
    for text in ["many", "64.5", "-64.5", "99999999999", "100000"] {
        for option in ["--max-disparity", "--min-disparity"] {
            let expected = [text, option, "give a whole number from -16383 to 16383"];
            folder.refuses(&format!("{MATCH} {option} {text}"), &expected);
        }
    }
}

#[test]
fn a_box_outside_the_image() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses(
        &format!("{MATCH} --box 0,0,24,15"),
        &["the box 0,0,24,15 leaves the image of 24 x 16", "at most 23", "inclusive"],
    );
}

#[test]
fn an_inverted_box() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses(
        &format!("{MATCH} --box 9,0,8,15"),
        &["the box 9,0,8,15 ends before it begins", "x0 <= x1"],
    );
    folder.refuses(&format!("{MATCH} --box 1,2,3"), &["`1,2,3` is not a box", "x0,y0,x1,y1"]);
}

#[test]
fn an_unknown_matcher() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses(&format!("{MATCH} --matcher worst"), &["worst", "fast, balanced, best"]);
}

#[test]
fn an_unknown_output_extension() {
    let folder = Folder::with_pair(24, 16);
    let expected = ["the format of d.exr", ".pfm, .npy"];
    folder.refuses("match left.png right.png -o d.exr", &expected);
    folder.refuses("match left.png right.png -o d", &["no extension", ".pfm, .npy"]);
    folder.refuses(&format!("{MATCH} --preview p.pfm"), &["p.pfm", ".png"]);
    // Pictures in colours are not written as grey ones, nor is a confidence in KITTI's numbers.
    for option in ["preview", "reasons"] {
        for name in ["x.pgm", "x.jpg"] {
            let expected =
                [&format!("the format of {name} from"), "use one of .png, .ppm (colour)\n"];
            folder.refuses(&format!("{MATCH} --{option} {name}"), &expected);
        }
    }
    let expected = ["the format of c.ppm", ".pfm, .npy, .tiff (float32), .png (grey picture)\n"];
    folder.refuses(&format!("{MATCH} --confidence c.ppm"), &expected);
}

#[test]
fn an_output_that_cannot_be_written() {
    let folder = Folder::with_pair(24, 16);
    let expected = ["cannot write no/d.pfm", "the folder no does not exist"];
    folder.refuses("match left.png right.png -o no/d.pfm", &expected);
    let expected = ["cannot write no/p.png", "does not exist"];
    folder.refuses(&format!("{MATCH} --preview no/p.png"), &expected);
    std::fs::create_dir(folder.path("d.pfm")).unwrap();
    folder.refuses(MATCH, &["cannot write d.pfm: it is a folder"]);
}

#[test]
fn an_output_that_would_replace_an_input_or_another_output() {
    let folder = Folder::with_pair(24, 16);
    folder.refuses("match left.png right.png -o ./left.png", &["would replace an input"]);
    let bounds = Plane::new(2, 2, vec![2, 20, 1, 12]).unwrap();
    formats::npy::write(folder.path("box.npy"), &bounds).unwrap();
    let expected = ["--output box.npy would replace an input"];
    folder.refuses("match left.png right.png --box box.npy -o box.npy", &expected);
    let expected = ["--output and --preview both name d.png"];
    folder.refuses("match left.png right.png -o d.png --preview d.png", &expected);
    std::fs::create_dir(folder.path("deep")).unwrap();
    let expected = ["--output and --preview both name deep/../d.png"];
    folder.refuses("match left.png right.png -o d.png --preview deep/../d.png", &expected);
}

#[test]
fn a_range_that_the_output_cannot_hold() {
    let folder = Folder::with_pair(24, 16);
    let expected = ["d.png holds disparities from 0 to below 256", "write .pfm"];
    folder.refuses("match left.png right.png -o d.png --min-disparity -1 -d 9", &expected);
    folder.refuses("match left.png right.png -o d.png -d 256", &expected);
}

#[test]
fn a_number_of_threads_that_is_none() {
    let folder = Folder::with_pair(24, 16);
    for threads in ["0", "-1", "two", "100000"] {
        let expected = ["--threads", "a whole number from 1 to 1024"];
        folder.refuses(&format!("{MATCH} --threads {threads}"), &expected);
    }
}

#[test]
fn a_number_of_jobs_that_is_none() {
    let folder = Folder::new();
    for jobs in ["0", "-1", "two"] {
        folder.refuses(&format!("bench --jobs={jobs}"), &["--jobs", "a whole number from 1 on"]);
    }
    folder.refuses("bench --speed --jobs=2", &["--speed", "cannot be used with", "--jobs"]);
}

#[test]
fn bits_that_samples_cannot_have() {
    let folder = Folder::with_pair(24, 16);
    for bits in ["0", "17", "ten"] {
        folder.refuses(&format!("{MATCH} --bits={bits}"), &["--bits", bits]);
    }
    let expected = ["--bits 10 is for images of 16 bits", "left.png has 8", "leave it out"];
    folder.refuses(&format!("{MATCH} --bits=10"), &expected);
    for name in ["left.png", "right.png"] {
        let deep = Plane::from_fn(24, 16, |x, y| (40 * x + 9 * y) as u16);
        formats::write_image(folder.path(name), &Image::Grey16(deep)).unwrap();
    }
    let expected = ["left.png has samples of 11 bits", "--bits 10", "give 11 or more"];
    folder.refuses(&format!("{MATCH} --bits=10"), &expected);
}

#[test]
fn memory_that_is_none_or_too_little() {
    let folder = Folder::with_pair(64, 40);
    for memory in ["=much", "=-1MB", "=5apples", " -5"] {
        let expected = ["--memory", "such as 200MB or 1.5GiB"];
        folder.refuses(&format!("{MATCH} --memory{memory}"), &expected);
    }
    let expected = ["`memory` is 0.1 MB, but 64 x 40 pixels", "need at least 1 MB"];
    folder.refuses(&format!("{MATCH} --memory=100kB"), &expected);
}

#[cfg(target_os = "linux")]
#[test]
fn memory_that_a_shell_does_not_give() {
    let folder = Folder::with_pair(1200, 900);
    let before = folder.names();
    let outcome = folder.run_in_shell("ulimit -v 150000", &format!("{MATCH} -m best"), "");
    assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{}", outcome.stderr);
    let bounded = "of the 153 MB that this process may take ";
    assert!(outcome.stderr.contains(bounded), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("raise the limit of its container"), "{}", outcome.stderr);
    assert_eq!(folder.names(), before);
}

#[test]
fn truth_of_another_size() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    folder.disparities("truth.pfm", &[1.0, 2.0, 3.0]);
    folder.refuses(
        "score d.pfm truth.pfm",
        &["cannot score d.pfm against truth.pfm", "truth is 3 x 1 but the estimate is 2 x 1"],
    );
}

#[test]
fn truth_without_a_single_known_pixel() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    folder.disparities("truth.pfm", &[f32::NAN, f32::NAN]);
    let expected = ["the truth has no known disparity in the whole image", "encoding"];
    folder.refuses("score d.pfm truth.pfm", &expected);

    folder.disparities("half.pfm", &[f32::NAN, 2.0]);
    folder.refuses("score d.pfm half.pfm --box 0,0,0,0", &["in the box 0,0,0,0 (inclusive)"]);
}

#[test]
fn a_box_outside_the_truth() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    folder.refuses("score d.pfm d.pfm --box 0,0,2,0", &["leaves the image of 2 x 1"]);
}

#[test]
fn a_mask_of_another_size_or_kind() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    let mask = |value: u8, columns| {
        let image = Image::Grey8(Plane::filled(columns, 1, value));
        formats::write_image(folder.path("mask.png"), &image).unwrap();
    };
    mask(255, 3);
    folder.refuses("score d.pfm d.pfm --mask mask.png", &["the mask is 3 x 1"]);
    mask(1, 2);
    folder.refuses("score d.pfm d.pfm --mask mask.png", &["mask.png", "255"]);
    mask(0, 2);
    folder.refuses("score d.pfm d.pfm --mask mask.png", &["no known disparity", "`mask.png`"]);
}

#[test]
fn a_npy_of_the_wrong_kind() {
    let folder = Folder::new();
    folder.disparities("truth.pfm", &[1.0, 2.0]);
    formats::npy::write(folder.path("d.npy"), &Plane::filled(2, 1, [1u8; 3])).unwrap();
    let expected = ["d.npy", "shape (1, 2, 3)", "(rows, columns) is needed"];
    folder.refuses("score d.npy truth.pfm", &expected);
    std::fs::write(folder.path("d.npy"), b"\x93NUMPY\x01\0").unwrap();
    folder.refuses("score d.npy truth.pfm", &["d.npy is damaged (NPY"]);
    formats::npy::write(folder.path("box.npy"), &Plane::filled(2, 2, 0.5f64)).unwrap();
    folder.refuses("score truth.pfm truth.pfm --box box.npy", &["2 x 2 integers"]);
}

#[test]
fn an_encoding_that_does_not_exist_or_fit() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    let score = "score d.pfm d.pfm --truth-encoding";
    folder.refuses(&format!("{score} png8"), &["`png8` is not an encoding", "png8/4"]);
    folder.refuses(&format!("{score} png8/4"), &["d.pfm is a PFM file", "ask for pfm"]);
}

#[test]
fn a_threshold_that_makes_no_sense() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    folder.refuses("score d.pfm d.pfm --fail-over psnr=3", &["psnr", "E_RMS, p_bad, bad0.5"]);
    folder.refuses("score d.pfm d.pfm --max-disparity -3", &["max-disparity", "-3", "0 or more"]);
}

#[test]
fn a_picture_in_colours_is_no_disparity_map() {
    let folder = Folder::new();
    folder.disparities("d.pfm", &[1.0, 2.0]);
    let image = Image::Rgb8(Plane::filled(2, 1, [9; 3]));
    formats::write_image(folder.path("colours.png"), &image).unwrap();
    folder.refuses("score colours.png d.pfm", &["colours.png", "coloured picture"]);
}

#[test]
fn a_variable_that_is_not_allowed_is_named() {
    let folder = Folder::with_pair(24, 16);
    let said = |arguments: &str| {
        let mut command = folder.command();
        command.args(arguments.split(' ')).env("HAZCAM_THREADS", "none");
        String::from_utf8(command.output().unwrap().stderr).unwrap()
    };
    let line = "match left.png right.png -o d.pfm -d 4";
    assert!(said(line).contains("'none' for '--threads <N>'"), "{}", said(line));
    assert!(said(line).contains("the variable HAZCAM_THREADS"), "{}", said(line));
    // Not where it was typed.
    let typed = said(&format!("{line} --threads none"));
    assert!(typed.contains("'none' for") && !typed.contains("HAZCAM_THREADS"), "{typed}");
}
