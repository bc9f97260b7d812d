//! Why a scene cannot be used.

use std::io;
use std::path::PathBuf;

use formats::FormatError;
use raster::{BoundingBox, BoundsError};

/// A data set, or one scene of it, cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The folder is not there.
    #[error("{} is not a folder", path.display())]
    NoFolder {
        /// The folder.
        path: PathBuf,
    },
    /// The folder holds nothing that looks like a scene.
    #[error(
        "no scene was found in {}: neither a scenes.json nor one of the known layouts, which are \
         SCENE/im2 and im6 (Middlebury 2001, 2003), SCENE/view1.png and view5.png (2005, 2006), \
         SCENE/im0.png and im1.png (2014, ETH3D), image_0 and image_1 or image_2 and image_3 (KITTI), \
         the course's, left.png and right.png; links to folders are not followed",
        path.display()
    )]
    NoScenes {
        /// The folder.
        path: PathBuf,
    },
    /// Two scenes would go by one id.
    #[error(
        "{} and {} would both be the scene {id}: keep one of them elsewhere, rename its folder, or \
         name scenes in a scenes.json",
        one.display(),
        other.display()
    )]
    SameId {
        /// The id.
        id: String,
        /// The left image of one of them.
        one: PathBuf,
        /// That of the other.
        other: PathBuf,
    },
    /// A folder or the catalogue cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The folder or file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The catalogue is no catalogue.
    #[error("{} is no catalogue of scenes: {problem}", path.display())]
    Catalogue {
        /// The catalogue.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// A file of a scene cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The files of a scene do not belong together.
    #[error(
        "{} is {columns} x {rows}, but the left image is {left_columns} x {left_rows}",
        path.display()
    )]
    SizesDiffer {
        /// The file.
        path: PathBuf,
        /// Its columns.
        columns: usize,
        /// Its rows.
        rows: usize,
        /// Columns of the left image.
        left_columns: usize,
        /// Rows of the left image.
        left_rows: usize,
    },
    /// The calibration is that of images of another size.
    #[error(
        "{} is for images of {} x {}, but these are {} x {}: its ndisp would be a wrong range; take the calibration of \
         this size",
        path.display(),
        stated.0,
        stated.1,
        size.0,
        size.1
    )]
    OfOtherImages {
        /// The calibration.
        path: PathBuf,
        /// Columns and rows that it states.
        stated: (usize, usize),
        /// Those of the images.
        size: (usize, usize),
    },
    /// No pixel that counts has a truth.
    #[error(
        "{} has no known disparity in the box {bounds}: is it the truth of this scene, and its encoding right?",
        path.display()
    )]
    NothingKnown {
        /// The truth.
        path: PathBuf,
        /// The box to answer and score.
        bounds: BoundingBox,
    },
    /// The images of a pair are of different kinds.
    #[error("{} is {kind}, but the left image is {left_kind}: a pair is of one kind", path.display())]
    KindsDiffer {
        /// The right image.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
        /// What the left one is.
        left_kind: &'static str,
    },
    /// The box of a file leaves the images.
    #[error("{}: {source}", path.display())]
    Box {
        /// The box's file.
        path: PathBuf,
        /// What is wrong with it.
        source: BoundsError,
    },
    /// The range makes no sense.
    #[error(transparent)]
    Range(#[from] BoundsError),
    /// A scene cannot be rendered.
    #[error("{0}")]
    Rendering(String),
}
