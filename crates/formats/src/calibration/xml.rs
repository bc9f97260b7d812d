//! XML as OpenCV's `FileStorage` writes it.

use roxmltree::{Document, Node};

use super::Entries;
use super::matrix::Matrix;
use super::opencv::{ImageSize, Storage};
use crate::FormatError;

/// The element that all others lie in.
const ROOT: &str = "opencv_storage";

/// Whether a text is such a file.
pub(super) fn is_storage(text: &str) -> bool {
    text.trim_start().starts_with('<') && text.contains(ROOT)
}

/// Reads what is needed of such a file; what else is in it does not matter.
pub(super) fn read(entries: &Entries<'_>, text: &str) -> Result<Storage, FormatError> {
    let document = Document::parse(text)
        .map_err(|error| entries.fail(None, format!("the XML cannot be read: {error}")))?;
    let storage = document.root_element();
    if !storage.has_tag_name(ROOT) {
        let problem = format!("the XML is no <{ROOT}> but a <{}>", storage.tag_name().name());
        return Err(entries.fail(None, problem));
    }
    let matrix = |name| match child(storage, name) {
        Some(node) => stored(entries, node).map(Some),
        None => Ok(None),
    };
    let single = |name| match child(storage, name) {
        Some(node) => value(entries, node).map(Some),
        None => Ok(None),
    };
    let size = child(storage, "image_size").or_else(|| child(storage, "imageSize"));
    // Somebody else may call something else so.
    let size = size.and_then(|node| numbers(entries, node).ok()?.try_into().ok());
    Ok(Storage {
        left: matrix("P1")?,
        right: matrix("P2")?,
        reprojection: matrix("Q")?,
        image_width: single("image_width")?,
        image_height: single("image_height")?,
        image_size: size.map(ImageSize::Size),
    })
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// `<P1 type_id="opencv-matrix"><rows>3</rows><cols>4</cols><dt>d</dt><data>..</data></P1>`
fn stored(entries: &Entries<'_>, node: Node<'_, '_>) -> Result<Matrix, FormatError> {
    let part =
        |name| child(node, name).ok_or_else(|| fail(entries, node, &format!("has no <{name}>")));
    let count = |name| {
        let part = part(name)?;
        let number = value(entries, part)?;
        let is_count = (0.0..1e9).contains(&number) && number.fract() == 0.0;
        is_count.then_some(number as usize).ok_or_else(|| fail(entries, part, "must be a count"))
    };
    Ok(Matrix {
        size: Some([count("rows")?, count("cols")?]),
        data: numbers(entries, part("data")?)?,
    })
}

/// The one number of an element.
fn value(entries: &Entries<'_>, node: Node<'_, '_>) -> Result<f64, FormatError> {
    match numbers(entries, node)?[..] {
        [number] => Ok(number),
        _ => Err(fail(entries, node, "must be one number")),
    }
}

/// Its numbers, with what is not finite among them.
fn numbers(entries: &Entries<'_>, node: Node<'_, '_>) -> Result<Vec<f64>, FormatError> {
    let words = node.text().unwrap_or_default().split_whitespace();
    words
        .map(|word| {
            let number = match word.to_ascii_lowercase().as_str() {
                ".nan" | "-.nan" => Ok(f64::NAN),
                ".inf" => Ok(f64::INFINITY),
                "-.inf" => Ok(f64::NEG_INFINITY),
                _ => word.parse(),
            };
            number.map_err(|_| fail(entries, node, &format!("has `{word}`, which is no number")))
        })
        .collect()
}

fn fail(entries: &Entries<'_>, node: Node<'_, '_>, problem: &str) -> FormatError {
    let line = node.document().text_pos_at(node.range().start).row;
    let name = node.tag_name().name();
    entries.fail(None, format!("<{name}> in line {line} {problem}"))
}

#[cfg(test)]
mod tests {
    use camera::StereoCamera;

    use super::super::CalibrationLayout;
    use super::super::tests::{read, refused};

    /// As OpenCV 5 writes it; f = 700, 0.12 apart.
    const SAMPLE: &str = "<?xml version=\"1.0\"?>\n<opencv_storage>\n\
        <calibration_time>\"noon &amp; later\"</calibration_time>\n\
        <P1 type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>4</cols>\n  <dt>d</dt>\n  <data>\n    \
        700. 0. 320.5 0. 0. 7.0000000000000000e+02 240. 0. 0. 0. 1. 0.</data></P1>\n\
        <P2 type_id=\"opencv-matrix\">\n  <rows>3</rows>\n  <cols>4</cols>\n  <dt>d</dt>\n  <data>\n    \
        700. 0. 324.5 -84. 0. 700. 240. 0. 0.\n    0. 1. 0.</data></P2>\n\
        <image_size>\n  640 480</image_size>\n</opencv_storage>\n";

    #[test]
    fn the_matrices_of_stereo_rectify_are_a_camera() {
        let calibration = read(SAMPLE).unwrap();
        assert_eq!(calibration.layout, CalibrationLayout::OpenCv);
        assert_eq!(calibration.camera, StereoCamera::new(700.0, 0.12, 4.0, 320.5, 240.0).unwrap());
        assert_eq!((calibration.width, calibration.height), (Some(640), Some(480)));
        let other =
            SAMPLE.replace("<image_size>\n  640 480</image_size>", "<image_size>?</image_size>");
        assert_eq!(read(&other).unwrap().width, None);
        let other = SAMPLE.replace("\"noon &amp; later\"", ".Nan");
        assert_eq!(read(&format!("\u{feff}{other}")).unwrap().camera, calibration.camera);
        let size = "<image_width>640</image_width><image_height>480</image_height>";
        let other = SAMPLE.replace("<image_size>\n  640 480</image_size>", size);
        assert_eq!(read(&other).unwrap().height, Some(480));
    }

    #[test]
    fn what_is_wrong_is_named() {
        refused(
            SAMPLE,
            &[
                ("P2", "P3", "is a calibration, but neither P1 and P2 nor Q"),
                ("<rows>3</rows>", "<rows>2</rows>", "P1 is 2 x 4 with 12 numbers"),
                ("<rows>3</rows>", "<rows>-3</rows>", "<rows> in line 5 must be a count"),
                ("<rows>3</rows>", "<rows>3 4</rows>", "<rows> in line 5 must be one number"),
                ("<rows>3</rows>", "", "<P1> in line 4 has no <rows>"),
                ("324.5 -84.", "324.5 four", "<data> in line 14 has `four`, which is no number"),
                ("324.5 -84.", "324.5 -.Inf", "baseline"),
                ("324.5 -84.", "324.5 84.", "exchanged"),
                ("</P2>", "", "the XML cannot be read"),
                ("<opencv_storage>", "<my><opencv_storage>", "the XML cannot be read"),
                ("640 480", "640 48.5", "`image_size` is 48.5"),
            ],
        );
        let inside = SAMPLE.replace("<opencv_storage>", "<my><opencv_storage>");
        let inside = inside.replace("</opencv_storage>", "</opencv_storage></my>");
        assert!(read(&inside).unwrap_err().contains("no <opencv_storage> but a <my>"));
        // Entities that grow are not followed without end, nor are elements that lie in each other.
        let entities: String = ('b'..='k')
            .map(|c| {
                format!("<!ENTITY {c} \"{}\">", format!("&{};", (c as u8 - 1) as char).repeat(10))
            })
            .collect();
        let bomb = format!(
            "<!DOCTYPE x [<!ENTITY a \"lol\">{entities}]><opencv_storage>&k;</opencv_storage>"
        );
        assert!(read(&bomb).unwrap_err().contains("the XML cannot be read"));
        let deep = ["<a>", "</a>"].map(|tag| tag.repeat(100_000)).concat();
        let deep = format!("<opencv_storage>{deep}</opencv_storage>");
        assert!(read(&deep).unwrap_err().contains("neither P1 and P2"));
    }
}
