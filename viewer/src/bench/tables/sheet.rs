//! Pictures side by side, in one exposure.

use crate::tonemap;
use sheen_formats::image::Image;

/// White pixels between two pictures.
const GAP: usize = 8;

/// Pictures of one size, and what each shows.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// As of a file.
    pub name: &'static str,
    tiles: Vec<(String, Image)>,
}

impl Sheet {
    /// Without pictures.
    pub(super) fn new(name: &'static str) -> Self {
        Self {
            name,
            tiles: Vec::new(),
        }
    }

    /// Adds a picture on the right; the last one sets the exposure.
    pub(super) fn add(&mut self, what: impl Into<String>, picture: Image) {
        self.tiles.push((what.into(), picture));
    }

    /// What the pictures show.
    pub(super) fn caption(&self) -> String {
        let names: Vec<&str> = self.tiles.iter().map(|tile| tile.0.as_str()).collect();
        format!(
            "{}.png, from left to right: {}.",
            self.name,
            names.join("; ")
        )
    }

    /// Display bytes, width and height; `None` without pictures.
    pub fn display(&self) -> Option<(Vec<u8>, u32, u32)> {
        let exposure = tonemap::default_exposure(&self.tiles.last()?.1.pixels);
        let height = self.tiles.iter().map(|tile| tile.1.height).max()? as usize;
        let widths = self.tiles.iter().map(|tile| tile.1.width as usize);
        let width = widths.sum::<usize>() + GAP * (self.tiles.len() - 1);
        let mut bytes = vec![255; width * height * 3];
        let mut left = 0;
        for (_, picture) in &self.tiles {
            let shown = tonemap::display_bytes(&picture.pixels, exposure);
            let across = picture.width as usize * 3;
            for (row, pixels) in shown.chunks_exact(across).enumerate() {
                let at = (row * width + left) * 3;
                bytes[at..at + across].copy_from_slice(pixels);
            }
            left += picture.width as usize + GAP;
        }
        Some((bytes, width as u32, height as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheen_solver::Rgb;

    #[test]
    fn pictures_stand_side_by_side() {
        let picture = |width: u32, value: f32| Image {
            width,
            height: 2,
            pixels: vec![Rgb::WHITE * value; width as usize * 2],
        };
        let mut sheet = Sheet::new("figure");
        assert!(sheet.display().is_none());
        sheet.add("dark", picture(3, 0.0));
        sheet.add("bright", picture(2, 1.0));
        let (bytes, width, height) = sheet.display().expect("pictures");
        assert_eq!((width, height), (5 + GAP as u32, 2));
        let pixel = |x: usize, y: usize| bytes[(y * width as usize + x) * 3];
        for y in 0..2 {
            assert_eq!((pixel(2, y), pixel(3, y)), (0, 255));
            // The 95th percentile is shown at 0.8.
            assert_eq!(pixel(3 + GAP, y), 231);
        }
        assert_eq!(
            sheet.caption(),
            "figure.png, from left to right: dark; bright."
        );
    }
}
