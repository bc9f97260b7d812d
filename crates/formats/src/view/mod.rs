//! A disparity map as a page for a browser: its points in space, to be turned around, beside the map.
//!
//! A picture of disparities looks smooth where depth is not: an error of one pixel is hardly a shade
//! there and metres in space. The page shows the points themselves. It is one file, complete in
//! itself, that forbids itself to load anything, as the board's page is.
//!
//! | piece | what it does |
//! | --- | --- |
//! | `colouring` | the ways to colour points, from the colours of [`picture`](crate::picture) |
//! | `embed` | numbers and pictures as text in the page, and what the script is told about them |
//! | `page.html`, `page.css` | how it looks, in light and dark, wide and narrow |
//! | `data.js` | the numbers out of the page again; from a disparity to a point |
//! | `eye.js` | where points are looked at from |
//! | `cloud.js` | the points on the screen (WebGL 2), and which one is under the pointer |
//! | `page.js` | what is pressed, dragged and pointed at; the flat views; the words |

mod colouring;
mod embed;

use std::io::{self, Write};
use std::path::Path;

use camera::{DISPARITY_ERROR, StereoCamera};
use raster::{Image, Plane, Reason};

use crate::atomic::write_atomically;
use crate::markup::escaped;
use crate::picture::{self, SizesDiffer};
use crate::{FormatError, image};

