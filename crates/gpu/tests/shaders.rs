//! The shaders as naga sees them: valid, and their structs as ours are. No adapter is needed.

use conray_gpu::{entry_points, source};
use naga::{
    Module, TypeInner,
    valid::{Capabilities, ValidationFlags, Validator},
};

fn parsed(name: &str) -> Module {
    let text = source(name);
    naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(&text)))
}

#[test]
fn every_shader_is_valid_for_plain_webgpu() {
    assert!(entry_points().count() > 10);
    for name in entry_points() {
        let module = parsed(name);
        assert_eq!(module.entry_points.len(), 1, "{name}: one entry point a file");
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        if let Err(e) = validator.validate(&module) {
            panic!("{name}: {}", e.emit_to_string(&source(name)));
        }
    }
}

#[test]
fn what_is_no_shader_is_refused() {
    let broken = source("rays.wgsl").replace("more.rays += 1u", "more.rays += 1.5");
    let module = naga::front::wgsl::parse_str(&broken);
    let is_valid = |module: &Module| {
        Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(module).is_ok()
    };
    assert!(!module.is_ok_and(|module| is_valid(&module)));
}

/// Names, offsets and the size of a struct of a shader.
fn layout([file, name]: [&str; 2]) -> (Vec<(String, u32)>, u32) {
    let module = parsed(file);
    let (_, found) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
    let members = members.iter().map(|member| (member.name.clone().unwrap(), member.offset));
    (members.collect(), *span)
}

#[test]
fn structs_have_their_twins_layout() {
    for (name, members, size) in conray_gpu::layouts() {
        let (found, span) = layout(name);
        assert_eq!(
            found,
            members.iter().map(|(name, at)| (name.to_string(), *at as u32)).collect::<Vec<_>>()
        );
        assert_eq!(span as usize, size, "{name:?}");
    }
}
