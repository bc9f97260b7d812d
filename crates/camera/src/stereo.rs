//! A rectified pair of pinhole cameras.
//!
//! With focal length f in pixels, baseline B in metres and principal points that differ by
//! `doffs = cx_right - cx_left` pixels, a point at depth Z is seen at a disparity of
//!
//! ```text
//! d = x_left - x_right = f B / Z - doffs        Z = f B / (d + doffs)
//! ```
//!
//! and an uncertainty of the disparity becomes one of the depth by the derivative of that:
//! `|dZ| = Z^2 |dd| / (f B)`. See Scharstein et al., *High-resolution stereo datasets with
//! subpixel-accurate ground truth*, GCPR 2014, for `doffs`.

use raster::Plane;

/// A number of a camera is not usable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the camera's {field} is {value}, but it must be {allowed}")]
pub struct CameraError {
    /// Which number, with its unit.
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// What is allowed.
    pub allowed: &'static str,
}

/// By how much disparities are taken to be off where nobody says it, in pixels: of those that `balanced` and `best`
/// are sure of, 93 of 100 lie as near to the truth as that (docs/RELIABILITY.md).
pub const DISPARITY_ERROR: f64 = 1.0;

/// Column and row of the middle of an image of `(columns, rows)`, to the half pixel: the principal point
/// where none is known.
pub fn middle((columns, rows): (usize, usize)) -> [f64; 2] {
    [columns, rows].map(|count| (count as f64 - 1.0) / 2.0)
}

/// A rectified pair of pinhole cameras, made by [`StereoCamera::new`]. See the crate's documentation for the axes.
///
/// ```
/// use camera::StereoCamera;
///
/// // 700 px, 12 cm apart, principal point in the middle of 640 x 480 pixels.
/// let camera = StereoCamera::new(700.0, 0.12, 0.0, 319.5, 239.5)?;
/// assert_eq!(camera.depth(42.0), Some(2.0));
/// // Half a pixel there is 2.4 cm, and at 20 m, a tenth of the disparity, a hundred times as much.
/// assert_eq!(camera.depth_uncertainty(2.0, 0.5), Some(2.0 / 84.0));
/// assert_eq!(camera.depth_uncertainty(20.0, 0.5), Some(200.0 / 84.0));
/// # Ok::<(), camera::CameraError>(())
/// ```
#[non_exhaustive]
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct StereoCamera {
    /// Focal length of both cameras in pixels, positive. Times the baseline it is still finite.
    pub focal_px: f64,
    /// Distance between the cameras in metres, positive: the right one stands to the right.
    pub baseline_m: f64,
    /// Column of the right camera's principal point less that of the left one, in pixels. It is
    /// what must be added to a disparity before it is proportional to inverse depth.
    pub doffs: f64,
    /// Column of the left camera's principal point, in pixels.
    pub cx: f64,
    /// Row of both cameras' principal points, in pixels.
    pub cy: f64,
}

impl StereoCamera {
    /// Checks the numbers: all finite, focal length and baseline positive, and so their product.
    pub fn new(
        focal_px: f64,
        baseline_m: f64,
        doffs: f64,
        cx: f64,
        cy: f64,
    ) -> Result<Self, CameraError> {
        for (field, value) in [
            ("focal length in pixels", focal_px),
            ("baseline in metres (the right camera stands to the right)", baseline_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(CameraError { field, value, allowed: "finite and positive" });
            }
        }
        let product = focal_px * baseline_m;
        if !(product.is_finite() && product > 0.0) {
            let field = "focal length in pixels times baseline in metres";
            let allowed = "finite and positive";
            return Err(CameraError { field, value: product, allowed });
        }
        for (field, value) in [
            ("offset of disparities (doffs) in pixels", doffs),
            ("principal column (cx) in pixels", cx),
            ("principal row (cy) in pixels", cy),
        ] {
            if !value.is_finite() {
                return Err(CameraError { field, value, allowed: "finite" });
            }
        }
        Ok(Self { focal_px, baseline_m, doffs, cx, cy })
    }

    /// That of the same pair where its images are so many times as large: pixel centres lie at whole numbers, so it is
    /// their edges that scale.
    ///
    /// Errors where that leaves no camera, as with a scale that is not positive.
    pub fn scaled(&self, times: f64) -> Result<Self, CameraError> {
        let place = |at: f64| (at + 0.5) * times - 0.5;
        let (focal_px, doffs) = (self.focal_px * times, self.doffs * times);
        Self::new(focal_px, self.baseline_m, doffs, place(self.cx), place(self.cy))
    }

