//! Files made by hand in all encodings; what we write is read back by ply-rs-bw, which did not write it.

mod broken;
mod whole;

use super::PointsTarget;
use conray_core::{Estimate, Vec3};
use ply_rs_bw::{
    parser::Parser,
    ply::{DefaultElement, Ply},
};
use std::fs;

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// A value with the type that the header gives it.
#[derive(Clone, Copy)]
enum Value {
    Byte(u8),
    Int(i32),
    Float(f32),
    Double(f64),
}
use Value::{Byte, Double, Float, Int};

/// Header lines after the format line, and the records: a minimal writer of our own for all encodings.
fn file(encoding: &str, header: &str, records: &[Vec<Value>]) -> Vec<u8> {
    let mut bytes = format!("ply\nformat {encoding} 1.0\n{header}end_header\n").into_bytes();
    for record in records {
        match encoding {
            "ascii" => {
                let text = |v: &Value| match v {
                    Byte(v) => v.to_string(),
                    Int(v) => v.to_string(),
                    Float(v) => v.to_string(),
                    Double(v) => v.to_string(),
                };
                bytes.extend(record.iter().map(text).collect::<Vec<_>>().join(" ").as_bytes());
                bytes.push(b'\n');
            }
            _ => {
                for value in record {
                    let mut le = match value {
                        Byte(v) => v.to_le_bytes().to_vec(),
                        Int(v) => v.to_le_bytes().to_vec(),
                        Float(v) => v.to_le_bytes().to_vec(),
                        Double(v) => v.to_le_bytes().to_vec(),
                    };
                    if encoding == "binary_big_endian" {
                        le.reverse();
                    }
                    bytes.extend(le);
                }
            }
        }
    }
    bytes
}

/// Three vertices among everything that other programs may write: an element before them, colours, doubles, a list in
/// the vertices, an older visibility, faces behind them.
const RICH: &str = "comment made by hand, \u{e9}\nobj_info kept\nelement range 2\nproperty list uchar int nodes\n\
    property float gain\nelement vertex 3\nproperty uchar red\nproperty double x\nproperty float y\n\
    property float visibility\nproperty float32 z\nproperty list uchar float weights\nproperty float nx\n\
    property double ny\nproperty int nz\nelement face 2\nproperty list uchar int vertex_indices\nproperty uchar flag\n";

fn rich(encoding: &str) -> Vec<u8> {
    let weights = [vec![Byte(0)], vec![Byte(2), Float(0.25), Float(0.75)], vec![Byte(1), Float(1.0)]];
    let mut records = vec![vec![Byte(2), Int(7), Int(-8), Float(1.5)], vec![Byte(0), Float(2.5)]];
    for (i, weights) in weights.into_iter().enumerate() {
        let f = i as f32;
        let mut vertex =
            vec![Byte(200 + i as u8), Double(0.1 + f64::from(f)), Float(f), Float(9.0), Float(-f)];
        vertex.extend(weights);
        vertex.extend([Float(0.0), Double(0.0), Int(-2 - i as i32)]);
        records.push(vertex);
    }
    records.extend([
        vec![Byte(3), Int(0), Int(1), Int(2), Byte(1)],
        vec![Byte(4), Int(0), Int(1), Int(2), Int(0), Byte(2)],
    ]);
    file(encoding, RICH, &records)
}

fn simple(encoding: &str, vertices: &[[f32; 6]]) -> Vec<u8> {
    let header = format!(
        "element vertex {}\n{}",
        vertices.len(),
        ["x", "y", "z", "nx", "ny", "nz"].map(|n| format!("property float {n}\n")).concat()
    );
    let records: Vec<Vec<Value>> = vertices.iter().map(|v| v.map(Float).to_vec()).collect();
    file(encoding, &header, &records)
}

fn estimate(visibility: f32) -> Estimate {
    Estimate { visibility, error: visibility / 8.0, rays: 64, bent: Vec3::ZERO, cone: None }
}

fn written(target: &PointsTarget, estimates: &[Estimate]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.ply");
    target.write(&path, estimates).unwrap();
    fs::read(&path).unwrap()
}

fn oracle(bytes: &[u8]) -> Ply<DefaultElement> {
    Parser::<DefaultElement>::new().read_ply(&mut &bytes[..]).unwrap()
}
