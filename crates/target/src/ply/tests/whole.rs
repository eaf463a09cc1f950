//! Whole files: points in, everything else kept.

use super::*;
use crate::{Target, ply::body::BLOCK};
use ply_rs_bw::ply::Property;

#[test]
fn points_are_the_vertices_in_every_encoding() {
    for encoding in ENCODINGS {
        let target = PointsTarget::from_bytes(rich(encoding)).unwrap();
        assert_eq!((target.vertex_count(), target.skipped()), (3, None), "{encoding}");
        assert_eq!(target.points().len(), 3);
        for (i, p) in (0..).zip(target.points()) {
            let f = i as f32;
            assert_eq!(p.position, Vec3::new((0.1 + f64::from(f)) as f32, f, -f), "{encoding}");
            assert_eq!((p.geometric_normal, p.shading_normal), (Vec3::NEG_Z, Vec3::NEG_Z));
            assert_eq!((p.id, p.footprint), (i, 0.0));
            assert!(p.is_valid());
        }
    }
}

#[test]
fn everything_else_survives_in_every_encoding() {
    for encoding in ENCODINGS {
        // The other library reads no NaN from text.
        let last = if encoding == "ascii" { estimate(1.0) } else { Estimate::PENDING };
        let estimates = [estimate(0.5), estimate(0.1), last];
        let before = rich(encoding);
        let after = written(&PointsTarget::from_bytes(before.clone()).unwrap(), &estimates);
        let (mut old, new) = (oracle(&before), oracle(&after));
        assert_eq!(new.header.encoding, old.header.encoding, "{encoding}");
        assert_eq!(new.header.comments, old.header.comments);
        assert_eq!(new.header.obj_infos, old.header.obj_infos);
        let names: Vec<&str> = new.header.elements["vertex"].properties.keys().map(String::as_str).collect();
        let kept = ["red", "x", "y", "z", "weights", "nx", "ny", "nz"];
        assert_eq!(names, [&kept[..], &["visibility", "error", "rays"]].concat());
        for (i, (vertex, e)) in new.payload["vertex"].iter().zip(&estimates).enumerate() {
            for name in kept {
                assert_eq!(vertex[name], old.payload["vertex"][i][name], "{encoding}: {name}");
            }
            for (name, truth) in [("visibility", e.visibility), ("error", e.error), ("rays", e.rays as f32)] {
                let Property::Float(found) = vertex[name] else { panic!("{name} is no float") };
                assert!(found == truth || (found.is_nan() && truth.is_nan()), "{encoding}: {name} {found}");
            }
        }
        for payload in ["range", "face"] {
            assert_eq!(new.payload[payload], old.payload[payload], "{encoding}: {payload}");
        }
        // A negative control: the comparison sees a single changed value.
        old.payload["face"][1].insert("flag".into(), Property::UChar(9));
        assert_ne!(new.payload["face"], old.payload["face"]);
    }
}

#[test]
fn writing_twice_changes_nothing_more() {
    let estimates = [estimate(0.5), estimate(0.1), estimate(1.0)];
    for encoding in ENCODINGS {
        let once = written(&PointsTarget::from_bytes(rich(encoding)).unwrap(), &estimates);
        let again = PointsTarget::from_bytes(once.clone()).unwrap();
        assert_eq!(written(&again, &estimates), once, "{encoding}");
        let other = written(&again, &[estimate(0.2); 3]);
        assert_ne!(other, once);
        assert_eq!(oracle(&other).payload["face"], oracle(&once).payload["face"]);
    }
}

#[test]
fn carriage_returns_blank_lines_and_missing_last_line_ends_are_kept() {
    let text = "ply\r\nformat ascii 1.0\r\nelement vertex 2\r\nproperty float x\r\nproperty float y\r\n\
        property float z\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\nend_header\r\n\
        1 2 3  0 0 1 \r\n\r\n4 5 6 0\t1 0";
    let target = PointsTarget::from_bytes(text.into()).unwrap();
    assert_eq!(target.points()[1].position, Vec3::new(4.0, 5.0, 6.0));
    let out = String::from_utf8(written(&target, &[estimate(0.5), Estimate::PENDING])).unwrap();
    let new = "property float visibility\r\nproperty float error\r\nproperty float rays\r\nend_header\r\n\
        1 2 3 0 0 1 0.5 0.0625 64 \r\n\r\n4 5 6 0 1 0 nan inf 0";
    assert!(out.ends_with(new), "{out:?}");
}

#[test]
fn many_blocks_keep_their_order() {
    // More than two blocks, with a list in the vertices so that binary records differ in size too.
    let n = 2 * BLOCK as usize + 77;
    let header = format!(
        "element vertex {n}\n{}property list uchar uchar tags\n",
        ["x", "y", "z", "nx", "ny", "nz"].map(|n| format!("property float {n}\n")).concat()
    );
    let records: Vec<Vec<Value>> = (0..n)
        .map(|i| {
            let point = [i as f32, 0.0, 0.0, 0.0, 0.0, 1.0].map(Float);
            let tags = vec![Byte(1); i % 3];
            [&point[..], &[Byte(tags.len() as u8)], &tags].concat()
        })
        .collect();
    for encoding in ENCODINGS {
        let target = PointsTarget::from_bytes(file(encoding, &header, &records)).unwrap();
        assert_eq!(target.points().len(), n);
        assert!((0..).zip(target.points()).all(|(i, p)| p.id == i && p.position.x == i as f32));
        let estimates: Vec<_> = (0..n).map(|i| estimate(i as f32)).collect();
        let back = oracle(&written(&target, &estimates));
        for (i, vertex) in back.payload["vertex"].iter().enumerate() {
            assert_eq!(
                (&vertex["x"], &vertex["visibility"]),
                (&Property::Float(i as f32), &Property::Float(i as f32))
            );
        }
    }
}
