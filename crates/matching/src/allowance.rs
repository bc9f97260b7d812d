//! How much memory a frame may take.

use crate::MatchError;
use crate::machine;
use crate::matcher::Frame;

/// What the options allow, and what there is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Allowance {
    asked: Option<usize>,
    there: Option<usize>,
}

impl Allowance {
    /// With what there is at this time.
    pub fn new(asked: Option<usize>) -> Self {
        Self { asked, there: machine::memory() }
    }

    /// Refuses a frame that needs more bytes than are allowed, or than there are.
    pub fn admit(&self, frame: &Frame<'_>, needed: usize) -> Result<(), MatchError> {
        let ((columns, rows), disparities) = (frame.size(), frame.range.count());
        match (self.asked, self.there) {
            (Some(limit), _) if needed > limit => {
                Err(MatchError::Memory { columns, rows, disparities, needed, limit })
            }
            (_, Some(there)) if needed > there => {
                Err(MatchError::MachineMemory { columns, rows, disparities, needed, there })
            }
            _ => Ok(()),
        }
    }

    /// The most bytes to take where so many would be convenient: those if nothing else was said.
    pub fn most(&self, convenient: usize) -> usize {
        self.asked.unwrap_or(convenient).min(self.there.unwrap_or(usize::MAX))
    }
}

#[cfg(test)]
mod tests {
    use raster::{BoundingBox, DisparityRange, Image, Plane};

    use super::*;

    #[test]
    fn a_frame_must_fit_what_is_allowed_and_what_there_is() {
        let image = Image::Grey8(Plane::filled(70_000, 3, 0));
        let frame = Frame {
            left: &image,
            right: &image,
            bounds: BoundingBox::whole(70_000, 3),
            range: DisparityRange::new(0, 16_383).unwrap(),
        };
        let needed = 28_706_000_000;
        let admit = |asked, there| Allowance { asked, there }.admit(&frame, needed);
        assert_eq!(admit(None, None), Ok(()));
        assert_eq!(admit(Some(needed), Some(needed)), Ok(()));
        let error = admit(None, Some(16_000_000_000)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "70000 x 3 pixels and 16384 disparities need at least 28706 MB, but there are \
             16000 MB for it on this machine, or in this container (three quarters of its \
             limit): narrow the range, or match a box"
        );
        // Who allows more than there is has to know; who allows less is told what was allowed.
        assert_eq!(admit(Some(2 * needed), Some(16_000_000_000)), Err(error));
        let error = admit(Some(1_000_000_000), Some(16_000_000_000)).unwrap_err();
        assert!(
            error.to_string().starts_with("option `memory` is 1000 MB, but 70000 x 3 "),
            "{error}"
        );
    }

    #[test]
    fn what_is_convenient_is_taken_unless_less_is_allowed_or_there() {
        let most = |asked, there| Allowance { asked, there }.most(200);
        assert_eq!(most(None, None), 200);
        assert_eq!(most(Some(300), None), 300);
        assert_eq!(most(Some(100), Some(150)), 100);
        assert_eq!(most(Some(300), Some(150)), 150);
        assert_eq!(most(None, Some(150)), 150);
    }
}