    /// Depth in metres of a disparity in pixels: `f B / (d + doffs)`.
    ///
    /// `None` when no point in front of the cameras has this disparity: `d + doffs` is not
    /// positive (at zero the point is infinitely far away) or not finite (NaN is no disparity), or so
    /// small that the depth is not finite.
    pub fn depth(&self, disparity: f64) -> Option<f64> {
        let shifted = disparity + self.doffs;
        let depth = self.focal_px * self.baseline_m / shifted;
        (shifted > 0.0 && shifted.is_finite() && depth.is_finite()).then_some(depth)
    }

    /// Disparity in pixels of a depth in metres: `f B / Z - doffs`.
    ///
    /// `None` when the depth is not positive, or so small that the disparity is not finite. An infinite depth has
    /// the disparity `-doffs`.
    pub fn disparity(&self, depth_m: f64) -> Option<f64> {
        let disparity = self.focal_px * self.baseline_m / depth_m - self.doffs;
        (depth_m > 0.0 && disparity.is_finite()).then_some(disparity)
    }

    /// Uncertainty of the depth in metres at a depth in metres, for an uncertainty of the
    /// disparity in pixels: `Z^2 |dd| / (f B)`, to first order.
    ///
    /// `None` when the depth is not positive and finite, or its uncertainty is not finite.
    pub fn depth_uncertainty(&self, depth_m: f64, disparity_uncertainty: f64) -> Option<f64> {
        let uncertainty =
            depth_m * depth_m * disparity_uncertainty.abs() / (self.focal_px * self.baseline_m);
        (depth_m > 0.0 && depth_m.is_finite() && uncertainty.is_finite()).then_some(uncertainty)
    }

    /// [`StereoCamera::depth_uncertainty`] of each depth in metres, all disparities being as uncertain; NaN where
    /// there is none, in or out, or none that a float of 32 bits holds.
    pub fn depth_uncertainty_map(
        &self,
        depths: &Plane<f32>,
        disparity_uncertainty: f64,
    ) -> Plane<f32> {
        depths.map(|&depth| {
            let off = self.depth_uncertainty(f64::from(depth), disparity_uncertainty);
            off.map(|off| off as f32).filter(|off| off.is_finite()).unwrap_or(f32::NAN)
        })
    }

    /// Depth in metres of each disparity in pixels; NaN where there is none, in or out, or none that a
    /// float of 32 bits holds. A matcher fills what it does not see: to have no depth of its guesses give what is sure
    /// ([`DisparityMap::surer_than`](raster::DisparityMap::surer_than)).
    pub fn depth_map(&self, disparities: &Plane<f32>) -> Plane<f32> {
        disparities.map(|&d| self.depth_in_32_bits(d).unwrap_or(f32::NAN))
    }

    /// [`StereoCamera::depth`] as a float of 32 bits; `None` too where none holds it, which then is infinite or nothing.
    pub fn depth_in_32_bits(&self, disparity: f32) -> Option<f32> {
        let depth = self.depth(f64::from(disparity))? as f32;
        (depth > 0.0 && depth.is_finite()).then_some(depth)
    }

    /// The point `[X, Y, Z]` in metres that left pixel `(x, y)` shows at a disparity in pixels.
    ///
    /// `None` where [`StereoCamera::depth`] is.
    pub fn point(&self, x: f64, y: f64, disparity: f64) -> Option<[f64; 3]> {
        let depth = self.depth(disparity)?;
        let scale = depth / self.focal_px;
        Some([(x - self.cx) * scale, (y - self.cy) * scale, depth])
    }

