//! The `meta` array of a dataset: JSON that names the channels in their order.

use crate::recording::Channel;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{MapAccess, Visitor},
    ser::SerializeMap,
};
use std::fmt;

/// `{"channels": {NAME: {"unit", "bearing_rad", "maximum", "offset_m"}}, "source", "sha256"}`
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Meta {
    pub channels: Channels,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
}

/// What the file says of a channel besides its name.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Described {
    #[serde(default)]
    pub unit: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bearing_rad: Option<Vec<f64>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub maximum: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<Vec<f64>>,
}

/// A JSON object whose order counts, which a map type would not keep.
#[derive(Debug)]
pub(super) struct Channels(pub Vec<(String, Described)>);

impl Channels {
    pub fn of(channels: &[Channel]) -> Self {
        let described = |c: &Channel| Described {
            unit: c.unit.clone(),
            bearing_rad: c.bearing_rad.clone(),
            maximum: c.maximum,
            offset_m: c.offset_m.clone(),
        };
        Self(
            channels
                .iter()
                .map(|c| (c.name.clone(), described(c)))
                .collect(),
        )
    }
}

impl Serialize for Channels {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, channel) in &self.0 {
            map.serialize_entry(name, channel)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Channels {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Channels;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object with one entry a channel")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Channels, A::Error> {
                let mut channels = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    channels.push(entry);
                }
                Ok(Channels(channels))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}
