//! Files of every kind that is read: those under `tests/data`, written by other programs, and
//! small ones written by this crate.
// Each test program uses its own part of this.
#![allow(dead_code)]

use std::fs;
use std::path::{Path, PathBuf};

use raster::{Image, Plane};

/// Size of the pictures under `tests/data`.
pub const SIZE: (usize, usize) = (17, 12);

/// A file under `tests/data`.
pub fn foreign(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// A plane of the size of the pictures under `tests/data`.
pub fn plane<T>(f: impl Fn(usize, usize) -> T) -> Plane<T> {
    Plane::from_fn(SIZE.0, SIZE.1, f)
}

/// One small file of every kind: its name and its bytes.
pub fn every_kind() -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(foreign(""))
        .expect("the crate's own test data")
        .map(|entry| entry.expect("the crate's own test data").path())
        .filter(|path| path.extension().is_some_and(|extension| extension != "md"))
        .map(|path| (name_of(&path), fs::read(&path).expect("the crate's own test data")))
        .collect();
    files.sort();
    assert!(files.len() > 15, "the files under tests/data are missing");

    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, image: Image| {
        formats::write_image(folder.path().join(name), &image).unwrap();
    };
    let (small, wide) = (plane(|x, y| (x * 7 + y) as u8), plane(|x, y| (x * 700 + y) as u16));
    write("grey8.png", Image::Grey8(small.clone()));
    write("grey16.png", Image::Grey16(wide.clone()));
    write("colour8.png", Image::Rgb8(small.map(|&v| [v, v / 2, 255 - v])));
    write("colour16.png", Image::Rgb16(wide.map(|&v| [v, v / 2, !v])));
    write("grey8.pgm", Image::Grey8(small.clone()));
    write("grey16.pgm", Image::Grey16(wide.clone()));
    write("colour8.ppm", Image::Rgb8(small.map(|&v| [v, v / 2, 255 - v])));
    write("colour16.ppm", Image::Rgb16(wide.map(|&v| [v, v / 2, !v])));
    let disparities = plane(|x, y| if x == y { f32::NAN } else { x as f32 + y as f32 / 8.0 });
    for name in ["d.pfm", "d.npy", "d.png", "d.tiff"] {
        formats::write_disparity(folder.path().join(name), &disparities).unwrap();
    }
    formats::npy::write(folder.path().join("colour16.npy"), &wide.map(|&v| [v, 1, 2])).unwrap();
    formats::npy::write(
        folder.path().join("box.npy"),
        &Plane::new(2, 2, vec![5i32, 12, 3, 9]).unwrap(),
    )
    .unwrap();
    write("mask.png", Image::Grey8(plane(|x, y| if x > y { 255 } else { 128 })));
    // Lines that end as on Windows.
    let values = (0..6).flat_map(|v| (v as f32 * 1.1).to_le_bytes());
    let crlf = b"Pf\r\n3 2\r\n-1.0\r\n".iter().copied().chain(values).collect();
    files.push(("crlf.pfm".to_owned(), crlf));
    for entry in fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        files.push((name_of(&path), fs::read(&path).unwrap()));
    }

    for (name, text) in [
        ("plain.pgm", "P2\n# plain\n4 2\n200\n0 1 2 3\n100 150 199 200\n"),
        ("plain.ppm", "P3 2 1 1023\n0 512 1023 7 8 9\n"),
        (
            "middlebury.txt",
            "cam0=[700 0 300; 0 700 200; 0 0 1]\ncam1=[700 0 310; 0 700 200; 0 0 1]\ndoffs=10\n\
             baseline=120.5\nwidth=640\nheight=480\nndisp=64\nisint=0\nvmin=3\nvmax=60\n",
        ),
        (
            "kitti.txt",
            "P0: 700 0 600 0 0 700 180 0 0 0 1 0\nP1: 700 0 600 -378 0 700 180 0 0 0 1 0\n",
        ),
        ("lunar.txt", "f=600\ncx0=250\ncx1=260\ncy=240\ndoffs=10\nbaseline_m=2000\n"),
    ] {
        files.push((name.to_owned(), text.as_bytes().to_vec()));
    }
    files
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap().to_str().unwrap().to_owned()
}

/// Gives the file to every reader; each error must name it.
pub fn read_as_everything(path: &Path) {
    let errors = [
        formats::inspect(path).err(),
        formats::read_image(path).err(),
        formats::read_disparity(path, formats::Encoding::Auto).err(),
        formats::read_mask(path).err(),
        formats::read_calibration(path).err(),
        formats::read_bounding_box(path).err(),
        formats::npy::read(path).err(),
        formats::npy::read_plane::<f32>(path).err(),
        formats::npy::read_plane::<[u8; 3]>(path).err(),
    ];
    for error in errors.iter().flatten() {
        assert_eq!(error.path(), Some(path), "{error}");
    }
}
