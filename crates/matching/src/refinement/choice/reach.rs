//! Where a pixel's candidates come from: rings of places around it, the inner ones first.

use super::edges::way;

/// The most candidates that a pixel has.
pub(crate) const MOST: usize = 32;
/// So many candidates are compared with the others at once: a pixel has whole groups of them.
pub(super) const GROUP: usize = 4;

/// A place that a candidate comes from, seen from the pixel, in pixels that are matched.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub columns: i32,
    pub rows: i32,
    /// Which of the ways through the image leads there.
    pub way: usize,
}

impl Place {
    /// How many columns and rows of the image away it is where every so many-th one is matched.
    #[inline(always)]
    pub fn pixels(&self, every: usize) -> [f32; 2] {
        [self.columns, self.rows].map(|way| (way * every as i32) as f32)
    }

    /// The column in which it lies from pixel `(x, y)`, and its row if a map of so many has it.
    #[inline(always)]
    pub fn seen_from(&self, x: usize, y: usize, rows: usize) -> (i64, Option<usize>) {
        let row = y as i64 + i64::from(self.rows);
        let row = if row >= 0 && row < rows as i64 { Some(row as usize) } else { None };
        (x as i64 + i64::from(self.columns), row)
    }
}

/// The places of all candidates of a pixel; the first is its own.
#[derive(Debug)]
pub(crate) struct Reach {
    pub places: &'static [Place],
    /// So many of them belong to the inner rings.
    pub inner: usize,
    /// A match that was never in doubt, and whose inner rings lie within so many pixels, is left alone.
    pub settled: f32,
    /// Where all candidates lie within so many pixels there is nothing to choose.
    pub choice: f32,
    /// Who sees so many places that moved in a round, its own among them, is asked again in the next; those of
    /// the inner rings count twice.
    pub moved: u8,
    /// Every so many-th column of every so many-th row of the image is matched, 1 or 2; places count no others.
    pub every: usize,
}

impl Reach {
    /// Whether what stands alone is taken out between two rounds. Where not all pixels are matched, what is thin
    /// would go with it: three of these pixels are five of the image.
    pub fn smooths(&self) -> bool {
        self.every == 1
    }

    /// How many rows that are matched it goes up or down.
    pub fn rows(&self) -> usize {
        self.places.iter().map(|place| place.rows.unsigned_abs() as usize).max().unwrap_or(0)
    }
}

const fn places<const N: usize>(around: [(i32, i32); N]) -> [Place; N] {
    assert!(N <= MOST && N.is_multiple_of(GROUP));
    let mut places = [Place { columns: 0, rows: 0, way: 0 }; N];
    let mut k = 0;
    while k < N {
        let (columns, rows) = around[k];
        places[k] = Place { columns, rows, way: way(around[k]) };
        k += 1;
    }
    places
}

/// What `balanced` looks at: far along the row, where occluded pixels find their surface.
pub(crate) static NARROW: Reach = Reach {
    places: &const {
        places([
            (0, 0),
            (1, 0),
            (-1, 0),
            (0, 1),
            (0, -1),
            (2, 2),
            (-2, -2),
            (2, -2),
            (-2, 2),
            (5, 0),
            (-5, 0),
            (0, 5),
            (0, -5),
            (8, 8),
            (-8, -8),
            (8, -8),
            (-8, 8),
            (12, 0),
            (-12, 0),
            (0, 12),
            (0, -12),
            (24, 0),
            (-24, 0),
            (0, -24),
        ])
    },
    inner: 5,
    settled: 1.0,
    choice: 2.0,
    moved: 2,
    every: 2,
};

/// What `best` looks at.
pub(crate) static WIDE: Reach = Reach {
    places: &const {
        places([
            (0, 0),
            (2, 0),
            (-2, 0),
            (0, 2),
            (0, -2),
            (3, 3),
            (-3, -3),
            (3, -3),
            (-3, 3),
            (5, 0),
            (-5, 0),
            (0, 5),
            (0, -5),
            (7, 7),
            (-7, -7),
            (7, -7),
            (-7, 7),
            (11, 0),
            (-11, 0),
            (0, 11),
            (0, -11),
            (15, 15),
            (-15, -15),
            (15, -15),
            (-15, 15),
            (24, 0),
            (-24, 0),
            (0, 24),
            (0, -24),
            (48, 0),
            (-48, 0),
            (0, -48),
        ])
    },
    inner: 13,
    settled: 1.0,
    choice: 0.5,
    moved: 1,
    every: 1,
};
