//! Rays through both cameras: pictures, exact truth, and what is hidden.
//!
//! * **Truth** is the disparity of the first surface on the ray through the pixel's centre; a ray
//!   that meets nothing shows a point at infinity.
//! * **Occlusion** is asked of the geometry: from the right camera, a ray towards the point that
//!   the left pixel shows. The pixel is occluded when something on that ray has a disparity larger
//!   by more than [`OCCLUSION_TOLERANCE`], or when the point falls outside the right image, whose
//!   pixels reach half a pixel beyond their centres.
//! * **Pictures** average four rays per pixel on a rotated grid, and sixteen where those four see
//!   different things, or some the sun and some a shadow; textures are filtered (see
//!   [`crate::texture`]) and need no more. The places of the rays are the same in every pixel
//!   and in both views, so antialiasing adds no noise.
//!
//! Rows are independent and computed in parallel; the number of threads changes nothing.

use camera::StereoCamera;
use raster::{DisparityRange, Image, Plane};
use rayon::prelude::*;

use crate::kinds::Stage;
use crate::light::Seen;
use crate::masks;
use crate::rig::{Rig, Side};
use crate::sensor::{Sensor, luma};
use crate::settings::{Settings, SettingsError};
use crate::vector::{Vector, vector};
use crate::world::World;

/// A point counts as hidden when what stands before it has a disparity larger by more than this
/// many pixels. It absorbs rounding and grazing surfaces, and is far below what scores can see.
pub const OCCLUSION_TOLERANCE: f64 = 0.05;

/// A rendered stereo pair and all that is known about it. All planes have the images' size.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The scene's name, from its kind and seed.
    pub name: String,
    /// What the left camera saw.
    pub left: Image,
    /// What the right camera saw.
    pub right: Image,
    /// Disparity of every left pixel in pixels, `x_right = x_left - d`. Every pixel has one.
    pub truth_left: Plane<f32>,
    /// Disparity of every right pixel in pixels, `x_left = x_right + d`. Every pixel has one.
    pub truth_right: Plane<f32>,
    /// Left pixels that the right camera does not see, because something nearer hides them or
    /// because they fall outside its image.
    pub occluded: Plane<bool>,
    /// Left pixels near a depth discontinuity ([`crate::DISCONTINUITY_GAP`]).
    pub discontinuity: Plane<bool>,
    /// Left pixels without texture before noise ([`crate::TEXTURELESS_THRESHOLD`]).
    pub textureless: Plane<bool>,
    /// Left pixels of things a few pixels wide or high ([`crate::THIN_WIDTH`]).
    pub thin: Plane<bool>,
    /// Left pixels of surfaces whose texture repeats: stripes, checks, dots, windows.
    pub repeated: Plane<bool>,
    /// The disparities to search: no truth lies outside, but some of the right view's where a
    /// [`Kind::Plane`](crate::Kind::Plane) is steep.
    pub range: DisparityRange,
    /// The cameras, or `None` when both stand at one place (a range of one disparity; a plane is always
    /// seen from two).
    pub camera: Option<StereoCamera>,
}

/// Renders the scene. Errors, before any work, at the first setting that cannot be rendered.
pub fn render(settings: &Settings) -> Result<Scene, SettingsError> {
    settings.check()?;
    let range = settings.range()?;
    let Stage { world, rig } = settings.kind.build(settings);
    let left = shaded(&world, &rig, Side::Left, settings);
    let right = shaded(&world, &rig, Side::Right, settings);
    let (depth, repeated) = centres(&world, &rig, settings.contrast);
    let truth_left = truth(&depth, &rig);
    let grey = left.map(|&v| 255.0 * luma(v));
    Ok(Scene {
        name: settings.name(),
        left: Sensor::new(settings, Side::Left).read(&left),
        right: Sensor::new(settings, Side::Right).read(&right),
        truth_right: truth(&right_depth(&world, &rig), &rig),
        occluded: occluded(&world, &rig, &depth),
        discontinuity: masks::discontinuity(&truth_left),
        textureless: masks::textureless(&grey),
        thin: masks::thin(&truth_left),
        repeated,
        truth_left,
        range,
        camera: StereoCamera::new(rig.focal, rig.baseline, rig.doffs, rig.cx, rig.cy).ok(),
    })
}

