//! How much memory a frame may take.

use crate::MatchError;
use crate::machine::{BOUNDS, Memory, taken};
use crate::matcher::Frame;

/// Bytes per pixel of copies of the answer that others keep, of this frame and of the one before.
const ANSWERS: usize = 2 * (4 + 1 + 4);
/// Bytes for all else that a process takes while it matches and writes.
const ODDS_AND_ENDS: usize = 16 << 20;

/// What the options allow for a frame, and what there is for it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Allowance {
    asked: Option<usize>,
    there: Option<usize>,
    /// Where this process is bounded to less than there is.
    bound: Option<usize>,
}

impl Allowance {
    /// What a process that has `taken` so many bytes of each bound may take for a frame of so many pixels. Its images
    /// are among the former.
    fn new(asked: Option<usize>, memory: Memory, taken: [usize; BOUNDS], pixels: usize) -> Self {
        let besides = ANSWERS * pixels + ODDS_AND_ENDS;
        let left = |(bound, taken): (Option<usize>, usize)| {
            bound.map(|bound| (bound.saturating_sub(taken + besides), bound))
        };
        match memory.bounds.into_iter().zip(taken).filter_map(left).min() {
            None => Self { asked, there: memory.whole, bound: None },
            Some((there, bound)) => Self { asked, there: Some(there), bound: Some(bound) },
        }
    }

    /// Whatever is convenient: for who has not asked what there is.
    pub fn unbounded() -> Self {
        Self { asked: None, there: None, bound: None }
    }

    /// Refuses a frame that needs more bytes than are allowed, or than there are.
    fn admit(&self, frame: &Frame<'_>, needed: usize) -> Result<(), MatchError> {
        let ((columns, rows), disparities) = (frame.size(), frame.range.count());
        let bound = self.bound;
        match (self.asked, self.there) {
            (Some(limit), _) if needed > limit => {
                Err(MatchError::Memory { columns, rows, disparities, needed, limit })
            }
            (_, Some(there)) if needed > there => {
                Err(MatchError::MachineMemory { columns, rows, disparities, needed, there, bound })
            }
            _ => Ok(()),
        }
    }

    /// The most bytes to take where so many would be convenient: those if nothing else was said.
    pub fn most(&self, convenient: usize) -> usize {
        self.asked.unwrap_or(convenient).min(self.there.unwrap_or(usize::MAX))
    }
}

/// Allows a matcher's frames their memory.
#[derive(Debug)]
pub(crate) struct Admission {
    asked: Option<usize>,
    memory: Memory,
    /// The most that a frame needed and the most pixels that one had so far, and what was allowed.
    largest: Option<([usize; 2], Allowance)>,
}

impl Admission {
    /// With what there is at this time.
    pub fn new(asked: Option<usize>) -> Self {
        Self { asked, memory: Memory::now(), largest: None }
    }

    /// What a frame may take that needs so many bytes at the least; an error where that is not enough. What the
    /// process has taken is asked only when a frame needs more, or has more pixels, than all before: the matcher's own
    /// memory is then counted twice at the worst, and never for frames of one size.
    pub fn of(&mut self, frame: &Frame<'_>, needed: usize) -> Result<Allowance, MatchError> {
        let (columns, rows) = frame.size();
        let pixels = columns * rows;
        let (most, allowance) = match self.largest {
            Some((most, allowance)) if needed <= most[0] && pixels <= most[1] => (most, allowance),
            before => {
                let most = before.map_or([0; 2], |(most, _)| most);
                let most = [most[0].max(needed), most[1].max(pixels)];
                (most, Allowance::new(self.asked, self.memory, taken(), most[1]))
            }
        };
        allowance.admit(frame, needed)?;
        self.largest = Some((most, allowance));
        Ok(allowance)
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
        let admit = |asked, there| Allowance { asked, there, bound: None }.admit(&frame, needed);
        assert_eq!(admit(None, None), Ok(()));
        assert_eq!(admit(Some(needed), Some(needed)), Ok(()));
        let error = admit(None, Some(16_000_000_000)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "70000 x 3 pixels and 16384 disparities need at least 28706 MB, but this machine \
             has 16000 MB: narrow the range, or match a box"
        );
        // Who allows more than there is has to know; who allows less is told what was allowed.
        assert_eq!(admit(Some(2 * needed), Some(16_000_000_000)), Err(error));
        let error = admit(Some(1_000_000_000), Some(16_000_000_000)).unwrap_err();
        assert!(error.to_string().starts_with("`memory` is 1000 MB, but 70000 x 3 "), "{error}");
    }

