//! Images in and out: OpenEXR with linear radiance, PNG for the display. Files are written whole or not at all.

use crate::error::FormatError;
use crate::file;
use ::image::ImageEncoder;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, ReadChannels, ReadLayers, Vec2, WritableImage,
};
use sheen_solver::Rgb;
use std::io::Cursor;
use std::path::Path;

/// Largest image that is read or written, pixels a side.
pub const LARGEST_SIDE: u32 = 16384;
/// Largest image file that is read [B].
const LARGEST_FILE: u64 = 4 << 30;

/// Linear radiance [W·sr⁻¹·m⁻²] per pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Row by row, top left first.
    pub pixels: Vec<Rgb>,
}

fn check_size(
    path: &Path,
    width: usize,
    height: usize,
    pixels: Option<usize>,
) -> Result<(), FormatError> {
    let side = 1..=LARGEST_SIDE as usize;
    if !(side.contains(&width) && side.contains(&height)) {
        let message = format!("has {width} x {height} pixels, expected 1..{LARGEST_SIDE} a side");
        return Err(FormatError::content(path, message));
    }
    match pixels {
        Some(count) if count != width * height => Err(FormatError::content(
            path,
            format!("{count} pixels given, expected {width} x {height}"),
        )),
        _ => Ok(()),
    }
}

/// Writes `image` as OpenEXR: channels R, G, B in 32-bit floats, scan lines, ZIP.
///
/// Errors: a size that does not match the pixels or is over [`LARGEST_SIDE`]; a pixel that is not finite; what the
/// operating system refuses.
pub fn write_exr(path: &Path, image: &Image) -> Result<(), FormatError> {
    write_exr_with(path, image, None)
}

/// The same with the variance of each pixel as a second part, `variance`, if it is given: of the same size as the
/// image. Programs that know one part read the image.
pub fn write_exr_with(
    path: &Path,
    image: &Image,
    variance: Option<&Image>,
) -> Result<(), FormatError> {
    let (width, height) = (image.width as usize, image.height as usize);
    let mut layers = Vec::new();
    for (name, part) in [("radiance", Some(image)), ("variance", variance)] {
        let Some(part) = part else { continue };
        check_size(path, width, height, Some(part.pixels.len()))?;
        check_finite(path, &part.pixels)?;
        layers.push(Layer::new(
            (width, height),
            LayerAttributes::named(name),
            Encoding {
                compression: exr::compression::Compression::ZIP16,
                blocks: exr::image::Blocks::ScanLines,
                line_order: exr::meta::attribute::LineOrder::Increasing,
            },
            channels(&part.pixels),
        ));
    }
    let bounds = IntegerBounds::from_dimensions((width, height));
    let parts = exr::image::Image::from_layers(ImageAttributes::new(bounds), layers);
    let mut bytes = Cursor::new(Vec::new());
    parts
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|error| {
            FormatError::content(path, format!("the image could not be encoded: {error}"))
        })?;
    file::write_whole(path, |writer| writer.write_all(bytes.get_ref()))
}

fn channels(pixels: &[Rgb]) -> AnyChannels<FlatSamples> {
    let channel = |(index, name): (usize, &str)| {
        let samples = pixels.iter().map(|pixel| pixel.to_array()[index]).collect();
        AnyChannel::new(name, FlatSamples::F32(samples))
    };
    let names = ["R", "G", "B"].into_iter().enumerate();
    AnyChannels::sort(names.map(channel).collect())
}

fn check_finite(path: &Path, pixels: &[Rgb]) -> Result<(), FormatError> {
    let bad = pixels.iter().filter(|pixel| !pixel.is_finite()).count();
    if bad == 0 {
        return Ok(());
    }
    Err(FormatError::content(
        path,
        format!("{bad} of {} pixels are NaN or infinite", pixels.len()),
    ))
}

