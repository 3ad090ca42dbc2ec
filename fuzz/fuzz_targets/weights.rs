//! Weights of networks: a safetensors file of the network that reads images, or, after a `D`, the length of
//! a `config.json` in two bytes (little endian) and it, one of DINOv2.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vision::dinov2::Dinov2;
use vision::table_network::TableNetwork;

fuzz_target!(|bytes: &[u8]| {
    match bytes {
        [b'D', low, high, rest @ ..] => {
            let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
            let (config, safetensors) = rest.split_at(length);
            let _ = Dinov2::read(config, safetensors.to_vec());
        }
        _ => {
            let _ = TableNetwork::read(bytes.to_vec());
        }
    }
});