/// What a page shows: a disparity map, and what lies over it pixel for pixel.
#[derive(Debug, Clone)]
pub struct View<'a> {
    title: &'a str,
    disparities: &'a Plane<f32>,
    camera: Option<StereoCamera>,
    disparity_error: f64,
    image: Option<&'a Image>,
    confidence: Option<(&'a Plane<f32>, f32)>,
    reasons: Option<&'a Plane<Reason>>,
    /// The true disparities, and the picture of the errors against them.
    truth: Option<(&'a Plane<f32>, Plane<[u8; 3]>)>,
}

impl<'a> View<'a> {
    /// Disparities in pixels, NaN where there is none, under a title. Without a camera points stand in
    /// pixels, as high as their disparity.
    pub fn new(title: &'a str, disparities: &'a Plane<f32>) -> Self {
        let (camera, image, confidence, reasons, truth) = (None, None, None, None, None);
        let disparity_error = DISPARITY_ERROR;
        Self { title, disparities, camera, disparity_error, image, confidence, reasons, truth }
    }

    /// With points in metres. The page tells between which depths a pixel lies where its disparity may be off by
    /// `disparity_error` pixels.
    pub fn with_camera(self, camera: StereoCamera, disparity_error: f64) -> Self {
        Self { camera: Some(camera), disparity_error, ..self }
    }

    /// With the left image.
    pub fn with_image(self, image: &'a Image) -> Result<Self, SizesDiffer> {
        self.same_size("image", image.size())?;
        Ok(Self { image: Some(image), ..self })
    }

    /// With how sure each pixel is, from 0 to 1. Points less sure than `least` are hidden at first.
    pub fn with_confidence(self, sure: &'a Plane<f32>, least: f32) -> Result<Self, SizesDiffer> {
        self.same_size("confidence", sure.size())?;
        Ok(Self { confidence: Some((sure, least)), ..self })
    }

    /// With why each pixel has its value or none.
    pub fn with_reasons(self, reasons: &'a Plane<Reason>) -> Result<Self, SizesDiffer> {
        self.same_size("reasons", reasons.size())?;
        Ok(Self { reasons: Some(reasons), ..self })
    }

    /// With the true disparities.
    pub fn with_truth(self, truth: &'a Plane<f32>) -> Result<Self, SizesDiffer> {
        self.same_size("truth", truth.size())?;
        let errors = picture::log_error(self.disparities, truth, None)?;
        Ok(Self { truth: Some((truth, errors)), ..self })
    }

    fn same_size(&self, what: &'static str, size: (usize, usize)) -> Result<(), SizesDiffer> {
        let disparities = self.disparities.size();
        if size == disparities {
            return Ok(());
        }
        let (first, first_size) = (what, size);
        Err(SizesDiffer { first, second: "map", first_size, second_size: disparities })
    }

    /// Depths in metres, NaN where there is none; without a camera there are none at all.
    fn depths(&self) -> Option<Plane<f32>> {
        self.camera.map(|camera| camera.depth_map(self.disparities))
    }

    /// How many pixels are points.
    pub fn points(&self) -> usize {
        self.points_of(|_| true)
    }

    /// How many of them are shown at first: those that are sure enough.
    pub fn shown(&self) -> usize {
        let is_sure =
            |at: usize| self.confidence.is_none_or(|(sure, least)| sure.samples()[at] >= least);
        self.points_of(is_sure)
    }

    fn points_of(&self, counts: impl Fn(usize) -> bool) -> usize {
        let depths = self.depths();
        let values = depths.as_ref().unwrap_or(self.disparities).samples().iter().enumerate();
        values.filter(|&(at, value)| value.is_finite() && counts(at)).count()
    }
}

/// Writes a view as a page, whole or not at all.
///
/// Errors: [`FormatError::UnknownExtension`] unless the path ends in `.html`, [`FormatError::Write`].
pub fn write_view(path: impl AsRef<Path>, view: &View<'_>) -> Result<(), FormatError> {
    let path = path.as_ref();
    if image::extension(path).as_deref() != Some("html") {
        let known = ".html (a page for a browser)";
        return Err(FormatError::UnknownExtension { path: path.to_owned(), known });
    }
    write_atomically(path, |writer| encode(view, writer))
}

fn encode(view: &View<'_>, writer: &mut dyn Write) -> io::Result<()> {
    write!(
        writer,
        include_str!("page.html"),
        title = escaped(view.title),
        style = include_str!("page.css"),
        facts = facts(view),
    )?;
    embed::data(view, writer)?;
    let scripts = [
        include_str!("data.js"),
        include_str!("eye.js"),
        include_str!("cloud.js"),
        include_str!("page.js"),
    ];
    write!(writer, "<script>\n\"use strict\";\n{}</script>\n</body>\n</html>\n", scripts.concat())
}

/// What is known about the map, as sentences.
fn facts(view: &View<'_>) -> String {
    let (columns, rows) = view.disparities.size();
    let points = view.points();
    let camera = match view.camera {
        Some(StereoCamera { focal_px, baseline_m, doffs, .. }) => format!(
            "Points are in metres: focal length {focal_px:.2} px, baseline {baseline_m:.4} m, \
             doffs {doffs:.2} px."
        ),
        None => "There is no calibration, so this is a relief and no shape: points stand in pixels, \
                 as high as their disparity is large. Slants and distances are not those of the scene."
            .to_owned(),
    };
    format!("{columns} x {rows} pixels, {points} of them with a point. {camera}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_extension_and_other_sizes_are_refused() {
        let map = Plane::filled(2, 1, 1.0);
        let error = write_view("view.htm", &View::new("map", &map)).unwrap_err();
        assert!(matches!(error, FormatError::UnknownExtension { .. }), "{error}");
        let other = Plane::filled(1, 2, 1.0);
        let view = || View::new("map", &map);
        let expected = "the truth is 1 x 2 but the map is 2 x 1: they must have one size";
        assert_eq!(view().with_truth(&other).unwrap_err().to_string(), expected);
        assert!(view().with_confidence(&other, 0.0).is_err());
        assert!(view().with_reasons(&Plane::filled(1, 2, Reason::Matched)).is_err());
        assert!(view().with_image(&Image::Grey8(Plane::filled(1, 2, 0))).is_err());
    }

    #[test]
    fn what_has_no_depth_is_no_point() {
        let map = Plane::new(5, 1, vec![50.0, f32::NAN, 0.0, -3.0, 1e-45]).unwrap();
        let camera = StereoCamera::new(800.0, 0.25, 0.0, 0.0, 0.0).unwrap();
        assert_eq!(View::new("map", &map).points(), 4);
        assert_eq!(View::new("map", &map).with_camera(camera, 0.5).points(), 1);
    }

    #[test]
    fn points_are_shown_from_the_least_confidence_on() {
        let map = Plane::new(4, 1, vec![8.0, 8.0, 8.0, f32::NAN]).unwrap();
        let sure = Plane::new(4, 1, vec![0.25, 0.5, 0.75, 0.75]).unwrap();
        assert_eq!(View::new("map", &map).shown(), 3);
        for (least, shown) in [(0.0, 3), (0.5, 2), (0.75, 1), (1.0, 0)] {
            let view = View::new("map", &map).with_confidence(&sure, least).unwrap();
            assert_eq!((view.points(), view.shown()), (3, shown), "{least}");
        }
    }

    #[test]
    fn titles_are_no_markup() {
        let map = Plane::filled(1, 1, 1.0);
        let mut page = Vec::new();
        encode(&View::new("<i>&{title}", &map), &mut page).unwrap();
        let page = String::from_utf8(page).unwrap();
        assert!(page.contains("<title>&lt;i&gt;&amp;{title}</title>"));
        assert!(page.contains("this is a relief and no shape"));
        assert!(!page.contains("<i>"));
    }
}
