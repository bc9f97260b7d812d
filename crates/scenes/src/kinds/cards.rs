//! Fronto-parallel cards before a wall, each at a whole number of quarter pixels of disparity.
//!
//! Between the edges of the cards, everything about the scene is known exactly, and nothing but
//! occlusion is hard about it.

use super::Stage;
use super::plane::{easy_texture, even_light};
use crate::geometry::Panel;
use crate::random::Random;
use crate::rig::{Pose, Rig};
use crate::settings::Settings;
use crate::texture::Material;
use crate::vector::{Frame, vector};
use crate::world::{Object, World};

const CARDS: usize = 14;
/// Depth of the largest disparity, in metres.
const NEAR: f64 = 1.0;

pub(super) fn build(settings: &Settings) -> Stage {
    let mut random = Random::new(settings.seed, "cards");
    let pose = Pose::looking_ahead(vector(0.0, 0.0, 0.0), 0.0);
    let focal = settings.columns.max(settings.rows) as f64;
    let rig = Rig::new(settings, pose, focal, NEAR);
    // Disparities above that of infinity, in quarters of a pixel.
    let span = 4.0 * (f64::from(settings.max_disparity) - f64::from(settings.min_disparity));
    let depth = |share: f64| {
        let quarters = (share * span).round();
        // A range of one disparity has its cameras at one place: any depth will do.
        if quarters > 0.0 { NEAR * span / quarters } else { NEAR / share }
    };
    // Texture is as fine in the image at every depth.
    let material = |depth: f64| -> Material { easy_texture(focal / depth) };

    let wall = depth(0.15);
    let facing = Frame { x: pose.right, y: pose.down, z: pose.forward };
    let reach = 1e4 * wall;
    let mut objects = vec![Object {
        shape: Panel::new(pose.point(0.0, 0.0, wall), facing, reach, reach).into(),
        material: material(wall),
    }];
    for _ in 0..CARDS {
        let depth = depth(random.between(0.2, 1.0));
        let across = 0.5 * depth / focal;
        let x = random.between(-0.9, 0.9) * settings.columns as f64 * across;
        let y = random.between(-0.9, 0.9) * settings.rows as f64 * across;
        let width = random.between(0.05, 0.3) * settings.columns as f64 * across;
        let height = random.between(0.05, 0.4) * settings.rows as f64 * across;
        let panel = Panel::new(pose.point(x, y, depth), facing, width, height);
        objects.push(Object { shape: panel.into(), material: material(depth) });
    }
    Stage { world: World::new(objects, None, even_light(), settings.seed), rig }
}