/// Reads the first part of an OpenEXR image, with channels R, G, B (others are ignored) in half or single precision.
///
/// Errors: no OpenEXR, damaged, deep, a missing channel, larger than [`LARGEST_SIDE`], an image
/// that does not fill its display window, pixels that are not finite.
pub fn read_exr(path: &Path) -> Result<Image, FormatError> {
    let bytes = file::read_bytes(path, LARGEST_FILE)?;
    if !bytes.starts_with(b"\x76\x2F\x31\x01") {
        let kind = file::looks_like(&bytes[..bytes.len().min(16)]).unwrap_or("something else");
        let message = if bytes.is_empty() {
            "is empty, expected an OpenEXR image".to_owned()
        } else {
            format!("looks like {kind}, expected an OpenEXR image")
        };
        return Err(FormatError::content(path, message));
    }
    // The decoder is fed by strangers: should it panic, that is one more way of being damaged.
    let decoded = std::panic::catch_unwind(|| decode(path, &bytes));
    decoded.unwrap_or_else(|_| {
        Err(FormatError::content(
            path,
            "is damaged: the OpenEXR decoder gave up",
        ))
    })
}

fn decode(path: &Path, bytes: &[u8]) -> Result<Image, FormatError> {
    let fault = |error: exr::error::Error| {
        FormatError::content(path, format!("is no readable OpenEXR image: {error}"))
    };
    // Sizes and channels are checked before anything is allocated for them.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
    let Some(header) = meta.headers.first() else {
        return Err(FormatError::content(path, "has no part, expected an image"));
    };
    if header.deep {
        return Err(FormatError::content(
            path,
            "holds deep data, expected a flat image",
        ));
    }
    let Vec2(width, height) = header.layer_size;
    check_size(path, width, height, None)?;
    let display = header.shared_attributes.display_window;
    if display.size != header.layer_size || display.position != header.own_attributes.layer_position
    {
        let message = format!(
            "its {width} x {height} pixels do not fill its display window of {} x {}",
            display.size.x(),
            display.size.y()
        );
        return Err(FormatError::content(path, message));
    }
    for name in ["R", "G", "B"] {
        if !header
            .channels
            .list
            .iter()
            .any(|channel| channel.name.eq(name))
        {
            let found: Vec<String> = header
                .channels
                .list
                .iter()
                .map(|channel| channel.name.to_string())
                .collect();
            let message = format!(
                "has no channel {name}, expected R, G, B (it has {})",
                found.join(", ")
            );
            return Err(FormatError::content(path, message));
        }
    }
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![Rgb::BLACK; size.area()]),
            |(width, pixels): &mut (usize, Vec<Rgb>), at, (r, g, b): (f32, f32, f32)| {
                pixels[at.y() * *width + at.x()] = Rgb::new(r, g, b);
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(fault)?;
    let (_, pixels) = image.layer_data.channel_data.pixels;
    check_size(path, width, height, Some(pixels.len()))?;
    check_finite(path, &pixels)?;
    Ok(Image {
        width: width as u32,
        height: height as u32,
        pixels,
    })
}

/// Writes a PNG of 8 bits a channel. `rgb`: display values (sRGB), three bytes a pixel, row by row, top left first.
///
/// Errors: a size that does not match the bytes or is over [`LARGEST_SIDE`]; what the operating system refuses.
pub fn write_png(path: &Path, rgb: &[u8], width: u32, height: u32) -> Result<(), FormatError> {
    check_size(path, width as usize, height as usize, None)?;
    if rgb.len() != width as usize * height as usize * 3 {
        let message = format!("{} bytes given, expected {width} x {height} x 3", rgb.len());
        return Err(FormatError::content(path, message));
    }
    let mut bytes = Vec::new();
    ::image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(rgb, width, height, ::image::ExtendedColorType::Rgb8)
        .map_err(|error| {
            FormatError::content(path, format!("the image could not be encoded: {error}"))
        })?;
    file::write_whole(path, |writer| writer.write_all(&bytes))
}
