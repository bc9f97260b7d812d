//! Rendered scenes as cases: the arena does not know how to render.

use arena::dataset::{Case, CaseData, CaseRegion};
use scenes::{Kind, Settings};

/// The scenes of `hazcam demo`.
pub fn demo() -> Vec<Case> {
    let named = |settings: Settings| case(format!("demo/{}", settings.name()), settings);
    scenes::demo_scenes().into_iter().map(named).collect()
}

/// The scenes of `hazcam bench --stress`, one family for each assumption that is strained.
pub fn stress() -> Vec<Case> {
    let named = |(label, settings): (String, Settings)| {
        case(format!("stress/{}", label.replace([' ', '/'], "-")), settings)
    };
    scenes::stress_scenes().into_iter().map(named).collect()
}

/// Cards of a size, with disparities from 0 to below `disparities`: for speed, to which it matters
/// little what is seen.
pub fn of_size(id: String, columns: usize, rows: usize, disparities: u16) -> Case {
    let mut settings = Settings::new(Kind::Cards, 1);
    (settings.columns, settings.rows) = (columns, rows);
    settings.max_disparity = i32::from(disparities) - 1;
    case(id, settings)
}

fn case(id: String, settings: Settings) -> Case {
    Case::rendered(id, move || render(&settings))
}

/// Renders a scene with exact truth of every pixel and all its regions.
pub fn render(settings: &Settings) -> Result<CaseData, String> {
    let scene = scenes::render(settings).map_err(|error| error.to_string())?;
    let mut data = CaseData::new(scene.left, scene.right, scene.range);
    data.camera = scene.camera;
    data.truth = Some(scene.truth_left);
    data.add_occlusions(&scene.occluded);
    for (name, mask) in [
        ("discontinuity", scene.discontinuity),
        ("thin", scene.thin),
        ("textureless", scene.textureless),
        ("repeated", scene.repeated),
    ] {
        data.regions.push(CaseRegion { name, mask, truth: None });
    }
    data.protocol = vec![
        format!("rendered ({}), exact truth of every pixel", scene.name),
        "whole image, the left strip included".into(),
    ];
    Ok(data)
}
