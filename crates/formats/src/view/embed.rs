//! Numbers and pictures as text in the page.
//!
//! Maps stand in elements of their own, each the base64 of a zlib stream (RFC 1950): float32 in
//! little-endian order, as they are, or one byte a pixel. The script reads them back bit by bit.

use std::io::{self, Write};

use base64::prelude::BASE64_STANDARD;
use base64::write::EncoderWriter;
use camera::StereoCamera;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use raster::Plane;
use serde::Serialize;

use super::View;
use super::colouring::{self, Colouring};
use crate::{picture, png};

/// What the script is told besides the maps.
#[derive(Serialize)]
struct Facts {
    columns: usize,
    rows: usize,
    camera: Option<StereoCamera>,
    /// In pixels.
    disparity_error: f64,
    least_confidence: f32,
    colourings: Vec<Colouring>,
}

/// Everything that the scripts read, as elements named by what is in them.
pub(super) fn data(view: &View<'_>, writer: &mut dyn Write) -> io::Result<()> {
    let (columns, rows) = view.disparities.size();
    let facts = Facts {
        columns,
        rows,
        camera: view.camera,
        disparity_error: view.disparity_error,
        least_confidence: view.confidence.map_or(0.0, |(_, least)| least),
        colourings: colouring::all(view),
    };
    // No text in it is anybody's own, so nothing in it can end the element.
    let facts = serde_json::to_string(&facts)?;
    writeln!(writer, "<script type=\"application/json\" id=\"facts\">{facts}</script>")?;
    if let Some(image) = view.image {
        write!(writer, "<img id=\"image\" hidden alt=\"\" src=\"data:image/png;base64,")?;
        let mut base64 = EncoderWriter::new(&mut *writer, &BASE64_STANDARD);
        png::encode_rgb(&picture::image(image), &mut base64)?;
        base64.finish()?;
        drop(base64);
        writeln!(writer, "\">")?;
    }
    numbers(writer, "disparities", view.disparities)?;
    if let Some((confidence, _)) = view.confidence {
        numbers(writer, "confidence", confidence)?;
    }
    if let Some(reasons) = view.reasons {
        bytes(writer, "reasons", reasons.samples().iter().map(|&reason| [reason as u8]))?;
    }
    if let Some((truth, errors)) = &view.truth {
        numbers(writer, "truth", truth)?;
        let legend = colouring::errors();
        let entry = |colour: &[u8; 3]| legend.iter().position(|(entry, _)| entry == colour);
        let entry = |colour| [entry(colour).expect("the legend has every colour") as u8];
        bytes(writer, "errors", errors.samples().iter().map(entry))?;
    }
    Ok(())
}

fn numbers(writer: &mut dyn Write, id: &str, values: &Plane<f32>) -> io::Result<()> {
    bytes(writer, id, values.samples().iter().map(|value| value.to_le_bytes()))
}

/// An element with bytes, `N` a pixel.
fn bytes<const N: usize>(
    writer: &mut dyn Write,
    id: &str,
    pixels: impl Iterator<Item = [u8; N]>,
) -> io::Result<()> {
    write!(writer, "<script type=\"text/plain\" id=\"{id}\">")?;
    let base64 = EncoderWriter::new(&mut *writer, &BASE64_STANDARD);
    let mut zlib = ZlibEncoder::new(base64, Compression::default());
    // At once: a compressor that gets a few bytes at a time takes ten times as long.
    zlib.write_all(&pixels.flatten().collect::<Vec<u8>>())?;
    zlib.finish()?.finish()?;
    writeln!(writer, "</script>")
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use base64::Engine;
    use raster::{Image, Reason};
    use serde_json::Value;

    use super::*;

    /// The text between two others.
    fn between<'a>(page: &'a str, from: &str, to: &str) -> &'a str {
        page.split_once(from).unwrap().1.split_once(to).unwrap().0
    }

    /// The bytes of an element, as the script gets them.
    fn decoded(page: &str, id: &str) -> Vec<u8> {
        let text = between(page, &format!("<script type=\"text/plain\" id=\"{id}\">"), "</script>");
        let zlib = BASE64_STANDARD.decode(text).unwrap();
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(&zlib[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    fn page(view: &View<'_>) -> String {
        let mut page = Vec::new();
        data(view, &mut page).unwrap();
        String::from_utf8(page).unwrap()
    }

    #[test]
    fn numbers_come_out_as_they_went_in() {
        let values = vec![1.5, f32::NAN, -3.25, f32::MIN_POSITIVE, 255.998, f32::MAX];
        let map = Plane::new(3, 2, values).unwrap();
        let sure = Plane::new(3, 2, vec![0.0, 0.1, 1.0, f32::NAN, 0.5, 0.75]).unwrap();
        let view = View::new("map", &map).with_confidence(&sure, 0.25).unwrap();
        let page = page(&view.with_truth(&sure).unwrap());
        for (id, plane) in [("disparities", &map), ("confidence", &sure), ("truth", &sure)] {
            let expected = plane.samples().iter().flat_map(|value| value.to_le_bytes());
            assert_eq!(decoded(&page, id), expected.collect::<Vec<_>>(), "{id}");
        }
        let facts = between(&page, "id=\"facts\">", "</script>");
        let facts: Value = serde_json::from_str(facts).unwrap();
        assert_eq!((&facts["columns"], &facts["rows"]), (&3.into(), &2.into()));
        assert_eq!((&facts["camera"], &facts["least_confidence"]), (&Value::Null, &0.25.into()));
    }

    #[test]
    fn reasons_and_errors_are_places_in_their_palettes() {
        let map = Plane::new(8, 1, vec![1.0, 1.0, 4.5, 90.0, f32::NAN, 1.0, 1.0, 1.0]).unwrap();
        let mut truth = Plane::filled(8, 1, 1.0);
        truth.samples_mut()[1] = f32::NAN;
        let reasons = Plane::new(8, 1, Reason::ALL.to_vec()).unwrap();
        let view = View::new("map", &map).with_reasons(&reasons).unwrap();
        let page = page(&view.with_truth(&truth).unwrap());
        assert_eq!(decoded(&page, "reasons"), [0, 1, 2, 3, 4, 5, 6, 7]);
        // Right, no truth, n = 3.5 / 3, n = 89 / 3, no answer.
        assert_eq!(decoded(&page, "errors"), [0, 11, 5, 9, 10, 0, 0, 0]);
    }

    #[test]
    fn the_left_image_and_the_camera_are_there() {
        let map = Plane::filled(2, 1, 5.0);
        let image = Image::Rgb8(Plane::new(2, 1, vec![[1, 2, 3], [250, 0, 9]]).unwrap());
        let camera = StereoCamera::new(800.0, 0.25, 10.0, 320.5, 240.0).unwrap();
        let view = View::new("map", &map).with_image(&image).unwrap().with_camera(camera, 0.125);
        let page = page(&view);
        let png = between(&page, "data:image/png;base64,", "\"");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("left.png");
        std::fs::write(&path, BASE64_STANDARD.decode(png).unwrap()).unwrap();
        assert_eq!(crate::read_image(&path).unwrap(), image);
        let facts: Value =
            serde_json::from_str(between(&page, "id=\"facts\">", "</script>")).unwrap();
        let expected = serde_json::json!({ "focal_px": 800.0, "baseline_m": 0.25, "doffs": 10.0,
                                           "cx": 320.5, "cy": 240.0 });
        assert_eq!((&facts["camera"], &facts["disparity_error"]), (&expected, &0.125.into()));
    }
}
