//! Transfers between host memory and a device: growing buffers and read-back.

use std::sync::mpsc;
use std::time::Duration;

use wgpu::{
    Buffer, BufferAsyncError, BufferDescriptor, BufferUsages, CommandEncoder, MapMode, MapRangeError,
    PollError, PollType,
};

use super::Gpu;

pub const INPUT: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_DST);
pub const OUTPUT: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_SRC);
pub const READ_BACK: BufferUsages = BufferUsages::MAP_READ.union(BufferUsages::COPY_DST);

/// Maximum wait for one dispatch; a device that takes longer is considered hung.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// Reason why results did not come back from a device.
#[derive(Debug, thiserror::Error)]
pub enum TransferError {
    #[error(transparent)]
    NotWaited(#[from] PollError),
    #[error("the device did not answer")]
    NoAnswer,
    #[error(transparent)]
    NotMapped(#[from] BufferAsyncError),
    #[error(transparent)]
    Range(#[from] MapRangeError),
}

/// A buffer of at least `bytes`, rounded up to a power of two.
pub fn buffer(gpu: &Gpu, bytes: usize, usage: BufferUsages) -> Buffer {
    sized(gpu, bytes.next_power_of_two(), usage)
}

/// A buffer of `bytes`, but at least 256: an empty buffer cannot be bound.
pub fn sized(gpu: &Gpu, bytes: usize, usage: BufferUsages) -> Buffer {
    let size = bytes.max(256).next_multiple_of(4) as u64;
    gpu.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

/// Replaces the buffer if it is smaller than `bytes`; its contents are lost then.
pub fn grow(gpu: &Gpu, held: &mut Buffer, bytes: usize, usage: BufferUsages) {
    if held.size() < bytes as u64 {
        *held = buffer(gpu, bytes, usage);
    }
}

/// Encodes a copy into a mappable buffer, which grows as needed. Returns `bytes`.
pub fn read_back(
    gpu: &Gpu,
    encoder: &mut CommandEncoder,
    from: &Buffer,
    to: &mut Buffer,
    bytes: usize,
) -> usize {
    grow(gpu, to, bytes, READ_BACK);
    encoder.copy_buffer_to_buffer(from, 0, to, 0, bytes as u64);
    bytes
}

/// Waits for the submitted work and returns the words of a mappable buffer.
///
/// # Errors
///
/// The device failed or did not finish within 60 s.
pub fn read_words(gpu: &Gpu, from: &Buffer, bytes: usize) -> Result<Vec<u32>, TransferError> {
    let slice = from.slice(..bytes as u64);
    let (message, mapped) = mpsc::channel();
    slice.map_async(MapMode::Read, move |result| {
        let _ = message.send(result);
    });
    let waited = PollType::Wait { submission_index: None, timeout: Some(MAX_WAIT) };
    gpu.device.poll(waited)?;
    mapped.try_recv().map_err(|_| TransferError::NoAnswer)??;
    let view = slice.get_mapped_range()?;
    let word = |b: &[u8]| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
    let words = view.chunks_exact(4).map(word).collect();
    drop(view);
    from.unmap();
    Ok(words)
}

/// The numbers as bytes in native order.
pub fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_ne_bytes()).collect()
}
