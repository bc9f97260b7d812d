//! Where to score: a box, a mask, both, or the whole image.

use std::borrow::Cow;

use raster::{BoundingBox, Plane};

/// The pixels that are scored, as far as their truth is known: those inside the box whose mask is
/// true. Without a box or a mask, all.
#[derive(Debug, Clone)]
pub struct Region<'a> {
    name: Cow<'static, str>,
    bounds: Option<BoundingBox>,
    mask: Option<&'a Plane<bool>>,
}

impl<'a> Region<'a> {
    /// Every pixel with a known truth; its name is "all".
    pub fn whole() -> Self {
        Self { name: "all".into(), bounds: None, mask: None }
    }

    /// The pixels whose `mask` is true, under a name for tables and protocols: "non-occluded",
    /// "occluded", "discontinuity", "textureless", or the mask's file.
    pub fn masked(name: impl Into<Cow<'static, str>>, mask: &'a Plane<bool>) -> Self {
        Self { name: name.into(), bounds: None, mask: Some(mask) }
    }

    /// The same, but only inside a box. `None` takes the box away.
    pub fn within(mut self, bounds: Option<BoundingBox>) -> Self {
        self.bounds = bounds;
        self
    }

    /// The region's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The box, if there is one.
    pub fn bounds(&self) -> Option<BoundingBox> {
        self.bounds
    }

    /// The mask, if there is one.
    pub fn mask(&self) -> Option<&'a Plane<bool>> {
        self.mask
    }

    /// In words, for protocols and errors: "the box 3,4,10,12 (inclusive) under the mask
    /// `non-occluded`".
    pub fn describe(&self) -> String {
        let area = match self.bounds {
            Some(bounds) => format!("the box {bounds} (inclusive)"),
            None => "the whole image".into(),
        };
        match self.mask {
            Some(_) => format!("{area} under the mask `{}`", self.name),
            None => area,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_says_what_it_is() {
        let mask = Plane::filled(2, 2, true);
        let bounds = BoundingBox::new(0, 0, 1, 0).unwrap();
        assert_eq!(Region::whole().describe(), "the whole image");
        assert_eq!(
            Region::masked("non-occluded", &mask).within(Some(bounds)).describe(),
            "the box 0,0,1,0 (inclusive) under the mask `non-occluded`"
        );
    }
}
