//! Renders one scene into a folder, to be looked at:
//! `cargo run --release -p hazcam-scenes --example look -- KIND SEED FOLDER [COLUMNS ROWS MAX]`.

use std::error::Error;
use std::fs::{File, create_dir_all};
use std::path::Path;
use std::time::Instant;

use raster::{Image, Plane};
use scenes::{Settings, render};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [kind, seed, folder, rest @ ..] = arguments.as_slice() else {
        return Err("give KIND SEED FOLDER [COLUMNS ROWS MAX]".into());
    };
    let mut settings = Settings::new(kind.parse()?, seed.parse()?);
    if let [columns, rows, max] = rest {
        settings.columns = columns.parse()?;
        settings.rows = rows.parse()?;
        settings.max_disparity = max.parse()?;
    }
    let start = Instant::now();
    let scene = render(&settings)?;
    eprintln!("{} in {:.2} s, {:?}", scene.name, start.elapsed().as_secs_f64(), scene.camera);
    let folder = Path::new(folder);
    create_dir_all(folder)?;
    let save = |what: &str, image: &Plane<[u8; 3]>| -> Result<(), Box<dyn Error>> {
        let file = File::create(folder.join(format!("{}-{what}.png", scene.name)))?;
        let mut encoder = png::Encoder::new(file, image.columns() as u32, image.rows() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header()?.write_image_data(image.samples().as_flattened())?;
        Ok(())
    };
    for (what, image) in [("left", &scene.left), ("right", &scene.right)] {
        if let Image::Rgb8(image) = image {
            save(what, image)?;
        }
    }
    // Disparity as grey; occluded pixels reddish, discontinuities bluish, textureless greenish.
    let scale = 255.0 / f32::from(u16::try_from(settings.max_disparity)?.max(1));
    let truth = &scene.truth_left;
    save("truth", &truth.map(|&d| [(d * scale) as u8; 3]))?;
    save(
        "masks",
        &Plane::from_fn(truth.columns(), truth.rows(), |x, y| {
            let grey = (truth.row(y)[x] * scale * 0.7) as u8;
            [&scene.occluded, &scene.textureless, &scene.discontinuity]
                .map(|mask| if mask.row(y)[x] { 255 } else { grey })
        }),
    )?;
    Ok(())
}
