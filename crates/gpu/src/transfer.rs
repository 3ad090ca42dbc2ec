//! Between memory and a device: buffers that grow, and what comes back.

use std::sync::mpsc;
use std::time::Duration;

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode, PollType};

use super::Gpu;

pub const INPUT: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_DST);
pub const OUTPUT: BufferUsages = BufferUsages::STORAGE.union(BufferUsages::COPY_SRC);
pub const READ_BACK: BufferUsages = BufferUsages::MAP_READ.union(BufferUsages::COPY_DST);

/// Longest wait for one dispatch; a device that takes longer hangs.
const LONGEST_WAIT: Duration = Duration::from_secs(60);

/// A buffer of at least that size; an empty one cannot be bound.
pub fn buffer(gpu: &Gpu, bytes: usize, usage: BufferUsages) -> Buffer {
    sized(gpu, bytes.next_power_of_two(), usage)
}

/// A buffer of that size, or the least that can be bound.
pub fn sized(gpu: &Gpu, bytes: usize, usage: BufferUsages) -> Buffer {
    let size = bytes.max(256).next_multiple_of(4) as u64;
    gpu.device.create_buffer(&BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
}

/// Makes the buffer as large as that, if it is smaller; what was in it is lost.
pub fn grow(gpu: &Gpu, held: &mut Buffer, bytes: usize, usage: BufferUsages) {
    if held.size() < bytes as u64 {
        *held = buffer(gpu, bytes, usage);
    }
}

/// Copies what was computed to where it can be read; the number of bytes.
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

/// Waits for what was submitted and reads it.
pub fn fetched(gpu: &Gpu, from: &Buffer, bytes: usize) -> Result<Vec<u32>, String> {
    let slice = from.slice(..bytes as u64);
    let (told, mapped) = mpsc::channel();
    slice.map_async(MapMode::Read, move |result| {
        let _ = told.send(result);
    });
    let waited = PollType::Wait { submission_index: None, timeout: Some(LONGEST_WAIT) };
    gpu.device.poll(waited).map_err(|error| error.to_string())?;
    let answer = mapped.try_recv().map_err(|_| "the device did not answer".to_owned())?;
    answer.map_err(|error| error.to_string())?;
    let view = slice.get_mapped_range().map_err(|error| error.to_string())?;
    let word = |b: &[u8]| u32::from_ne_bytes([b[0], b[1], b[2], b[3]]);
    let words = view.chunks_exact(4).map(word).collect();
    drop(view);
    from.unmap();
    Ok(words)
}

pub fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_ne_bytes()).collect()
}
