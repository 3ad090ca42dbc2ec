//! Encoding of a crate file's sections. Numbers are little-endian.

use super::value_word::ValueWord;
use super::{Spec, compressed, compressed_integers};

/// The tokens, each terminated by NUL: count, size, compressed size, compressed bytes.
pub fn tokens(tokens: &[String]) -> Vec<u8> {
    let mut text = Vec::new();
    for token in tokens {
        assert!(!token.contains('\0'), "NUL ends a token");
        put_bytes(&mut text, token.as_bytes());
        text.push(0);
    }
    let mut bytes = Vec::new();
    put_u64(&mut bytes, tokens.len() as u64);
    put_u64(&mut bytes, text.len() as u64);
    put_packed(&mut bytes, &compressed(&text));
    bytes
}

/// The token index of each string.
pub fn strings(tokens: &[u32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    put_u64(&mut bytes, tokens.len() as u64);
    tokens.iter().for_each(|token| put_u32(&mut bytes, *token));
    bytes
}

/// Name indices, then value words.
pub fn fields(fields: &[(u32, ValueWord)]) -> Vec<u8> {
    let names: Vec<u32> = fields.iter().map(|(name, _)| *name).collect();
    let mut bytes = counted_integers(&names);
    let words: Vec<u8> = fields.iter().flat_map(|(_, word)| word.bits().to_le_bytes()).collect();
    put_packed(&mut bytes, &compressed(&words));
    bytes
}

/// Count and compressed integers.
pub fn counted_integers(integers: &[u32]) -> Vec<u8> {
    let mut bytes = Vec::new();
    put_u64(&mut bytes, integers.len() as u64);
    put_integers(&mut bytes, integers.iter().copied());
    bytes
}

/// Path indices, then starts of field lists, then spec types.
pub fn specs(specs: &[Spec]) -> Vec<u8> {
    let mut bytes = Vec::new();
    put_u64(&mut bytes, specs.len() as u64);
    put_integers(&mut bytes, specs.iter().map(|spec| spec.path));
    put_integers(&mut bytes, specs.iter().map(|spec| spec.field_set));
    put_integers(&mut bytes, specs.iter().map(|spec| spec.spec_type as u32));
    bytes
}

fn put_integers(bytes: &mut Vec<u8>, integers: impl Iterator<Item = u32>) {
    let integers: Vec<i32> = integers.map(|integer| integer as i32).collect();
    put_packed(bytes, &compressed_integers(&integers));
}

/// Length and bytes.
pub fn put_packed(bytes: &mut Vec<u8>, packed: &[u8]) {
    put_u64(bytes, packed.len() as u64);
    put_bytes(bytes, packed);
}

pub fn put_bytes(bytes: &mut Vec<u8>, more: &[u8]) {
    bytes.extend_from_slice(more);
}

pub fn put_u32(bytes: &mut Vec<u8>, value: u32) {
    put_bytes(bytes, &value.to_le_bytes());
}

pub fn put_u64(bytes: &mut Vec<u8>, value: u64) {
    put_bytes(bytes, &value.to_le_bytes());
}
