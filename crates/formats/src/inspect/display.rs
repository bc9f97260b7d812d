//! [`FileInfo`] as a few aligned lines.

use std::fmt;

use super::{DisparityReading, FileContent, FileInfo, Statistics};
use crate::npy::shape_text;
use crate::{Calibration, CalibrationLayout};

impl fmt::Display for FileInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, bytes) = (self.path.display(), self.bytes);
        match &self.content {
            FileContent::Picture {
                format,
                columns,
                rows,
                bits,
                stored,
                unused,
                samples,
                as_disparities,
                ..
            } => {
                writeln!(f, "{path}: {} picture, {bytes} bytes", format.name())?;
                writeln!(f, "  size         {columns} x {rows}")?;
                writeln!(f, "  samples      {stored}, {bits} bit")?;
                write!(f, "  values       {samples}")?;
                readings(f, as_disparities)?;
                unused.iter().try_for_each(|what| write!(f, "\n  not used     {what}"))
            }
            FileContent::Floats { format, columns, rows, bits, values } => {
                writeln!(f, "{path}: {} of float{bits}, {bytes} bytes", format.name())?;
                writeln!(f, "  size         {columns} x {rows}")?;
                write!(f, "  values       {values}")
            }
            FileContent::Array { dtype, shape, values, as_box } => {
                writeln!(f, "{path}: NPY array of {dtype}, {bytes} bytes")?;
                writeln!(f, "  shape        {}", shape_text(shape))?;
                write!(f, "  values       {values}")?;
                match as_box {
                    Some(text) => write!(f, "\n  as a box     {text} (x0,y0,x1,y1, inclusive)"),
                    None => Ok(()),
                }
            }
            FileContent::Calibration(calibration) => {
                write!(f, "{path}: ")?;
                cameras(f, calibration, bytes)
            }
        }
    }
}

fn readings(f: &mut fmt::Formatter<'_>, readings: &[DisparityReading]) -> fmt::Result {
    for (n, reading) in readings.iter().enumerate() {
        let label = if n == 0 { "as disparity" } else { "" };
        let DisparityReading { encoding, min, max, .. } = reading;
        write!(f, "\n  {label:<12} {encoding}: {min:.2} to {max:.2} px")?;
        if n == 0 {
            write!(f, ", no value at {:.1} % (0)", 100.0 * reading.without_value)?;
        }
        if !reading.plausible {
            f.write_str(", not plausible: wider than the image")?;
        }
    }
    Ok(())
}

fn cameras(f: &mut fmt::Formatter<'_>, calibration: &Calibration, bytes: u64) -> fmt::Result {
    let layout = match calibration.layout {
        CalibrationLayout::Middlebury => "calibration (Middlebury, ETH3D)",
        CalibrationLayout::Kitti => "calibration (KITTI)",
        CalibrationLayout::Ros => "calibration (ROS, right camera)",
        CalibrationLayout::OpenCv => "calibration (OpenCV; the baseline is taken as metres)",
        CalibrationLayout::Lunar => "calibration (lunar)",
    };
    write!(f, "{layout}, {bytes} bytes")?;
    let mut pairs = vec![("", calibration.camera)];
    match calibration.colour_camera {
        // The only pair.
        Some(colour) if colour == calibration.camera => pairs[0].0 = " of the colour pair",
        Some(colour) => pairs.push((" of the colour pair", colour)),
        None => {}
    }
    for (which, camera) in pairs {
        // As many digits as tell numbers of 32 bits apart: of the others most come from products.
        let [focal, baseline, cx, cy, doffs] =
            [camera.focal_px, camera.baseline_m, camera.cx, camera.cy, camera.doffs]
                .map(|n| n as f32);
        write!(f, "\n  focal length {focal} px{which}")?;
        write!(f, "\n  baseline     {baseline} m{which}")?;
        write!(f, "\n  centre       {cx}, {cy} px{which}")?;
        write!(f, "\n  doffs        {doffs} px{which}")?;
    }
    if let (Some(width), Some(height)) = (calibration.width, calibration.height) {
        write!(f, "\n  size         {width} x {height}")?;
    }
    if let Some(ndisp) = calibration.ndisp {
        write!(f, "\n  disparities  0 to {} px at most (ndisp {ndisp})", ndisp.saturating_sub(1))?;
    }
    Ok(())
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Some(min), Some(max), Some(mean)) = (self.min, self.max, self.mean) else {
            return f.write_str("none");
        };
        write!(f, "{} to {}, mean {mean:.2}", short(min), short(max))?;
        if self.without_value > 0.0 {
            write!(f, ", no value at {:.1} %", 100.0 * self.without_value)?;
        }
        Ok(())
    }
}

/// Whole numbers as such, others with four decimals.
fn short(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.4}") }
}
