//! Every shader is valid, used, and agrees with its mirrors; no graphics device is needed.
#![allow(clippy::unwrap_used, reason = "tests")]

use naga::valid::{Capabilities, ValidationFlags, Validator};
use sheen_viewer::gpu::layout::{FrameUniforms, GlossyVertex, ResolveUniforms, ShadedVertex};
use sheen_viewer::gpu::shaders::{ALL, Shader};
use std::collections::BTreeSet;
use std::mem::offset_of;
use std::path::Path;
use wgpu::naga;

fn parse(shader: &Shader) -> naga::Module {
    let source = shader.source();
    naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("{}: {}", shader.label, e.emit_to_string(&source)))
}

#[test]
fn shaders_are_valid() {
    let faults: Vec<String> = ALL
        .iter()
        .filter_map(|shader| {
            let source = shader.source();
            let module = match naga::front::wgsl::parse_str(&source) {
                Ok(module) => module,
                Err(error) => {
                    return Some(format!(
                        "{}: {}",
                        shader.label,
                        error.emit_to_string(&source)
                    ));
                }
            };
            assert!(
                !module.entry_points.is_empty(),
                "{}: no entry point",
                shader.label
            );
            let result =
                Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module);
            result
                .err()
                .map(|error| format!("{}: {}", shader.label, error.emit_to_string(&source)))
        })
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn every_file_is_used() {
    fn collect(folder: &Path, prefix: &str, names: &mut BTreeSet<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let entry = entry.unwrap();
            let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
            if entry.path().is_dir() {
                collect(&entry.path(), &format!("{name}/"), names);
            } else {
                names.insert(name);
            }
        }
    }
    let mut files = BTreeSet::new();
    collect(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"),
        "",
        &mut files,
    );
    let used: BTreeSet<String> = ALL
        .iter()
        .flat_map(|shader| shader.files)
        .map(|&file| file.to_owned())
        .collect();
    assert_eq!(files, used);
}

/// Members of the structure `name` with their offsets, and its size.
fn layout(shader: &str, name: &str) -> (Vec<(String, usize)>, usize) {
    let module = parse(ALL.iter().find(|s| s.label == shader).unwrap());
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap();
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        panic!("{name} is no structure")
    };
    (
        members
            .iter()
            .map(|m| (m.name.clone().unwrap(), m.offset as usize))
            .collect(),
        *span as usize,
    )
}

macro_rules! assert_mirrors {
    ($shader:literal, $name:literal, $ty:ty, $($field:ident),+) => {
        let expected = vec![$((stringify!($field).to_owned(), offset_of!($ty, $field))),+];
        assert_eq!(layout($shader, $name), (expected, size_of::<$ty>()));
    };
}

#[test]
fn structures_are_laid_out_as_their_mirrors() {
    for shader in ["evaluate", "mesh", "shade", "glass", "lines"] {
        let expected = layout("mesh", "Frame");
        assert_eq!(layout(shader, "Frame"), expected);
    }
    assert_mirrors!(
        "mesh",
        "Frame",
        FrameUniforms,
        clip_from_relative,
        eye,
        glossy_tint,
        line_radiance,
        padding
    );
    assert_mirrors!(
        "evaluate",
        "GlossyVertex",
        GlossyVertex,
        position,
        offset,
        radiance,
        vertex
    );
    assert_mirrors!(
        "shade",
        "ShadedVertex",
        ShadedVertex,
        normal,
        offset,
        radiance,
        padding
    );
    assert_mirrors!(
        "resolve",
        "Resolve",
        ResolveUniforms,
        samples,
        has_glass,
        exposure,
        padding
    );
}