/// One sample per pixel, rows in parallel.
fn by_rows<T: Clone + Default + Send>(
    rig: &Rig,
    sample: impl Fn(usize, usize) -> T + Sync,
) -> Plane<T> {
    let mut plane = Plane::filled(rig.columns, rig.rows, T::default());
    plane.samples_mut().par_chunks_mut(rig.columns).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            *out = sample(x, y);
        }
    });
    plane
}

/// The camera sees nothing before this depth. A hair less than `near`, so that a surface exactly
/// there, at the largest disparity, is seen.
fn first_depth(rig: &Rig) -> f64 {
    rig.near * (1.0 - 1e-9)
}

/// Depth of the first surface at the centre of every left pixel, infinity where there is none, and
/// whether it has a repeated texture that shows.
fn centres(world: &World, rig: &Rig, contrast: f64) -> (Plane<f64>, Plane<bool>) {
    let seen = by_rows(rig, |x, y| {
        match world.hit(&rig.ray(Side::Left, x as f64, y as f64), first_depth(rig)) {
            Some(hit) => (hit.t, contrast > 0.0 && hit.material.pattern.is_repeated()),
            None => (f64::INFINITY, false),
        }
    });
    (seen.map(|&(depth, _)| depth), seen.map(|&(_, repeated)| repeated))
}

/// Depth of the first surface at the centre of every right pixel; infinity where there is none.
fn right_depth(world: &World, rig: &Rig) -> Plane<f64> {
    by_rows(rig, |x, y| world.distance(&rig.ray(Side::Right, x as f64, y as f64), first_depth(rig)))
}

fn truth(depth: &Plane<f64>, rig: &Rig) -> Plane<f32> {
    depth.map(|&depth| rig.disparity(depth) as f32)
}

fn occluded(world: &World, rig: &Rig, depth: &Plane<f64>) -> Plane<bool> {
    let (right_edge, bottom_edge) = (rig.columns as f64 - 0.5, rig.rows as f64 - 0.5);
    by_rows(rig, |x, y| {
        let d = rig.disparity(depth.row(y)[x]);
        let (x, y) = (x as f64 - d, y as f64 + rig.vertical);
        if !((-0.5..right_edge).contains(&x) && (-0.5..bottom_edge).contains(&y)) {
            return true;
        }
        let before = world.distance(&rig.ray(Side::Right, x, y), first_depth(rig));
        rig.disparity(before) > d + OCCLUSION_TOLERANCE
    })
}

/// Where the rays of a pixel go, from its centre: the four of the rotated grid, then the other
/// twelve of the 4 x 4 grid that they belong to.
const RAYS: [(f64, f64); 16] = [
    (-0.125, -0.375),
    (0.375, -0.125),
    (0.125, 0.375),
    (-0.375, 0.125),
    (-0.375, -0.375),
    (0.125, -0.375),
    (0.375, -0.375),
    (-0.375, -0.125),
    (-0.125, -0.125),
    (0.125, -0.125),
    (-0.125, 0.125),
    (0.125, 0.125),
    (0.375, 0.125),
    (-0.375, 0.375),
    (-0.125, 0.375),
    (0.375, 0.375),
];
const FIRST_RAYS: usize = 4;

/// The sensor's values before noise.
fn shaded(world: &World, rig: &Rig, side: Side, settings: &Settings) -> Plane<[f32; 3]> {
    let sensor = Sensor::new(settings, side);
    let spread = 1.0 / rig.focal;
    by_rows(rig, |x, y| {
        let light = |(dx, dy): (f64, f64)| {
            let ray = rig.ray(side, x as f64 + dx, y as f64 + dy);
            world.radiance(&ray, first_depth(rig), spread, settings.contrast)
        };
        let first: [(Vector, Seen); FIRST_RAYS] = std::array::from_fn(|i| light(RAYS[i]));
        let mut sum = first.iter().fold(vector(0.0, 0.0, 0.0), |sum, f| sum + f.0);
        let mut count = FIRST_RAYS;
        if first.iter().any(|ray| ray.1 != first[0].1) {
            sum = RAYS[FIRST_RAYS..].iter().fold(sum, |sum, &at| sum + light(at).0);
            count = RAYS.len();
        }
        sensor.respond(sum * (1.0 / count as f64))
    })
}
