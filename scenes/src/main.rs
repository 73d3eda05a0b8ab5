//! Writes the scenes: `generate-scenes [FOLDER]`, FOLDER being `scenes` unless given.

use std::io::{self, Write};
use std::path::Path;
use std::{env, fs};

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).unwrap_or_else(|| "scenes".into());
    let mut out = io::stdout().lock();
    for scene in sheen_scenes::all() {
        let folder = Path::new(&folder).join(scene.name);
        fs::create_dir_all(&folder)?;
        for (file, text) in &scene.files {
            let path = folder.join(file);
            fs::write(&path, text)?;
            writeln!(out, "{} ({} bytes)", path.display(), text.len())?;
        }
    }
    Ok(())
}
