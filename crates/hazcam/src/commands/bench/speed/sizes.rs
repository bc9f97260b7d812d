//! The images on which speed is measured.

use arena::dataset::{Case, CaseData, DatasetError};
use raster::{DisparityRange, Grey, Image};

use super::super::rendered;
use super::super::scenes::SceneArguments;
use crate::ui::Ui;

/// A pair to be matched again and again.
pub struct Size {
    /// Where the images come from.
    pub case: Case,
    /// How many disparities are searched, from 0 on.
    disparities: u16,
    /// How many rounds are measured unless the user says otherwise.
    pub rounds: usize,
    /// Whether engines that take their time run here too.
    pub for_slow: bool,
}

impl Size {
    fn rendered(
        id: String,
        (columns, rows): (usize, usize),
        disparities: u16,
        rounds: usize,
    ) -> Self {
        let case = rendered::of_size(id, columns, rows, disparities);
        Self { case, disparities, rounds, for_slow: false }
    }

    /// The images in grey, to be answered everywhere: all engines do the same work, and none is
    /// charged for making grey of colour.
    pub fn load(&self) -> Result<CaseData, DatasetError> {
        let CaseData { left, right, .. } = self.case.load()?;
        let range = DisparityRange::new(0, i32::from(self.disparities) - 1)
            .expect("no size is without disparities");
        Ok(CaseData::new(grey(&left), grey(&right), range))
    }
}

/// Cones with 64 disparities and KITTI with 160 from the data that is there, and a rendered pair of
/// 6 megapixels with 256. Where there is no data, rendered pairs of the sizes of the first two.
pub fn fixed(scenes: &SceneArguments, ui: &Ui) -> anyhow::Result<Vec<Size>> {
    let on_disk = scenes.on_disk()?.map_or(Vec::new(), |(_, cases)| cases);
    let mut stand_ins = Vec::new();
    let mut sizes = Vec::new();
    for (name, size, disparities) in [("cones", (450, 375), 64), ("kitti", (1241, 376), 160)] {
        let id = format!("course/{name}");
        match on_disk.iter().find(|case| case.id == id) {
            Some(found) => {
                let mut case = found.clone();
                case.id = name.into();
                sizes.push(Size { case, disparities, rounds: 20, for_slow: false });
            }
            None => {
                stand_ins.push(id);
                sizes.push(Size::rendered(format!("{name}-sized"), size, disparities, 20));
            }
        }
    }
    if !stand_ins.is_empty() {
        ui.note(format_args!(
            "rendered pairs of the same size stand in for {}: HAZCAM_DATA or --data would name a \
             folder with them",
            stand_ins.join(" and ")
        ));
    }
    sizes[0].for_slow = true;
    sizes.push(Size::rendered("large".into(), (3000, 2000), 256, 3));
    Ok(sizes)
}

/// Sizes that differ in the number of pixels, then in that of disparities.
pub fn sweep() -> Vec<Size> {
    let middle = (750, 500);
    let growing = [(390, 260), middle, (1500, 1000), (3000, 2000)].map(|size| (size, 64));
    let deepening = [16, 32, 128, 256, 512].map(|disparities| (middle, disparities));
    growing
        .into_iter()
        .chain(deepening)
        .map(|((columns, rows), disparities)| {
            let id = format!("sweep/{columns}x{rows}x{disparities}");
            Size::rendered(id, (columns, rows), disparities, 5)
        })
        .collect()
}

fn grey(image: &Image) -> Image {
    match image.to_grey() {
        Grey::Depth8(plane) => Image::Grey8(plane),
        Grey::Depth16(plane) => Image::Grey16(plane),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_covers_the_range_and_names_each_size_once() {
        let sizes = sweep();
        let mut names: Vec<_> = sizes.iter().map(|size| size.case.id.clone()).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), sizes.len());
        let disparities = sizes.iter().map(|size| size.disparities);
        assert_eq!((disparities.clone().min(), disparities.max()), (Some(16), Some(512)));
    }

    #[test]
    fn images_become_grey_and_the_range_starts_at_0() {
        let data = Size::rendered("small".into(), (40, 20), 16, 1).load().unwrap();
        assert!(matches!((&data.left, &data.right), (Image::Grey8(_), Image::Grey8(_))));
        assert_eq!((data.range.min(), data.range.count(), data.left.size()), (0, 16, (40, 20)));
        assert_eq!((data.bounds.columns(), data.bounds.rows()), (40, 20));
    }
}
