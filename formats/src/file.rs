//! Files as bytes: bounded reading, whole-or-nothing writing, and what foreign bytes look like.

use crate::error::{FormatError, io_error};
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Largest text file that is read [B]: indices are 32 bits wide, more text than this cannot be addressed.
const LARGEST_TEXT: u64 = 8 << 30;

/// Opens a regular file; folders, pipes and devices are refused before they can block.
pub(crate) fn open(path: &Path) -> Result<(File, u64), FormatError> {
    let metadata = std::fs::metadata(path).map_err(io_error(path))?;
    if metadata.is_dir() {
        return Err(io_error(path)(ErrorKind::IsADirectory.into()));
    }
    if !metadata.is_file() {
        return Err(FormatError::content(
            path,
            "is a pipe or a device, expected a regular file",
        ));
    }
    let file = File::open(path).map_err(io_error(path))?;
    Ok((file, metadata.len()))
}

/// The first bytes of a regular file, at most `count`.
pub(crate) fn head(path: &Path, count: u64) -> Result<Vec<u8>, FormatError> {
    read_at_most(path, open(path)?.0, count)
}

fn read_at_most(path: &Path, file: File, limit: u64) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    file.take(limit)
        .read_to_end(&mut bytes)
        .map_err(io_error(path))?;
    Ok(bytes)
}

/// All bytes of a regular file of at most `limit` bytes.
pub(crate) fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, FormatError> {
    let (file, length) = open(path)?;
    if length > limit {
        return Err(FormatError::content(
            path,
            format!("has {length} bytes, expected at most {limit}"),
        ));
    }
    read_at_most(path, file, limit)
}

/// A text file: UTF-8 with or without byte order mark, or else Latin-1 (`true`).
pub(crate) fn read_text(path: &Path) -> Result<(String, bool), FormatError> {
    let mut bytes = read_bytes(path, LARGEST_TEXT)?;
    if bytes.starts_with(BYTE_ORDER_MARK) {
        bytes.drain(..BYTE_ORDER_MARK.len());
    }
    Ok(match String::from_utf8(bytes) {
        Ok(text) => (text, false),
        Err(error) => (
            error
                .as_bytes()
                .iter()
                .map(|&byte| char::from(byte))
                .collect(),
            true,
        ),
    })
}

const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";

/// True when a file with these first bytes holds no text at all (one byte is no scene either).
pub(crate) fn is_blank(head: &[u8]) -> bool {
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    text.len() <= 1 || text.iter().all(u8::is_ascii_whitespace)
}

/// First bytes of a `.sheen` file. Line ends in it are damaged by a transfer as text, which is then noticed.
pub(crate) const SHEEN_MAGIC: [u8; 8] = *b"\x89SHEEN\r\n";

/// What a file with these first bytes is, when it is something that is known and is not OBJ or MGF text.
pub(crate) fn looks_like(head: &[u8]) -> Option<&'static str> {
    const KNOWN: [(&[u8], &str); 22] = [
        (&SHEEN_MAGIC, "a .sheen solution"),
        (b"\x89PNG", "a PNG image"),
        (b"\xFF\xD8\xFF", "a JPEG image"),
        (b"\x76\x2F\x31\x01", "an OpenEXR image"),
        (b"#?RADIANCE", "a Radiance HDR image"),
        (b"#?RGBE", "a Radiance HDR image"),
        (b"GIF8", "a GIF image"),
        (b"glTF", "a binary glTF scene"),
        (b"ply\n", "a PLY mesh"),
        (b"ply\r", "a PLY mesh"),
        (b"solid ", "an STL mesh"),
        (b"Kaydara FBX", "an FBX scene"),
        (b"BLENDER", "a Blender file"),
        (b"<?xml", "an XML file"),
        (b"%PDF", "a PDF document"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1F\x8B", "a gzip archive"),
        (b"\x28\xB5\x2F\xFD", "a zstd archive"),
        (b"\x7FELF", "a program"),
        (b"\xFF\xFE", "UTF-16 text"),
        (b"\xFE\xFF", "UTF-16 text"),
        (b"IESNA", "an IES luminaire"),
    ];
    let text = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    if let Some((_, name)) = KNOWN.iter().find(|(magic, _)| text.starts_with(magic)) {
        return Some(name);
    }
    match text.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Some("JSON (perhaps a glTF scene)"),
        _ if text.contains(&0) => Some("binary data"),
        _ => None,
    }
}

/// Writes a file whole or not at all: to a temporary name in the same folder, synced, then renamed.
///
/// A symbolic link is followed. A device (`/dev/null`) is written to as it is, never replaced.
pub(crate) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), FormatError> {
    let fault = io_error(path);
    let target = match std::fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => return Err(fault(ErrorKind::IsADirectory.into())),
        Ok(metadata) if !metadata.is_file() => {
            let mut device = std::fs::OpenOptions::new()
                .write(true)
                .open(path)
                .map_err(&fault)?;
            return write(&mut device)
                .and_then(|()| device.flush())
                .map_err(fault);
        }
        Ok(_) => std::fs::canonicalize(path).map_err(&fault)?,
        Err(_) => path.to_owned(),
    };
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".sheen-").suffix(".tmp");
    #[cfg(unix)]
    {
        // What any other new file gets: the process's mask is taken off this.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut temporary = builder
        .tempfile_in(&folder)
        .map_err(|error| fault(bare(error)))?;
    let mut buffered = BufWriter::with_capacity(1 << 20, temporary.as_file_mut());
    write(&mut buffered)
        .and_then(|()| buffered.flush())
        .map_err(&fault)?;
    drop(buffered);
    temporary.as_file().sync_all().map_err(&fault)?;
    temporary
        .persist(&target)
        .map_err(|error| fault(error.error))?;
    // The rename is on disk once the folder is. Not every file system can sync a folder; the file is whole anyway.
    if let Ok(folder) = File::open(&folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// The operating system's reason, without the temporary name that `tempfile` adds to it.
fn bare(error: std::io::Error) -> std::io::Error {
    error.kind().into()
}
