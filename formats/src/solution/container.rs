//! The container of `.sheen`: a table of chunks with a checksum each.
//!
//! All numbers are little endian. Every byte of a file is covered: by the checksum of the head, by the checksum of
//! its chunk, or by the rule that padding is zero.
//!
//! | bytes | content |
//! |---|---|
//! | 0..8 | `\x89SHEEN\r\n` |
//! | 8..12 | version |
//! | 12..16 | number of chunks |
//! | 16..24 | length of the file |
//! | 24..28 | CRC-32 of the head and the table, with these four bytes zero |
//! | 28..32 | zero |
//! | 32 × (1 + i) | entry i of the table: tag (4 letters), CRC-32, offset (8 bytes), length (8 bytes), 8 zero bytes |
//! | from the offsets on | the chunks in the order of the table; each starts at a multiple of 16 |

use crate::file::SHEEN_MAGIC;
use std::io::Write;

/// Version that is written, and the only one that is read.
pub(super) const VERSION: u32 = 3;
/// Bytes of the head, and of one entry of the table.
const RECORD: usize = 32;
const ALIGNMENT: usize = 16;
/// More chunks than any version has.
const MOST_CHUNKS: u32 = 64;
/// Where the checksum of the head stands.
const HEAD_CHECKSUM: std::ops::Range<usize> = 24..28;

/// Name of a chunk.
pub(super) type Tag = [u8; 4];

/// Writes the chunks, in the order given.
pub(super) fn write(writer: &mut dyn Write, chunks: &[(Tag, &[u8])]) -> std::io::Result<()> {
    let mut table = Vec::with_capacity(chunks.len() * RECORD);
    let mut end = RECORD * (1 + chunks.len());
    for (tag, bytes) in chunks {
        let offset = end.next_multiple_of(ALIGNMENT);
        end = offset + bytes.len();
        table.extend_from_slice(tag);
        table.extend_from_slice(&crc32fast::hash(bytes).to_le_bytes());
        table.extend_from_slice(&(offset as u64).to_le_bytes());
        table.extend_from_slice(&(bytes.len() as u64).to_le_bytes());
        table.extend_from_slice(&[0; 8]);
    }
    let mut head = Vec::with_capacity(RECORD);
    head.extend_from_slice(&SHEEN_MAGIC);
    head.extend_from_slice(&VERSION.to_le_bytes());
    head.extend_from_slice(&(chunks.len() as u32).to_le_bytes());
    head.extend_from_slice(&(end as u64).to_le_bytes());
    head.extend_from_slice(&[0; 8]);
    let checksum = head_checksum(&head, &table);
    head[HEAD_CHECKSUM].copy_from_slice(&checksum.to_le_bytes());
    writer.write_all(&head)?;
    writer.write_all(&table)?;
    // The table is a multiple of the alignment long: only chunks need padding, before the next one.
    for (index, (_, bytes)) in chunks.iter().enumerate() {
        writer.write_all(bytes)?;
        if index + 1 < chunks.len() {
            let padding = bytes.len().next_multiple_of(ALIGNMENT) - bytes.len();
            writer.write_all(&[0; ALIGNMENT][..padding])?;
        }
    }
    Ok(())
}

/// CRC-32 over head and table as if the checksum in the head were zero.
fn head_checksum(head: &[u8], table: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&head[..HEAD_CHECKSUM.start]);
    hasher.update(&[0; 4]);
    hasher.update(&head[HEAD_CHECKSUM.end..]);
    hasher.update(table);
    hasher.finalize()
}

/// One chunk of a file.
pub(super) struct Chunk<'a> {
    pub tag: Tag,
    pub bytes: &'a [u8],
    checksum: u32,
}

impl Chunk<'_> {
    pub(super) fn check(&self) -> Result<(), String> {
        if crc32fast::hash(self.bytes) == self.checksum {
            return Ok(());
        }
        Err(format!(
            "is damaged: the checksum of chunk {} does not match",
            self.tag.escape_ascii()
        ))
    }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}

/// The chunks of a file; head, table and padding are checked, the chunks' own checksums are not.
pub(super) fn read(file: &[u8]) -> Result<Vec<Chunk<'_>>, String> {
    if !file.starts_with(&SHEEN_MAGIC) {
        return Err(match crate::file::looks_like(&file[..file.len().min(16)]) {
            _ if file.is_empty() => "is empty, expected a .sheen solution".to_owned(),
            Some(kind) => format!("looks like {kind}, expected a .sheen solution"),
            None => "is no .sheen solution: its first bytes differ".to_owned(),
        });
    }
    let truncated = |expected: u64| format!("is truncated: {} bytes of {expected}", file.len());
    if file.len() < RECORD {
        return Err(truncated(RECORD as u64));
    }
    let (head, rest) = file.split_at(RECORD);
    let (version, count, length) = (u32_at(head, 8), u32_at(head, 12), u64_at(head, 16));
    if version != VERSION {
        return Err(format!(
            "is of version {version}, this program reads version {VERSION}: solve the scene again"
        ));
    }
    if count > MOST_CHUNKS {
        return Err(format!(
            "is damaged: {count} chunks, expected at most {MOST_CHUNKS}"
        ));
    }
    let table_length = count as usize * RECORD;
    if rest.len() < table_length {
        return Err(truncated(length.max((RECORD + table_length) as u64)));
    }
    let table = &rest[..table_length];
    if head_checksum(head, table) != u32_at(head, HEAD_CHECKSUM.start) {
        return Err("is damaged: the checksum of its head does not match".to_owned());
    }
    if (file.len() as u64) < length {
        return Err(truncated(length));
    }
    if file.len() as u64 > length {
        return Err(format!(
            "has {} bytes after its end at {length}",
            file.len() as u64 - length
        ));
    }
    let mut end = (RECORD + table_length) as u64;
    let mut chunks = Vec::with_capacity(count as usize);
    for entry in table.chunks_exact(RECORD) {
        let tag = [entry[0], entry[1], entry[2], entry[3]];
        let (offset, bytes) = (u64_at(entry, 8), u64_at(entry, 16));
        let chunk_end = offset
            .checked_add(bytes)
            .filter(|&chunk_end| chunk_end <= length);
        let (true, Some(chunk_end)) = (offset == end.next_multiple_of(ALIGNMENT as u64), chunk_end)
        else {
            return Err(format!(
                "is damaged: chunk {} does not lie where it should",
                tag.escape_ascii()
            ));
        };
        // Both ends are within the file, whose length is a usize.
        let range = |from: u64, to: u64| &file[from as usize..to as usize];
        if range(end, offset).iter().any(|&byte| byte != 0) {
            return Err(format!(
                "is damaged: bytes between chunks, before {}",
                tag.escape_ascii()
            ));
        }
        chunks.push(Chunk {
            tag,
            bytes: range(offset, chunk_end),
            checksum: u32_at(entry, 4),
        });
        end = chunk_end;
    }
    if end != length {
        return Err(format!("has {} bytes after its last chunk", length - end));
    }
    Ok(chunks)
}
