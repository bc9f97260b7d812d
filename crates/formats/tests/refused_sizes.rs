//! Sizes that a file claims and nobody should believe.

use std::fs;

use formats::{FormatError, npy, read_disparity, read_image};
use raster::{Image, Plane};

/// A PNG whose header has been changed, its checksum put right.
fn png_that_claims(columns: u32, rows: u32) -> Vec<u8> {
    let picture = Plane::filled(1, 1, [0u8; 3]);
    let mut bytes = formats::picture::png_rgb(&picture).unwrap();
    bytes[16..20].copy_from_slice(&columns.to_be_bytes());
    bytes[20..24].copy_from_slice(&rows.to_be_bytes());
    let checksum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    bytes
}

/// The checksum of PNG, annex D of its specification.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
    })
}

#[test]
fn a_png_of_100000_by_100000_is_refused_by_name_size_and_limit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.png");
    fs::write(&path, png_that_claims(100_000, 100_000)).unwrap();
    let error = read_image(&path).unwrap_err();
    assert!(matches!(error, FormatError::TooLarge { .. }), "{error}");
    let text = error.to_string();
    for word in ["bomb.png", "100000 x 100000", "268435456"] {
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn a_png_whose_bytes_were_changed_is_told_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("changed.png");
    let picture = Plane::from_fn(64, 64, |x, y| [(x * y) as u8, (x ^ y) as u8, (7 * x + y) as u8]);
    let whole = formats::picture::png_rgb(&picture).unwrap();
    for place in [24, 300] {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x55;
        fs::write(&path, bytes).unwrap();
        let error = read_image(&path).unwrap_err().to_string();
        assert!(error.contains("its bytes were changed"), "byte {place}: {error}");
    }
}

#[test]
fn a_png_that_is_shorter_than_any_picture_of_its_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("short.png");
    fs::write(&path, png_that_claims(10_000, 10_000)).unwrap();
    let error = read_image(&path).unwrap_err().to_string();
    assert!(error.contains("10000 x 10000 pixels, which takes at least"), "{error}");
    fs::write(&path, png_that_claims(1, 1)).unwrap();
    assert_eq!(read_image(&path).unwrap(), Image::Rgb8(Plane::filled(1, 1, [0; 3])));
}

/// A TIFF of 20 x 20 grey pixels in one strip, whose directory stands before it.
fn tiff_with_its_directory_first() -> Vec<u8> {
    tiff(&[(256, 20), (257, 20), (258, 8), (262, 1), (273, 98), (278, 20), (279, 400)], 400)
}

/// A TIFF of these entries, behind which so many samples of 7 stand.
fn tiff(entries: &[(u16, u32)], samples: usize) -> Vec<u8> {
    let mut bytes = b"II\x2a\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for &(tag, value) in entries {
        bytes.extend([u16::to_le_bytes(tag), u16::to_le_bytes(4)].concat());
        bytes.extend([u32::to_le_bytes(1), u32::to_le_bytes(value)].concat());
    }
    bytes.extend([0; 4]);
    bytes.resize(bytes.len() + samples, 7);
    bytes
}

#[test]
fn a_tiff_whose_tiles_are_wider_than_its_bytes_allow_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiles.tif");
    // One tile of so many columns and 32 rows, which has the 20 x 20 pixels in it.
    let tiled = |across| {
        let of_picture = [(256, 20), (257, 20), (258, 8), (262, 1)];
        let of_tile = [(322, across), (323, 32), (324, 110), (325, 1024)];
        fs::write(&path, tiff(&[of_picture, of_tile].concat(), 1024)).unwrap();
        read_image(&path).map_err(|error| error.to_string())
    };
    assert_eq!(tiled(32), Ok(Image::Grey8(Plane::filled(20, 20, 7))));
    // No byte makes more than 2560 of a row: the file has 1134.
    let first_refused = 2560 * 1135;
    for (across, claims) in [(first_refused - 1, false), (first_refused, true), (u32::MAX, true)] {
        let error = tiled(across).unwrap_err();
        let claim = format!("it claims tiles of {across} columns");
        assert_eq!(error.contains(&claim), claims, "{error}");
    }
}

#[test]
fn a_tiff_that_was_cut_off_within_its_strip_is_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.tif");
    let whole = tiff_with_its_directory_first();
    fs::write(&path, &whole).unwrap();
    assert_eq!(read_image(&path).unwrap(), Image::Grey8(Plane::filled(20, 20, 7)));
    for length in [98, 300, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        let error = read_image(&path).unwrap_err().to_string();
        assert!(error.contains("cut.tif") && error.contains("was it copied whole?"), "{error}");
    }
}

#[test]
fn a_tiff_of_other_samples_is_not_damaged_but_of_another_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.tif");
    // The values of the tags in `tiff_with_its_directory_first`: bits, then what white is.
    for (bits, white, word) in
        [(1, 1, "Gray(1) samples"), (4, 0, "Gray(4) samples"), (32, 0, "in which 0 is white")]
    {
        let mut bytes = tiff_with_its_directory_first();
        bytes[10 + 2 * 12 + 8] = bits;
        bytes[10 + 3 * 12 + 8] = white;
        // Floats; an entry takes the place of the rows in a strip, which are all.
        if bits == 32 {
            bytes[10 + 5 * 12..][..12].copy_from_slice(&[0x53, 1, 4, 0, 1, 0, 0, 0, 3, 0, 0, 0]);
        }
        fs::write(&path, &bytes).unwrap();
        for error in [
            read_image(&path).unwrap_err(),
            read_disparity(&path, formats::Encoding::Auto).unwrap_err(),
        ] {
            let error = error.to_string();
            assert!(error.contains(word) && !error.contains("damaged"), "{error}");
        }
    }
}

#[test]
fn an_array_that_claims_more_than_there_is_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d.npy");
    for shape in ["(100000, 100000)", "(4294967296, 4294967296)", "(18446744073709551615, 2)"] {
        let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
        header.push_str(&" ".repeat(117 - header.len()));
        header.push('\n');
        let length = (header.len() as u16).to_le_bytes();
        fs::write(&path, [b"\x93NUMPY\x01\0", &length[..], header.as_bytes()].concat()).unwrap();
        for error in [
            read_disparity(&path, formats::Encoding::Auto).unwrap_err(),
            npy::read_plane::<f32>(&path).unwrap_err(),
            npy::read(&path).unwrap_err(),
        ] {
            assert_eq!(error.path(), Some(&*path));
            let first = shape[1..].split(',').next().unwrap();
            assert!(error.to_string().contains(first), "{error}");
        }
    }
}

#[test]
fn empty_files_and_folders_are_named_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.png");
    fs::write(&path, "").unwrap();
    let error = read_image(&path).unwrap_err().to_string();
    assert!(error.contains("empty.png is empty, but a PNG"), "{error}");
    let error = read_image(folder.path()).unwrap_err();
    assert!(matches!(error, FormatError::Read { .. }), "{error}");
    let error = read_image(folder.path().join("missing.png")).unwrap_err();
    assert!(matches!(error, FormatError::Read { .. }), "{error}");
}
