//! A fingerprint changes with all that changes the truth, and with nothing else.

use super::*;
use crate::testing::{case_of, test_case};
use conray::{
    Affine2, Affine3A, Alpha, AlphaTexture, AoSettings, Distance, Falloff, Geometry, Material, Method,
    Opacity, Sampling, TextureOpacity, TriangleMesh, Vec2, Vec3, View, Wrap,
};
use std::{collections::HashMap, sync::Arc};

type Describe = fn(&mut Feed);

#[test]
fn values_do_not_run_together() {
    let feeds: [(&str, Describe); 12] = [
        ("nothing", |_| {}),
        ("0 u32", |f| f.u32(0)),
        ("0 u64", |f| f.u64(0)),
        ("0 f32", |f| f.f32(0.0)),
        ("-0 f32", |f| f.f32(-0.0)),
        ("0 f64", |f| f.f64(0.0)),
        ("no text", |f| f.text("")),
        ("ab, c", |f| ["ab", "c"].iter().for_each(|t| f.text(t))),
        ("a, bc", |f| ["a", "bc"].iter().for_each(|t| f.text(t))),
        ("length 0", |f| f.length(0)),
        ("vector", |f| f.vector(Vec3::ZERO)),
        ("two", |f| (0..2).for_each(|_| f.f32(0.0))),
    ];
    let mut seen = HashMap::new();
    for (name, feed) in feeds {
        assert_eq!(Fingerprint::of(feed), Fingerprint::of(feed), "{name}");
        if let Some(other) = seen.insert(Fingerprint::of(feed), name) {
            panic!("{name} equals {other}");
        }
    }
}

/// A triangle with a textured opacity, as a case; each member changes one thing.
#[derive(Clone)]
struct Parts {
    corner: Vec3,
    moved: Vec3,
    texel: u8,
    uv: Vec2,
    wrap: Wrap,
    cutoff: Option<f32>,
    name: &'static str,
    eye: Vec3,
    settings: AoSettings,
}

impl Parts {
    fn plain() -> Self {
        Self {
            corner: Vec3::Y,
            moved: Vec3::ZERO,
            texel: 200,
            uv: Vec2::ZERO,
            wrap: Wrap::Repeat,
            cutoff: None,
            name: "leaf",
            eye: Vec3::new(0.3, 0.3, 2.0),
            settings: AoSettings { voxels: 16, distance: Distance::World(1.0), ..AoSettings::default() },
        }
    }

    fn fingerprint(&self) -> Fingerprint {
        let mut geometry = Geometry::default();
        let opacity = Opacity::Texture(TextureOpacity {
            texture: Arc::new(AlphaTexture::new(2, 1, vec![255, self.texel]).unwrap()),
            uv_set: 0,
            texture_from_uv: Affine2::IDENTITY,
            wrap: [self.wrap; 2],
            factor: 1.0,
            cutoff: self.cutoff,
        });
        geometry.add_material(Material { opacity, name: self.name.into(), ..Material::default() });
        let mesh = TriangleMesh::new(vec![Vec3::ZERO, Vec3::X, self.corner], vec![[0, 1, 2]]).unwrap();
        let mesh = mesh.with_uv_set(vec![self.uv, Vec2::X, Vec2::Y]).unwrap().with_name(self.name);
        let mesh = geometry.add_mesh(mesh).unwrap();
        geometry.add_instance(mesh, Affine3A::from_translation(self.moved)).unwrap();
        let (look_at, up) = (Vec3::new(0.3, 0.3, 0.0), Vec3::Y);
        let view = View { name: self.name.into(), eye: self.eye, look_at, up, vertical_fov_deg: 40.0 };
        let case = case_of(geometry, view, 4, self.settings.clone());
        assert!(!case.points().is_empty());
        fingerprint_of_case(&case).unwrap()
    }
}

#[test]
fn all_that_changes_the_truth_changes_it() {
    let plain = Parts::plain;
    let with = |settings: AoSettings| Parts { settings, ..plain() };
    let settings = || plain().settings;
    let changed = [
        ("nothing", plain()),
        ("geometry", Parts { corner: Vec3::new(0.0, 1.0, 0.001), ..plain() }),
        ("placement", Parts { moved: Vec3::new(0.0, 0.0, 0.001), ..plain() }),
        ("texel", Parts { texel: 201, ..plain() }),
        ("UV", Parts { uv: Vec2::new(0.001, 0.0), ..plain() }),
        ("wrap", Parts { wrap: Wrap::Clamp, ..plain() }),
        ("cutoff", Parts { cutoff: Some(0.5), ..plain() }),
        ("points", Parts { eye: Vec3::new(0.3, 0.3, 2.001), ..plain() }),
        ("distance", with(AoSettings { distance: Distance::World(1.001), ..settings() })),
        ("falloff", with(AoSettings { falloff: Falloff::Linear, ..settings() })),
        ("alpha", with(AoSettings { alpha: Alpha::Opaque, ..settings() })),
        ("seed", with(AoSettings { seed: 1, ..settings() })),
    ];
    let mut seen = HashMap::new();
    for (name, parts) in changed {
        if let Some(other) = seen.insert(parts.fingerprint(), name) {
            panic!("{name} equals {other}");
        }
    }
}

#[test]
fn what_leaves_the_truth_alone_leaves_it_alone() {
    let plain = Parts::plain().fingerprint();
    assert_eq!(Parts { name: "flower", ..Parts::plain() }.fingerprint(), plain);
    let settings = AoSettings {
        method: Method::Paper,
        rays: Some(5),
        sampling: Sampling::Random,
        voxels: 32,
        cones: 9,
        ..Parts::plain().settings
    };
    assert_eq!(Parts { settings, ..Parts::plain() }.fingerprint(), plain);
}

#[test]
fn a_case_made_again_keeps_its_fingerprint() {
    let case = test_case(3);
    assert_eq!(fingerprint_of_case(&case).unwrap(), fingerprint_of_case(&test_case(3)).unwrap());
    assert_ne!(fingerprint_of_case(&case).unwrap(), fingerprint_of_case(&test_case(4)).unwrap());
}
