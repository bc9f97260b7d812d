//! Which camera saw a disparity map: what a calibration file says, or numbers.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use camera::StereoCamera;
use formats::CalibrationLayout;

use crate::ui::Ui;

#[derive(clap::Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArguments {
    /// Calibration of Middlebury, ETH3D or KITTI, P1 and P2 or Q of OpenCV in YAML, or ROS's of the right camera, its
    /// CameraInfo included (`hazcam info FILE` shows what is in it)
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,

    /// Instead of a calibration: the focal length in pixels
    #[arg(long, value_name = "PX", requires = "baseline", conflicts_with = "calibration")]
    #[arg(allow_hyphen_values = true)]
    focal: Option<f64>,

    /// The distance between the cameras in metres
    #[arg(long, value_name = "M", requires = "focal", conflicts_with = "calibration")]
    #[arg(allow_hyphen_values = true)]
    baseline: Option<f64>,

    /// Column of the right camera's principal point less that of the left one, in pixels
    #[arg(long, value_name = "PX", requires = "focal", conflicts_with = "calibration")]
    #[arg(default_value_t = 0.0, allow_hyphen_values = true)]
    doffs: f64,

    /// Column and row of the principal point, in pixels; points alone need it [default: the middle
    /// of the image]
    #[arg(long, value_name = "CX,CY", requires = "focal", value_parser = principal_point)]
    #[arg(conflicts_with = "calibration", allow_hyphen_values = true)]
    principal: Option<[f64; 2]>,
}

/// `CX,CY`.
fn principal_point(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    let point = (text.split(',').count() == 2).then(|| numbers.try_into().ok()).flatten();
    point.ok_or_else(|| "give a column and a row, such as 609.6,172.9".into())
}

impl CameraArguments {
    /// The calibration, if one was named.
    pub fn file(&self) -> Option<&PathBuf> {
        self.calibration.as_ref()
    }

    /// The camera of a map of this size, or without one whatever it looks at; `None` where none was given. `image` is
    /// the map's left picture, if that was named.
    pub fn camera(
        &self,
        size: Option<(usize, usize)>,
        image: Option<&Path>,
        ui: &Ui,
    ) -> anyhow::Result<Option<StereoCamera>> {
        let camera = match &self.calibration {
            Some(path) => calibrated(path, size, image, ui).map(Some),
            None => self.stated(size),
        }?;
        if let Some(doubt) = camera.as_ref().and_then(StereoCamera::doubt) {
            ui.note(doubt);
        }
        Ok(camera)
    }

    /// Whether its principal point was given, and is not just the middle of a map.
    pub fn has_principal_point(&self) -> bool {
        self.calibration.is_some() || self.principal.is_some()
    }

    fn stated(&self, size: Option<(usize, usize)>) -> anyhow::Result<Option<StereoCamera>> {
        let (Some(focal), Some(baseline)) = (self.focal, self.baseline) else { return Ok(None) };
        let [cx, cy] = self.principal.unwrap_or_else(|| size.map_or([0.0; 2], camera::middle));
        let camera = StereoCamera::new(focal, baseline, self.doffs, cx, cy);
        camera.map(Some).context("the numbers given make no camera")
    }
}

fn calibrated(
    path: &Path,
    size: Option<(usize, usize)>,
    image: Option<&Path>,
    ui: &Ui,
) -> anyhow::Result<StereoCamera> {
    let calibration = formats::read_calibration(path)?;
    if let Some(size) = size
        && let stated = (calibration.width.unwrap_or(size.0), calibration.height.unwrap_or(size.1))
        && stated != size
    {
        bail!(
            "{} is for images of {} x {}, but the map is {} x {}: of a map at another scale give \
             --focal, --baseline, --doffs and --principal at that scale",
            path.display(),
            stated.0,
            stated.1,
            size.0,
            size.1
        );
    }
    let StereoCamera { focal_px, baseline_m, doffs, cx, cy, .. } = calibration.camera;
    match calibration.layout {
        CalibrationLayout::OpenCv => ui.note(format_args!(
            "{}: the baseline of {baseline_m} is taken as metres; OpenCV has it in the unit of the \
             board's squares: if that was another one, give --focal {focal_px} --baseline METRES \
             --doffs {} --principal {cx},{cy}",
            path.display(),
            doffs as f32
        )),
        CalibrationLayout::Ros => ui.note(format_args!(
            "{}: the left camera is taken to have its principal point in column {cx} too (doffs 0), as ROS rectifies \
             pairs; if its own file says another column, give --focal {focal_px} --baseline {} --doffs \
             RIGHT-LEFT --principal LEFT,{cy}",
            path.display(),
            baseline_m as f32
        )),
        _ => {}
    }
    if calibration.width.is_none()
        && let Some(doubt) = size.and_then(|size| calibration.camera.doubt_of_size(size))
    {
        ui.note(format_args!(
            "{}: {doubt} (--focal, --baseline, --doffs, --principal)",
            path.display()
        ));
    }
    Ok(match image {
        Some(image) => {
            let (camera, doubt) = calibration.camera_of(image);
            if let Some(doubt) = doubt {
                ui.note(format_args!("{}: {doubt}", path.display()));
            }
            camera
        }
        None => {
            if calibration.colour_camera.is_some_and(|colour| colour != calibration.camera) {
                ui.note(format_args!(
                    "{}: cameras 0 and 1, the grey ones, were assumed; name the left picture with \
                     --image if it is a coloured one",
                    path.display()
                ));
            }
            calibration.camera
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_principal_point_is_two_numbers() {
        assert_eq!(principal_point("609.5, -2"), Ok([609.5, -2.0]));
        for text in ["", "1", "1,", "1,2,3", "1,b", "a,2"] {
            assert!(principal_point(text).is_err(), "{text}");
        }
    }
}
