//! Buffer views compressed by `EXT_meshopt_compression`.

use super::schema::Meshopt;
use bytemuck::{Pod, cast_slice};
use meshopt::{decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat};

/// No byte of the codec stands for more than this many decoded ones: blocks of 256 vertices with 2 bits for each
/// channel of four bytes.
const MAX_RATIO: usize = 1024;

/// Decodes a view to `count * byte_stride` bytes.
pub(super) fn decode(view: &Meshopt, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let (count, stride) = (view.count, view.byte_stride);
    if count.checked_mul(stride).is_none_or(|size| size / MAX_RATIO > bytes.len()) {
        return Err(format!("{} compressed bytes are too few for {count} elements", bytes.len()));
    }
    let failed = |_| "its compressed data is broken".to_string();
    if count == 0 {
        return Ok(Vec::new());
    }
    let mut out = match (view.mode.as_str(), stride) {
        ("ATTRIBUTES", 4..=256) if stride % 4 == 0 => {
            decode_vertices(bytes, count, stride).map_err(failed)?
        }
        ("TRIANGLES", 2 | 4) if !count.is_multiple_of(3) => {
            return Err(format!("{count} indices make no triangles"));
        }
        ("TRIANGLES", 2) => {
            cast_slice(&meshopt::decode_index_buffer::<u16>(bytes, count).map_err(failed)?).to_vec()
        }
        ("TRIANGLES", 4) => {
            cast_slice(&meshopt::decode_index_buffer::<u32>(bytes, count).map_err(failed)?).to_vec()
        }
        ("INDICES", 2) => {
            cast_slice(&meshopt::decode_index_sequence::<u16>(bytes, count).map_err(failed)?).to_vec()
        }
        ("INDICES", 4) => {
            cast_slice(&meshopt::decode_index_sequence::<u32>(bytes, count).map_err(failed)?).to_vec()
        }
        (mode, _) => return Err(format!("compression mode `{mode}` with a stride of {stride} is not known")),
    };
    match (view.filter.as_deref().unwrap_or("NONE"), stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => filter::<[i8; 4]>(&mut out, decode_filter_oct),
        ("OCTAHEDRAL", 8) => filter::<[i16; 4]>(&mut out, decode_filter_oct),
        ("QUATERNION", 8) => filter::<[i16; 4]>(&mut out, decode_filter_quat),
        ("EXPONENTIAL", _) if stride % 4 == 0 => filter::<[u32; 1]>(&mut out, decode_filter_exp),
        ("COLOR", 4) => filter::<[u8; 4]>(&mut out, decode_filter_color),
        ("COLOR", 8) => filter::<[u16; 4]>(&mut out, decode_filter_color),
        (filter, _) => return Err(format!("filter `{filter}` with a stride of {stride} is not known")),
    }
    Ok(out)
}

/// Applies a filter in place, by way of an aligned copy.
fn filter<T: Pod>(bytes: &mut [u8], apply: impl Fn(&mut [T])) {
    let mut aligned: Vec<T> = bytemuck::pod_collect_to_vec(bytes);
    apply(&mut aligned);
    bytes.copy_from_slice(&cast_slice(&aligned)[..bytes.len()]);
}

/// A vertex of `4 N` bytes.
#[derive(Clone, Copy)]
struct Words<const N: usize>([u32; N]);

impl<const N: usize> Default for Words<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

/// The codec takes the stride from a type, so there is one call for each of the 64 strides.
fn decode_vertices(bytes: &[u8], count: usize, stride: usize) -> meshopt::Result<Vec<u8>> {
    fn words<const N: usize>(bytes: &[u8], count: usize) -> meshopt::Result<Vec<u8>> {
        let vertices = meshopt::decode_vertex_buffer::<Words<N>>(bytes, count)?;
        let mut out = Vec::with_capacity(4 * N * count);
        vertices.iter().for_each(|v| out.extend_from_slice(cast_slice(&v.0)));
        Ok(out)
    }
    macro_rules! by_words {
        ($($n:literal)*) => {
            match stride / 4 {
                $($n => words::<$n>(bytes, count),)*
                _ => Ok(Vec::new()),
            }
        };
    }
    by_words!(
        1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
        33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
    )
}
