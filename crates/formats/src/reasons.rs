//! The picture of reasons that `hazcam match --reasons` writes, back as reasons.

use std::path::Path;

use raster::{Image, Plane, Reason};

use crate::picture::reason_colour;
use crate::source::Source;
use crate::{FormatError, image};

/// Reads why each pixel has its value or none from a picture in the colours of
/// [`reason_colour`].
///
/// Errors as [`read_image`](crate::read_image), and [`FormatError::WrongKind`] when the picture has
/// a colour that stands for no reason.
pub fn read_reasons(path: impl AsRef<Path>) -> Result<Plane<Reason>, FormatError> {
    let source = Source::open(path.as_ref())?;
    let container = source.container()?;
    let image::Decoded { image, stored } = image::decode(&source, container)?;
    let needed = "a picture of reasons is needed: the .png or .ppm of `hazcam match --reasons`, \
                  as it was written";
    let Image::Rgb8(colours) = image else {
        let found = format!("a {} of {}-bit {}", container.name(), stored.bits, stored.samples);
        return Err(source.wrong_kind(found, needed));
    };
    let reason = |colour: &[u8; 3]| Reason::ALL.into_iter().find(|&r| reason_colour(r) == *colour);
    if let Some(at) = colours.samples().iter().position(|colour| reason(colour).is_none()) {
        let (x, y) = (at % colours.columns(), at / colours.columns());
        let [r, g, b] = colours.samples()[at];
        let found = format!(
            "no picture of reasons (the pixel at column {x}, row {y} has the colour {r},{g},{b})"
        );
        return Err(source.wrong_kind(found, needed));
    }
    Ok(colours.map(|colour| reason(colour).expect("every colour has been looked up")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{picture, write_image};

    #[test]
    fn reasons_survive_their_picture() {
        let folder = tempfile::tempdir().unwrap();
        let reasons = Plane::new(4, 2, Reason::ALL.to_vec()).unwrap();
        for name in ["why.png", "why.ppm"] {
            let path = folder.path().join(name);
            write_image(&path, &Image::Rgb8(picture::reasons(&reasons))).unwrap();
            assert_eq!(read_reasons(&path).unwrap(), reasons, "{name}");
        }
    }

    #[test]
    fn other_pictures_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("why.png");
        let colours = Plane::new(2, 1, vec![[208; 3], [209, 208, 208]]).unwrap();
        write_image(&path, &Image::Rgb8(colours)).unwrap();
        let error = read_reasons(&path).unwrap_err().to_string();
        assert!(error.contains("column 1, row 0 has the colour 209,208,208"), "{error}");
        assert!(error.contains("hazcam match --reasons"), "{error}");
        write_image(&path, &Image::Grey8(Plane::filled(2, 1, 208))).unwrap();
        assert!(read_reasons(&path).unwrap_err().to_string().contains("8-bit grey"));
    }
}
