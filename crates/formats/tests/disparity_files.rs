//! Disparity maps come back from their files as they were, and what a file cannot hold is said.

use std::fs;
use std::path::PathBuf;

use formats::{Encoding, FormatError, npy, read_disparity, write_disparity, write_image};
use raster::{Image, Plane};
use tempfile::TempDir;

const NAN: f32 = f32::NAN;

fn row(values: &[f32]) -> Plane<f32> {
    Plane::new(values.len(), 1, values.to_vec()).unwrap()
}

/// The same values, NaN equal to NaN.
fn bits(plane: &Plane<f32>) -> Vec<u32> {
    let canonical = |v: &f32| if v.is_nan() { NAN.to_bits() } else { v.to_bits() };
    plane.samples().iter().map(canonical).collect()
}

fn place(name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

fn round_trip(name: &str, values: &Plane<f32>) -> Plane<f32> {
    let (_folder, path) = place(name);
    write_disparity(&path, values).unwrap();
    read_disparity(&path, Encoding::Auto).unwrap().values
}

#[test]
fn floats_survive_exactly() {
    let values = Plane::new(3, 2, vec![0.0, -4.25, NAN, 1e-30, 511.999, 63.0]).unwrap();
    for name in ["d.pfm", "d.npy", "d.tiff", "d.tif", "d.PFM"] {
        let read = round_trip(name, &values);
        assert_eq!((read.size(), bits(&read)), (values.size(), bits(&values)), "{name}");
    }
}

#[test]
fn kitti_png_rounds_to_the_nearest_256th_and_keeps_small_values() {
    let values = row(&[NAN, 0.0, 0.001, 0.002, 1.0, 1.0020, 1.0019, 255.99, 255.999]);
    let expected =
        [NAN, 1. / 256., 1. / 256., 1. / 256., 1.0, 257. / 256., 1.0, 65533. / 256., 65535. / 256.];
    assert_eq!(bits(&round_trip("d.png", &values)), bits(&row(&expected)));
}

#[test]
fn what_does_not_fit_names_the_pixel_and_leaves_no_file() {
    for (name, value, word) in [
        ("d.png", 256.0, "256"),
        ("d.png", -0.5, "-0.5"),
        ("d.png", f32::INFINITY, "inf"),
        ("d.pfm", f32::INFINITY, "inf"),
        ("d.npy", f32::NEG_INFINITY, "-inf"),
        ("d.tiff", f32::INFINITY, "inf"),
    ] {
        let (folder, path) = place(name);
        let values = Plane::new(2, 2, vec![1.0, 2.0, NAN, value]).unwrap();
        let error = write_disparity(&path, &values).unwrap_err().to_string();
        assert!(error.contains("column 1, row 1") && error.contains(word), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn an_unknown_extension_lists_the_known_ones() {
    for name in ["d.exr", "d", "d.jpg"] {
        let (folder, path) = place(name);
        let error = write_disparity(&path, &row(&[1.0])).unwrap_err();
        assert!(matches!(error, FormatError::UnknownExtension { .. }));
        for known in [".pfm", ".npy", ".png", ".tiff"] {
            assert!(error.to_string().contains(known), "{error}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn what_may_stand_for_no_match_is_told() {
    let (_folder, path) = place("d.pfm");
    let told = |values: &[f32]| {
        write_disparity(&path, &row(values)).unwrap();
        read_disparity(&path, Encoding::Auto).unwrap().note
    };
    let note = told(&[-1.0, 3.25, 0.0, -1.0]).unwrap();
    assert!(note.starts_with("50.0 % of the pixels are exactly -1, below all others"), "{note}");
    let mut few = vec![2.5; 200];
    few[7] = -16.0;
    for other in
        [&[0.0, 0.0, 3.25][..], &[-1.5, -1.5, 3.0], &[-1.0, -1.0, -0.75], &[f32::NAN; 3], &few]
    {
        assert_eq!(told(other), None, "{other:?}");
    }
}

#[test]
fn a_map_without_pixels_is_not_written() {
    for name in ["d.png", "d.pfm", "d.npy", "d.tiff"] {
        let (folder, path) = place(name);
        let error = write_disparity(&path, &Plane::default()).unwrap_err().to_string();
        assert!(error.contains("no pixels"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");
    }
}

#[test]
fn pfm_is_read_from_the_bottom_in_either_byte_order() {
    let (_folder, path) = place("d.pfm");
    let rows = [[1.0f32, 2.0], [3.0, f32::INFINITY], [f32::NEG_INFINITY, 6.0]];
    let expected = bits(&Plane::new(2, 3, vec![NAN, 6.0, 3.0, NAN, 1.0, 2.0]).unwrap());
    for (scale, bytes) in [
        ("-0.0039", rows.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>()),
        ("1.5", rows.as_flattened().iter().flat_map(|v| v.to_be_bytes()).collect()),
    ] {
        for end in ["\n", "\r\n", " \n"] {
            let header = format!("Pf{end}2 3{end}{scale}{end}");
            fs::write(&path, [header.as_bytes(), &bytes].concat()).unwrap();
            let read = read_disparity(&path, Encoding::Pfm).unwrap();
            assert_eq!(bits(&read.values), expected, "{header:?}");
            assert_eq!(read.note, None);
        }
    }
}

#[test]
fn broken_pfm_headers_are_named() {
    let (_folder, path) = place("d.pfm");
    for (text, word) in [
        ("Pf\n2 1\n0\n12345678", "scale"),
        ("Pf\n2 1\nx\n12345678", "scale"),
        ("Pf\n2 x\n-1\n12345678", "rows"),
        ("Pf\n2 1\n-1\n1234567", "there are 7"),
        ("Pf\n2 1\n-1\n123456789", "there are 9"),
        ("Pf\n0 1\n-1\n", "no pixels"),
        ("Pf\n90000 90000\n-1\n", "90000 x 90000"),
        ("PF\n1 1\n-1\n123456789012", "three channels"),
    ] {
        fs::write(&path, text).unwrap();
        let error = read_disparity(&path, Encoding::Auto).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn eight_bits_need_their_scale_and_auto_says_what_it_assumed() {
    let (_folder, path) = place("d.png");
    write_image(&path, &Image::Grey8(Plane::new(3, 1, vec![0, 4, 220]).unwrap())).unwrap();
    let read = read_disparity(&path, "png8/4".parse().unwrap()).unwrap();
    assert_eq!((bits(&read.values), read.note), (bits(&row(&[NAN, 1.0, 55.0])), None));
    let read = read_disparity(&path, Encoding::Auto).unwrap();
    assert_eq!(bits(&read.values), bits(&row(&[NAN, 4.0, 220.0])));
    assert_eq!(read.encoding.to_string(), "png8/1");
    assert!(read.note.unwrap().contains("png8/4"));

    write_image(&path, &Image::Grey16(Plane::new(3, 1, vec![0, 256, 640]).unwrap())).unwrap();
    let read = read_disparity(&path, Encoding::Auto).unwrap();
    assert_eq!(bits(&read.values), bits(&row(&[NAN, 1.0, 2.5])));
    assert!(read.note.unwrap().contains("png16/256"));
}

#[test]
fn an_encoding_is_a_demand() {
    let (_folder, path) = place("d.png");
    write_image(&path, &Image::Grey16(Plane::filled(2, 2, 256))).unwrap();
    for asked in ["png8/4", "pfm", "npy", "tiff"] {
        let error = read_disparity(&path, asked.parse().unwrap()).unwrap_err().to_string();
        assert!(error.contains("16-bit grey") && error.contains(asked), "{error}");
    }
    npy::write(&path, &row(&[1.0])).unwrap();
    let error = read_disparity(&path, Encoding::Pfm).unwrap_err().to_string();
    assert!(error.contains("is a NPY file") && error.contains("ask for npy"), "{error}");
}

#[test]
fn arrays_of_any_number_are_disparities_but_only_in_two_dimensions() {
    let (_folder, path) = place("d.npy");
    npy::write(&path, &Plane::new(2, 1, vec![0u8, 9]).unwrap()).unwrap();
    let read = read_disparity(&path, Encoding::Auto).unwrap();
    assert_eq!(read.values.samples(), [0.0, 9.0], "0 is a disparity here");
    npy::write(&path, &Plane::new(2, 1, vec![f64::INFINITY, 0.5]).unwrap()).unwrap();
    let read = read_disparity(&path, Encoding::Auto).unwrap();
    assert_eq!(bits(&read.values), bits(&row(&[NAN, 0.5])));
    // What OpenCV's matchers give, saved as it is.
    let header =
        format!("{:<117}\n", "{'descr': '<i2', 'fortran_order': False, 'shape': (1, 2), }");
    let samples = [16i16, 48].map(i16::to_le_bytes);
    let array = [b"\x93NUMPY\x01\0\x76\0", header.as_bytes(), samples.as_flattened()];
    fs::write(&path, array.concat()).unwrap();
    let read = read_disparity(&path, Encoding::Auto).unwrap();
    assert_eq!(read.values, row(&[16.0, 48.0]));
    assert!(read.note.unwrap().contains("OpenCV's matchers give sixteenths"));
    assert_eq!(read_disparity(&path, Encoding::Npy).unwrap().note, None);
    npy::write(&path, &Plane::new(2, 1, vec![1.0, 1e300]).unwrap()).unwrap();
    let error = read_disparity(&path, Encoding::Auto).unwrap_err().to_string();
    assert!(error.contains("column 1, row 0") && error.contains("float32"), "{error}");
    npy::write(&path, &Plane::filled(2, 2, [1u8; 3])).unwrap();
    let error = read_disparity(&path, Encoding::Auto).unwrap_err().to_string();
    assert!(error.contains("shape (2, 2, 3)"), "{error}");
}
