//! Messages as bytes, for where the engine works behind a wall that only bytes pass: the worker of a page.

use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// A message as bytes.
///
/// # Errors
/// Hardly: a message that serde cannot put down.
pub fn pack<T: Serialize>(message: &T) -> Result<Vec<u8>, String> {
    postcard::to_stdvec(message).map_err(|e| e.to_string())
}

/// The message that bytes stand for.
///
/// # Errors
/// Bytes that are no such message.
pub fn unpack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    postcard::from_bytes(bytes).map_err(|e| e.to_string())
}

/// Planes of numbers, copied as a whole: one by one they would take longer than their estimates.
pub(crate) mod plane {
    use std::sync::Arc;

    pub(crate) fn serialize<S: serde::Serializer>(plane: &[f32], to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytemuck::cast_slice(plane))
    }

    pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Arc<Vec<f32>>, D::Error> {
        let bytes: &'de [u8] = serde::Deserialize::deserialize(from)?;
        Ok(Arc::new(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()))
    }
}

/// Bytes, copied as a whole.
pub(crate) mod as_bytes {
    pub(crate) fn serialize<S: serde::Serializer>(bytes: &[u8], to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytes)
    }

    pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<u8>, D::Error> {
        let bytes: &'de [u8] = serde::Deserialize::deserialize(from)?;
        Ok(bytes.to_vec())
    }
}

/// Bytes that are shared, copied as a whole.
pub(crate) mod shared_bytes {
    use std::sync::Arc;

    pub(crate) fn serialize<S: serde::Serializer>(bytes: &Arc<[u8]>, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_bytes(bytes)
    }

    pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Arc<[u8]>, D::Error> {
        let bytes: &'de [u8] = serde::Deserialize::deserialize(from)?;
        Ok(bytes.into())
    }
}

/// Settings, whose forms only a format that describes itself can tell apart.
pub(crate) mod as_json {
    use super::*;
    use serde::{de::Error as _, ser::Error as _};

    pub(crate) fn serialize<T: Serialize, S: serde::Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&serde_json::to_string(value).map_err(S::Error::custom)?)
    }

    pub(crate) fn deserialize<'de, T: DeserializeOwned, D: serde::Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        serde_json::from_str(&String::deserialize(from)?).map_err(D::Error::custom)
    }
}

/// Where estimates are made, as a number.
pub(crate) mod device {
    use conray::Device;
    use serde::{Deserialize, Serialize, de::Error};

    const ALL: [Device; 3] = [Device::Auto, Device::Cpu, Device::Gpu];

    pub(crate) fn serialize<S: serde::Serializer>(device: &Device, to: S) -> Result<S::Ok, S::Error> {
        ALL.iter().position(|known| known == device).unwrap_or(0).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Device, D::Error> {
        let number = usize::deserialize(from)?;
        ALL.get(number).copied().ok_or_else(|| D::Error::custom(format!("there is no device {number}")))
    }
}
