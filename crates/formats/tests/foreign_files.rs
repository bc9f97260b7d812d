//! Files that other programs wrote decode to what they hold.

mod samples;

use formats::{Encoding, npy, read_disparity, read_image};
use raster::{Image, Plane};
use samples::{foreign, plane};

fn grey(x: usize, y: usize) -> u8 {
    (10 * x + 5 * y) as u8
}

fn colour(x: usize, y: usize) -> [u8; 3] {
    [14 * x, 20 * y, 8 * (x + y)].map(|v| v as u8)
}

fn grey16(x: usize, y: usize) -> u16 {
    (3000 * x + 1000 * y + 1) as u16
}

#[test]
fn lossless_pictures_are_exact() {
    for (name, expected) in [
        ("grey8.tif", Image::Grey8(plane(grey))),
        ("grey_deflate.tif", Image::Grey8(plane(grey))),
        ("grey_alpha.png", Image::Grey8(plane(grey))),
        ("interlaced.png", Image::Grey8(plane(grey))),
        ("grey16.tif", Image::Grey16(plane(grey16))),
        ("colour_lzw.tif", Image::Rgb8(plane(colour))),
        ("colour_sample_formats.tif", Image::Rgb8(plane(colour))),
        ("grey_alpha.tif", Image::Grey8(plane(grey))),
        ("alpha.png", Image::Rgb8(plane(colour))),
        ("bits.png", Image::Grey8(plane(|x, y| if (x + y) % 2 == 0 { 255 } else { 0 }))),
        (
            "palette.png",
            Image::Rgb8(plane(|x, y| {
                let index = grey(x, y) / 32;
                [30 * index, 255 - 30 * index, 7 * index]
            })),
        ),
        (
            "alpha16.png",
            Image::Rgb16(plane(|x, y| {
                let blue = grey16(x, y);
                [blue / 3, blue / 2, blue]
            })),
        ),
    ] {
        assert_eq!(read_image(foreign(name)).unwrap(), expected, "{name}");
    }
}

#[test]
fn what_would_be_misread_is_refused() {
    for (name, words) in [
        ("four_samples.tif", "4 samples a pixel, of which 3 have a known meaning"),
        ("bits_reversed.tif", "tiffcp -f msb2lsb"),
    ] {
        let error = read_image(foreign(name)).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn jpegs_are_near() {
    match read_image(foreign("grey.jpg")).unwrap() {
        Image::Grey8(decoded) => {
            let far = largest_difference(&decoded.map(|&v| [v]), &plane(|x, y| [grey(x, y)]));
            assert!(far <= 6, "{far}");
        }
        other => panic!("{other:?}"),
    }
    for (name, allowed) in [("colour.jpg", 20), ("progressive.jpg", 20), ("subsampled.jpg", 30)] {
        match read_image(foreign(name)).unwrap() {
            Image::Rgb8(decoded) => {
                let far = largest_difference(&decoded, &plane(colour));
                assert!(far <= allowed, "{name}: {far}");
            }
            other => panic!("{name}: {other:?}"),
        }
    }
}

fn largest_difference<const N: usize>(a: &Plane<[u8; N]>, b: &Plane<[u8; N]>) -> u8 {
    assert_eq!(a.size(), b.size());
    let samples = a.samples().as_flattened().iter().zip(b.samples().as_flattened());
    samples.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn float_maps_are_exact() {
    for name in ["float.tif", "float16.tif", "float64.tif"] {
        let read = read_disparity(foreign(name), Encoding::Auto).unwrap();
        assert_eq!(read.encoding, Encoding::Tiff);
        assert_eq!(read.values, plane(|x, y| x as f32 + y as f32 / 4.0), "{name}");
    }
    let told = formats::inspect(foreign("float64.tif")).unwrap().to_string();
    assert!(told.contains("TIFF of float64, "), "{told}");
    let read = read_disparity(foreign("float64_fortran.npy"), Encoding::Npy).unwrap();
    assert_eq!(read.values, plane(|x, y| x as f32 - y as f32 / 2.0));
    assert_eq!(npy::read_plane::<[u8; 3]>(foreign("colour.npy")).unwrap(), plane(colour));
}

#[test]
fn a_wrong_kind_of_array_is_named() {
    let error = npy::read(foreign("objects.npy")).unwrap_err().to_string();
    assert!(error.contains("pickle"), "{error}");
    let error = npy::read_plane::<f32>(foreign("float64_fortran.npy")).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "is a .npy array of float64 with shape (12, 17), but float32 with shape (rows, \
             columns) is needed"
        ),
        "{error}"
    );
    let error = npy::read_plane::<u8>(foreign("colour.npy")).unwrap_err().to_string();
    assert!(error.contains("shape (12, 17, 3)"), "{error}");
    let error = npy::read(foreign("grey.jpg")).unwrap_err().to_string();
    assert!(error.contains("is a JPEG file, but a .npy file is needed"), "{error}");
}

#[test]
fn what_is_not_stored_as_it_is_is_no_disparity_map() {
    for name in ["alpha.png", "palette.png", "bits.png", "grey_alpha.png", "grey.jpg", "grey8.tif"]
    {
        let error = read_disparity(foreign(name), Encoding::Auto).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(", but "), "{error}");
    }
}