    /// The point of each pixel of a map of disparities in pixels, in the order of rows: `None` where
    /// `depths`, those of the same pixels, have none, and where a coordinate is beyond 32 bits.
    ///
    /// # Panics
    ///
    /// If the two differ in size.
    pub fn points(
        &self,
        disparities: &Plane<f32>,
        depths: &Plane<f32>,
    ) -> impl Iterator<Item = Option<[f32; 3]>> {
        assert_eq!(disparities.size(), depths.size(), "depths are those of the disparities");
        let columns = disparities.columns();
        let pixels = disparities.samples().iter().zip(depths.samples()).enumerate();
        pixels.map(move |(at, (&disparity, depth))| {
            let (x, y) = ((at % columns) as f64, (at / columns) as f64);
            let point = self.point(x, y, f64::from(disparity)).filter(|_| !depth.is_nan())?;
            let point = point.map(|coordinate| coordinate as f32);
            point.iter().all(|coordinate| coordinate.is_finite()).then_some(point)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = 800 px, B = 0.25 m: f B = 200 px m.
    fn camera(doffs: f64) -> StereoCamera {
        StereoCamera::new(800.0, 0.25, doffs, 320.0, 240.0).unwrap()
    }

    #[test]
    fn depth_is_focal_length_times_baseline_over_disparity() {
        assert_eq!(camera(0.0).depth(50.0), Some(4.0));
        // 200 / (30 + 10)
        assert_eq!(camera(10.0).depth(30.0), Some(5.0));
        // A negative disparity is legal as long as doffs carries it.
        assert_eq!(camera(10.0).depth(-5.0), Some(40.0));
    }

    #[test]
    fn disparity_is_the_inverse_of_depth() {
        assert_eq!(camera(0.0).disparity(4.0), Some(50.0));
        assert_eq!(camera(10.0).disparity(40.0), Some(-5.0));
        assert_eq!(camera(10.0).disparity(f64::INFINITY), Some(-10.0));
    }

    #[test]
    fn what_is_not_in_front_of_the_cameras_has_no_depth() {
        for disparity in [0.0, -1.0, 5e-324, f64::NAN, f64::INFINITY] {
            assert_eq!(camera(0.0).depth(disparity), None);
            assert_eq!(camera(0.0).point(0.0, 0.0, disparity), None);
        }
        assert_eq!(camera(10.0).depth(-10.0), None);
        assert!(camera(0.0).depth(1e-300).is_some());
        for depth in [0.0, -1.0, f64::NAN] {
            assert_eq!(camera(0.0).disparity(depth), None);
            assert_eq!(camera(0.0).depth_uncertainty(depth, 1.0), None);
        }
        assert_eq!(camera(0.0).disparity(5e-324), None);
        for (depth, off) in [(4.0, f64::NAN), (1e300, 1.0)] {
            assert_eq!(camera(0.0).depth_uncertainty(depth, off), None);
        }
    }

    #[test]
    fn a_depth_that_no_float_of_32_bits_holds_is_none() {
        // Files in another byte order than they say are full of such disparities.
        for (baseline, disparity) in [(0.5, 1e-40), (1e-20, 1e38)] {
            let camera = StereoCamera::new(700.0, baseline, 0.0, 0.0, 0.0).unwrap();
            assert!(camera.depth(f64::from(disparity)).is_some());
            assert_eq!(camera.depth_in_32_bits(disparity), None);
            assert!(camera.depth_map(&Plane::filled(1, 1, disparity)).samples()[0].is_nan());
        }
    }

    #[test]
    fn every_number_must_be_finite() {
        for wrong in [f64::NAN, f64::INFINITY] {
            for (at, name) in
                ["focal length", "baseline", "offset", "principal column", "principal row"]
                    .into_iter()
                    .enumerate()
            {
                let mut numbers = [700.0, 0.5, 1.0, 2.0, 3.0];
                numbers[at] = wrong;
                let [focal, baseline, doffs, cx, cy] = numbers;
                let error = StereoCamera::new(focal, baseline, doffs, cx, cy).unwrap_err();
                assert!(error.field.starts_with(name), "{error}");
            }
        }
    }

    #[test]
    fn uncertainty_grows_with_the_square_of_depth() {
        // 4^2 * 0.5 / 200 and 8^2 * 0.5 / 200
        assert_eq!(camera(0.0).depth_uncertainty(4.0, 0.5), Some(0.04));
        assert_eq!(camera(10.0).depth_uncertainty(8.0, -0.5), Some(0.16));
        let depths = Plane::new(4, 1, vec![4.0, f32::NAN, 0.0, 1e30]).unwrap();
        let map = camera(0.0).depth_uncertainty_map(&depths, 0.5);
        assert_eq!(map.samples()[0], 0.04);
        assert!(map.samples()[1..].iter().all(|uncertainty| uncertainty.is_nan()), "{map:?}");
    }

    #[test]
    fn uncertainty_is_the_slope_of_depth() {
        let camera = camera(10.0);
        let step = 1e-4;
        let slope = (camera.depth(30.0 - step).unwrap() - camera.depth(30.0 + step).unwrap()) / 2.0;
        assert!((camera.depth_uncertainty(5.0, step).unwrap() - slope).abs() < 1e-9);
    }

    #[test]
    fn a_pixel_and_its_disparity_are_a_point() {
        // Z = 4 m; (720 - 320) * 4 / 800 = 2 m right, (40 - 240) * 4 / 800 = 1 m up.
        assert_eq!(camera(0.0).point(720.0, 40.0, 50.0), Some([2.0, -1.0, 4.0]));
    }

    #[test]
    fn the_middle_is_a_pixel_or_between_two() {
        assert_eq!(middle((5, 4)), [2.0, 1.5]);
        assert_eq!(middle((1, 1)), [0.0, 0.0]);
    }

    #[test]
    fn a_map_keeps_its_holes() {
        let map = Plane::new(5, 1, vec![50.0, f32::NAN, 0.0, 100.0, 1e-45]).unwrap();
        let depth = camera(0.0).depth_map(&map);
        assert_eq!((depth.samples()[0], depth.samples()[3]), (4.0, 2.0));
        for hole in [1, 2, 4] {
            assert!(depth.samples()[hole].is_nan(), "{depth:?}");
        }
    }

    #[test]
    fn pixels_with_a_depth_are_points_in_the_order_of_rows() {
        let camera = StereoCamera::new(100.0, 0.5, 0.0, 1.0, 0.0).unwrap();
        let disparities = Plane::new(2, 2, vec![25.0, f32::NAN, 10.0, 50.0]).unwrap();
        let depths = Plane::new(2, 2, vec![2.0, f32::NAN, f32::NAN, 1.0]).unwrap();
        let points: Vec<_> = camera.points(&disparities, &depths).collect();
        assert_eq!(points, [Some([-0.02, 0.0, 2.0]), None, None, Some([0.0, 0.01, 1.0])]);
        let (disparities, depths) = (Plane::filled(3, 2, 50.0), Plane::filled(3, 2, 1.0));
        let places: Vec<_> = camera.points(&disparities, &depths).flatten().collect();
        let at = |x: f32, y: f32| [(x - 1.0) / 100.0, y / 100.0, 1.0];
        let rows =
            [at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(2.0, 1.0)];
        assert_eq!(places, rows);
    }

    #[test]
    fn a_coordinate_beyond_32_bits_is_no_point() {
        // Depth 1e32 m, and 1e10 px beside the axis of a focal length of 100 px: 1e40 m.
        let camera = StereoCamera::new(100.0, 1.0, 0.0, 1e10, 0.0).unwrap();
        let disparities = Plane::new(2, 1, vec![1e-30, 50.0]).unwrap();
        let depths = camera.depth_map(&disparities);
        assert_eq!(depths.samples()[0], 1e32);
        let points: Vec<_> = camera.points(&disparities, &depths).collect();
        assert_eq!(points[0], None);
        assert!(points[1].is_some(), "{points:?}");
    }

    #[test]
    fn unusable_numbers_are_named() {
        let error = StereoCamera::new(0.0, 1.0, 0.0, 0.0, 0.0).unwrap_err();
        assert!(error.to_string().contains("focal length in pixels is 0"), "{error}");
        let error = StereoCamera::new(1.0, -0.5, 0.0, 0.0, 0.0).unwrap_err();
        assert!(error.to_string().contains("baseline"), "{error}");
        let error = StereoCamera::new(1.0, 1.0, f64::NAN, 0.0, 0.0).unwrap_err();
        assert!(error.to_string().contains("doffs"), "{error}");
        for (focal, baseline, product) in [(1e200, 1e200, "inf"), (1e-200, 1e-200, "0")] {
            let error = StereoCamera::new(focal, baseline, 0.0, 0.0, 0.0).unwrap_err();
            let expected = format!("times baseline in metres is {product}, but it must be finite");
            assert!(error.to_string().contains(&expected), "{error}");
        }
    }

    #[test]
    fn a_scaled_camera_sees_the_same_points() {
        let camera = StereoCamera::new(700.0, 0.12, 8.0, 310.0, 200.0).unwrap();
        let half = camera.scaled(0.5).unwrap();
        // The left edge of the pixel in column 100 of the half image is that of column 200.
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        let whole = camera.point(199.5, 99.5, 34.0).unwrap();
        assert!(near(half.point(99.5, 49.5, 17.0).unwrap(), whole));
        assert!(camera.scaled(0.0).is_err() && camera.scaled(f64::NAN).is_err());
    }
}
