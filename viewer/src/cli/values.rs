//! Values as typed.

use glam::Vec3;

/// `x,y,z`.
pub(super) fn vector(text: &str) -> Result<Vec3, String> {
    let expected = || format!("'{text}' is not three numbers as in 1,2.5,-3");
    let parts: Vec<f32> = text
        .split(',')
        .map(|part| {
            part.trim()
                .parse::<f32>()
                .ok()
                .filter(|value| value.is_finite())
        })
        .collect::<Option<_>>()
        .ok_or_else(expected)?;
    match parts[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(expected()),
    }
}

/// `WIDTHxHEIGHT`.
pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .filter(|&(width, height)| (1..=16384).contains(&width) && (1..=16384).contains(&height))
        .ok_or_else(|| format!("'{text}' is not a size as in 640x480, each within 1..16384"))
}

/// Seconds, from `90`, `90s`, `1.5m` or `1h`.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.char_indices().next_back() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    number
        .parse::<f64>()
        .ok()
        .map(|value| value * factor)
        .filter(|value| value.is_finite() && *value > 0.0)
        .ok_or_else(|| format!("'{text}' is not a time above zero as in 60s, 1.5m or 1h"))
}

/// Bytes, from `1000000`, `512MiB`, `2GiB` or `2GB`.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    text.parse::<bytesize::ByteSize>()
        .ok()
        .map(|size| size.as_u64())
        .filter(|&bytes| bytes > 0)
        .ok_or_else(|| format!("'{text}' is not a size above zero as in 512MiB or 2GB"))
}

/// A finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|value| value.is_finite() && *value > 0.0)
        .ok_or_else(|| format!("'{text}' is not a number above zero"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_or_explained() {
        assert_eq!(vector("1, 2.5,-3"), Ok(Vec3::new(1.0, 2.5, -3.0)));
        assert!(vector("1,2").is_err() && vector("1,2,nan").is_err() && vector("").is_err());
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert!(size("0x4").is_err() && size("99999x1").is_err() && size("640").is_err());
        assert_eq!(bytes("4GB"), Ok(4_000_000_000));
        assert_eq!(bytes("4GiB"), Ok(4 << 30));
        assert_eq!(bytes("1.5 KiB"), Ok(1536));
        for text in ["0", "-1", "1.5", "GiB", "4 parsecs", "", "nan"] {
            assert!(bytes(text).is_err(), "{text}");
        }
        assert_eq!(seconds("1.5m"), Ok(90.0));
        assert_eq!(seconds("60s"), Ok(60.0));
        assert!(
            seconds("-1").is_err()
                && seconds("s").is_err()
                && seconds("").is_err()
                && seconds("é").is_err()
        );
    }
}