    #[test]
    fn what_is_convenient_is_taken_unless_less_is_allowed_or_there() {
        let most = |asked, there| Allowance { asked, there, bound: None }.most(200);
        assert_eq!(most(None, None), 200);
        assert_eq!(most(Some(300), None), 300);
        assert_eq!(most(Some(100), Some(150)), 100);
        assert_eq!(most(Some(300), Some(150)), 150);
        assert_eq!(most(None, Some(150)), 150);
    }

    #[test]
    fn a_bound_leaves_what_is_not_taken_for_else() {
        let memory = |bounds| Memory { whole: Some(8 << 30), bounds };
        let there = |bounds, taken| Allowance::new(None, memory(bounds), taken, 1 << 20);
        let taken = [10 << 20, 50 << 20, 20 << 20];
        assert_eq!(there([None; BOUNDS], taken).there, Some(8 << 30));
        // Of 100 MiB the process has 10, others keep 18 of answers, and 16 are for odds and ends.
        assert_eq!(there([Some(100 << 20), None, None], taken).there, Some(56 << 20));
        assert_eq!(there([Some(40 << 20), None, None], taken).there, Some(0));
        // Of several bounds that counts which leaves the least.
        let least = there([Some(100 << 20), Some(120 << 20), Some(300 << 20)], taken);
        assert_eq!((least.there, least.bound), (Some(36 << 20), Some(120 << 20)));
        let least = there([None, None, Some(90 << 20)], taken);
        assert_eq!((least.there, least.bound), (Some(36 << 20), Some(90 << 20)));
        let image = Image::Grey8(Plane::filled(30, 20, 0));
        let bounds = BoundingBox::whole(30, 20);
        let range = DisparityRange::new(0, 15).unwrap();
        let memory = memory([Some(100 << 20), None, None]);
        let allowance = Allowance::new(None, memory, [90 << 20, 0, 0], 600);
        let frame = Frame { left: &image, right: &image, bounds, range };
        assert_eq!(
            allowance.admit(&frame, 5_000_000).unwrap_err().to_string(),
            "30 x 20 pixels and 16 disparities need at least 5 MB, but of the 104 MB that this \
             process may take 0 MB are left for that: raise the limit of its container, service or \
             shell (ulimit), use fewer threads, narrow the range, or match a box"
        );
    }

    #[test]
    fn what_is_there_is_asked_again_for_larger_frames_alone() {
        let image = Image::Grey8(Plane::filled(30, 20, 0));
        let (bounds, range) = (BoundingBox::whole(30, 20), DisparityRange::new(0, 15).unwrap());
        let frame = Frame { left: &image, right: &image, bounds, range };
        let memory = Memory { whole: Some(8 << 30), bounds: [Some(4 << 30), None, None] };
        let mut admission = Admission { asked: None, memory, largest: None };
        let first = admission.of(&frame, 1000).unwrap().there;
        // More than other tests in this process may give back meanwhile.
        let more = std::hint::black_box(vec![1u8; 256 << 20]);
        assert_eq!(admission.of(&frame, 1000).unwrap().there, first);
        let less = admission.of(&frame, 1001).unwrap().there;
        assert!(less < first, "{}", more.len());
        // More pixels that need less, and then as before: neither is asked again once both have been.
        let large = Image::Grey8(Plane::filled(300, 200, 0));
        let of_box = Frame { left: &large, right: &large, ..frame };
        let wide = admission.of(&of_box, 900).unwrap().there;
        assert!(wide < less);
        let more = std::hint::black_box(vec![1u8; 256 << 20]);
        assert_eq!(admission.of(&of_box, 900).unwrap().there, wide);
        assert_eq!(admission.of(&frame, 1001).unwrap().there, wide, "{}", more.len());
    }
}
