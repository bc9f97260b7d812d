//! NumPy arrays survive their files in every type and order that processes exchange.

use std::fmt::Debug;
use std::fs;

use formats::npy::{self, Array, Dtype, Element, Samples};
use half::f16;
use raster::Plane;

fn round_trip<T: Element + PartialEq + Debug>(plane: Plane<T>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    npy::write(&path, &plane).unwrap();
    assert_eq!(npy::read_plane::<T>(&path).unwrap(), plane);
    let bytes = fs::read(&path).unwrap();
    let data = plane.samples().len() * T::CHANNELS * T::DTYPE.size();
    assert_eq!((bytes.len() - data) % 64, 0, "the elements begin at a multiple of 64 bytes");
}

#[test]
fn every_element_survives() {
    round_trip(Plane::from_fn(5, 3, |x, y| (x * 50 + y) as u8));
    round_trip(Plane::from_fn(5, 3, |x, y| (x * 5000 + y) as u16));
    round_trip(Plane::from_fn(5, 3, |x, y| x as i32 * 100_000 - y as i32));
    round_trip(Plane::from_fn(5, 3, |x, y| x as f32 / 3.0 - y as f32));
    round_trip(Plane::from_fn(5, 3, |x, y| x as f64 / 3.0 - y as f64));
    round_trip(Plane::from_fn(5, 3, |x, y| [x as u8, y as u8, 255]));
    round_trip(Plane::from_fn(5, 3, |x, y| [x as u16, y as u16, 65535]));
    round_trip(Plane::from_fn(5, 3, |x, y| [x as f32, y as f32, 0.1]));
    // More than one block of the writer.
    round_trip(Plane::from_fn(300, 200, |x, y| (x * y) as u16));
}

/// A file with this dictionary and these elements.
fn file(dictionary: &str, elements: &[u8]) -> Vec<u8> {
    let length = (dictionary.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], dictionary.as_bytes(), elements].concat()
}

fn read(bytes: &[u8]) -> Result<Array, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    fs::write(&path, bytes).unwrap();
    npy::read(&path).map_err(|e| e.to_string())
}

#[test]
fn both_byte_orders_and_all_integers_are_read() {
    for (descr, bytes, expected) in [
        ("|b1", &[1u8, 0][..], Samples::Bool(vec![true, false])),
        ("|i1", &[0xff, 1], Samples::Int8(vec![-1, 1])),
        ("<i2", &[0xfe, 0xff, 1, 0], Samples::Int16(vec![-2, 1])),
        (">u2", &[1, 0, 0, 2], Samples::Uint16(vec![256, 2])),
        (">u4", &[0, 0, 1, 0, 0, 0, 0, 2], Samples::Uint32(vec![256, 2])),
        ("<i8", &[[0xff; 8], [0; 8]].concat(), Samples::Int64(vec![-1, 0])),
        (
            "<f2",
            &[0, 0x3e, 0, 0xc0],
            Samples::Float16(vec![f16::from_f32(1.5), f16::from_f32(-2.0)]),
        ),
        (">f4", &[0x3f, 0x80, 0, 0, 0xc0, 0, 0, 0], Samples::Float32(vec![1.0, -2.0])),
    ] {
        let dictionary =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2,), }}\n");
        let array = read(&file(&dictionary, bytes)).unwrap();
        assert_eq!(array, Array { shape: vec![2], samples: expected }, "{descr}");
    }
}

#[test]
fn fortran_order_runs_down_the_columns() {
    let dictionary = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3), }\n";
    let array = read(&file(dictionary, &[11, 21, 12, 22, 13, 23])).unwrap();
    assert_eq!(array.samples, Samples::Uint8(vec![11, 12, 13, 21, 22, 23]));
    // Three dimensions: the element (i, j, k) of 2 x 2 x 2 stands at i + 2 j + 4 k.
    let dictionary = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 2, 2), }\n";
    let array = read(&file(dictionary, &[0, 1, 2, 3, 4, 5, 6, 7])).unwrap();
    assert_eq!(array.samples, Samples::Uint8(vec![0, 4, 2, 6, 1, 5, 3, 7]));
    assert_eq!(array.samples.dtype(), Dtype::Uint8);
}

#[test]
fn an_array_may_have_more_dimensions_than_colours_need() {
    for (order, samples) in [("False", vec![0, 1, 2, 3]), ("True", vec![0, 2, 1, 3])] {
        let shape = "(2, 1, 2, 1)";
        let dictionary =
            format!("{{'descr': '|u1', 'fortran_order': {order}, 'shape': {shape}, }}\n");
        let array = read(&file(&dictionary, &[0, 1, 2, 3])).unwrap();
        assert_eq!(array, Array { shape: vec![2, 1, 2, 1], samples: Samples::Uint8(samples) });
    }
}

#[test]
fn the_length_must_be_that_of_the_shape() {
    let dictionary = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 2), }\n";
    for bytes in [&[0; 15][..], &[0; 17], &[]] {
        let error = read(&file(dictionary, bytes)).unwrap_err();
        assert!(error.contains("float32 with shape (2, 2)"), "{error}");
    }
    assert!(read(&file(dictionary, &[0; 16])).is_ok());
}

#[test]
fn a_plane_needs_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let dictionary = "{'descr': '|u1', 'fortran_order': False, 'shape': (0, 5), }\n";
    fs::write(&path, file(dictionary, &[])).unwrap();
    let error = npy::read_plane::<u8>(&path).unwrap_err().to_string();
    assert!(error.contains("no pixels (5 x 0)"), "{error}");
}
