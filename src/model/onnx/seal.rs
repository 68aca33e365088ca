//! The digest that ends a graph's file.

use super::proto::{ModelProto, StringStringEntryProto};
use crate::storage;
use prost::Message;

/// What ends a file: its last metadata, the digest of the bytes before.
pub fn seal(bytes: &[u8]) -> Vec<u8> {
    // Fields of a message that stand behind one another are one message.
    let last = ModelProto {
        metadata_props: vec![entry("sha256", storage::sha256(bytes))],
        ..ModelProto::default()
    };
    last.encode_to_vec()
}

/// A line of metadata.
pub fn entry(key: &str, value: String) -> StringStringEntryProto {
    StringStringEntryProto {
        key: key.into(),
        value,
    }
}
