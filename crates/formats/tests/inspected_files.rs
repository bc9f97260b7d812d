//! What `inspect` says about a file, as a person reads it and as a program does.

mod samples;

use formats::{inspect, inspect_bytes, npy, write_disparity, write_image};
use raster::{Image, Plane};

/// The lines after the first, which names the file by its whole path.
fn rest(text: &str) -> &str {
    text.split_once('\n').unwrap().1
}

#[test]
fn a_map_of_8_bit_shows_what_each_scale_would_make_of_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("disp.png");
    write_image(&path, &Image::Grey8(Plane::new(100, 2, [0, 8, 16, 220].repeat(50)).unwrap()))
        .unwrap();
    let info = inspect(&path).unwrap();
    assert_eq!(
        rest(&info.to_string()),
        "  size         100 x 2\n  \
         samples      grey, 8 bit\n  \
         values       0 to 220, mean 61.00\n  \
         as disparity png8/1: 8.00 to 220.00 px, no value at 25.0 % (0), not plausible: wider than \
         the image\n               \
         png8/2: 4.00 to 110.00 px, not plausible: wider than the image\n               \
         png8/3: 2.67 to 73.33 px\n               \
         png8/4: 2.00 to 55.00 px"
    );
}

#[test]
fn a_disparity_as_large_as_the_image_is_wide_is_not_plausible() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("disp.png");
    for (columns, plausible) in [(55, false), (56, true)] {
        write_image(&path, &Image::Grey8(Plane::filled(columns, 1, 220))).unwrap();
        let json = serde_json::to_value(inspect(&path).unwrap()).unwrap();
        let reading = &json["content"]["as_disparities"][3];
        assert_eq!((&reading["encoding"], &reading["max"]), (&"png8/4".into(), &55.0.into()));
        assert_eq!(reading["plausible"], plausible, "{columns}");
    }
}

#[test]
fn a_map_of_floats_shows_its_range_and_holes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.pfm");
    let values = Plane::new(4, 1, vec![f32::NAN, 1.0, 2.5, 3.0]).unwrap();
    write_disparity(&path, &values).unwrap();
    let info = inspect(&path).unwrap();
    let text = info.to_string();
    assert!(text.ends_with("d.pfm: PFM of float32, 26 bytes\n  size         4 x 1\n  values       1 to 3, mean 2.17, no value at 25.0 %"), "{text}");
    let json = serde_json::to_value(&info).unwrap();
    assert_eq!(json["content"]["kind"], "floats");
    assert_eq!(json["content"]["format"], "pfm");
    assert_eq!(json["content"]["values"]["max"], 3.0);
    assert_eq!(json["content"]["values"]["without_value"], 0.25);
}

#[test]
fn arrays_show_their_shape_and_boxes_their_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a_bounds.npy");
    npy::write(&path, &Plane::new(2, 2, vec![52i32, 440, 11, 365]).unwrap()).unwrap();
    let text = inspect(&path).unwrap().to_string();
    assert!(text.contains("NPY array of int32") && text.contains("(2, 2)"), "{text}");
    assert!(text.ends_with("as a box     52,11,440,365 (x0,y0,x1,y1, inclusive)"), "{text}");
}

#[test]
fn calibrations_show_their_cameras() {
    let (_, bytes) =
        samples::every_kind().into_iter().find(|(name, _)| name == "middlebury.txt").unwrap();
    let text = inspect_bytes("calib.txt", bytes).unwrap().to_string();
    for line in [
        "calib.txt: calibration (Middlebury, ETH3D), ",
        "  focal length 700 px",
        "  baseline     0.1205 m",
        "  centre       300, 200 px",
        "  doffs        10 px",
        "  size         640 x 480",
        "  disparities  0 to 63 px at most (ndisp 64)",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

#[test]
fn unknown_files_are_described() {
    for (bytes, word) in [
        (&b""[..], "is empty"),
        (b"GIF89a......", "a GIF picture"),
        (b"PK\x03\x04......", ".npz"),
        (b"just some words", "is text"),
        (b"\0\x01\x02\x03\x04\x05\x06\x07\x08", "unknown kind"),
    ] {
        let error = inspect_bytes("a", bytes.to_vec()).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains("calibration"), "{error}");
    }
}
