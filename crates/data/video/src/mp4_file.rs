//! An MP4 file that many clips share: samples go to the writer at once, the tables at the end.
//!
//! The layout is `ftyp`, `mdat`, `moov` (ISO/IEC 14496-12 and -15), with one chunk per clip. Every frame lasts
//! [`TICKS_PER_FRAME`] ticks of a clock with `fps * TICKS_PER_FRAME` ticks a second, so that frame `i` begins at
//! exactly `i / fps` seconds. Colors are declared as what the encoder makes: limited range, matrix of BT.601. Memory
//! holds a few bytes a frame. Equal clips give equal bytes: there are no times of creation.

use std::io::{self, Seek, SeekFrom, Write};

use crate::Sample;
use crate::parameter_sets::{ParameterSets, length_prefixed};

/// Duration of one frame in ticks of the file's clock.
pub const TICKS_PER_FRAME: u32 = 512;

/// The identity as MP4 states it: 16.16 numbers, and 2.30 in the last column.
const IDENTITY: [u32; 9] = [0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000];

/// An MP4 file that grows clip by clip.
pub struct Mp4File<W: Write + Seek> {
    writer: W,
    width_px: u16,
    height_px: u16,
    fps: u32,
    parameter_sets: Option<ParameterSets>,
    media_start: u64,
    media_bytes: u64,
    sample_sizes: Vec<u32>,
    /// Numbers of the key frames, from 1.
    key_frames: Vec<u32>,
    /// Offset of each clip in the file, bytes, and its number of frames.
    clips: Vec<(u64, u32)>,
}

/// Reason why a clip cannot be added to a file.
#[derive(Debug, thiserror::Error)]
pub enum Mp4Error {
    #[error("adding a clip to a video file: the clip has no frames; add one first")]
    EmptyClip,
    #[error(
        "adding a clip to a video file: its first frame is no key frame; begin each clip with a new encoder"
    )]
    NoKeyFrame,
    #[error(
        "adding a clip to a video file: frame {frame} has no parameter sets of H.264, or none at the start"
    )]
    NoParameterSets { frame: usize },
    #[error(
        "adding a clip to a video file: frame {frame} has other settings of the encoder than the file; start a file"
    )]
    OtherSettings { frame: usize },
    #[error(
        "adding a clip to a video file: the sizes of the video do not fit; at most 4096 pixels and 1000 frames/s"
    )]
    Size,
    #[error("writing a video file: {0}")]
    Write(#[from] io::Error),
}

impl<W: Write + Seek> Mp4File<W> {
    /// Begins a file of `width_px` by `height_px` pixels at the start of `writer`.
    ///
    /// # Errors
    ///
    /// [`Mp4Error::Size`] for sizes or rates that the file cannot state; [`Mp4Error::Write`] of the writer.
    pub fn new(mut writer: W, width_px: u32, height_px: u32, fps: u32) -> Result<Self, Mp4Error> {
        let side = |side_px: u32| u16::try_from(side_px).ok().filter(|side| (1..=4096).contains(side));
        let (Some(width_px), Some(height_px), 1..=1000) = (side(width_px), side(height_px), fps) else {
            return Err(Mp4Error::Size);
        };
        let mut header = boxed(b"ftyp", |body| {
            body.extend(b"isom");
            body.extend(512_u32.to_be_bytes());
            body.extend(b"isomiso2avc1mp41");
        });
        let media_start = header.len() as u64;
        // A box with a size of 64 bits, which `finish` sets.
        header.extend(1_u32.to_be_bytes());
        header.extend(b"mdat");
        header.extend(0_u64.to_be_bytes());
        writer.write_all(&header)?;
        Ok(Self {
            writer,
            width_px,
            height_px,
            fps,
            parameter_sets: None,
            media_start,
            media_bytes: 16,
            sample_sizes: Vec::new(),
            key_frames: Vec::new(),
            clips: Vec::new(),
        })
    }

    /// The frames that the file has.
    pub fn frames(&self) -> usize {
        self.sample_sizes.len()
    }

    /// The bytes that the file has without its tables.
    pub fn bytes(&self) -> u64 {
        self.media_start + self.media_bytes
    }

    /// Appends a clip, which begins with a key frame, after the frames that the file has.
    ///
    /// # Errors
    ///
    /// [`Mp4Error`] for a clip that does not fit the file, before anything is written; [`Mp4Error::Write`] of the
    /// writer.
    pub fn append(&mut self, clip: &[Sample]) -> Result<(), Mp4Error> {
        let first = clip.first().ok_or(Mp4Error::EmptyClip)?;
        if !first.is_key {
            return Err(Mp4Error::NoKeyFrame);
        }
        for (frame, sample) in clip.iter().enumerate().filter(|(_, sample)| sample.is_key) {
            let sets = ParameterSets::of(&sample.bytes).ok_or(Mp4Error::NoParameterSets { frame })?;
            let of_file = self.parameter_sets.get_or_insert_with(|| sets.clone());
            if *of_file != sets {
                return Err(Mp4Error::OtherSettings { frame });
            }
        }
        let frames = u32::try_from(clip.len()).map_err(|_| Mp4Error::Size)?;
        self.clips.push((self.bytes(), frames));
        for sample in clip {
            let bytes = length_prefixed(&sample.bytes);
            self.writer.write_all(&bytes)?;
            self.media_bytes += bytes.len() as u64;
            self.sample_sizes.push(u32::try_from(bytes.len()).map_err(|_| Mp4Error::Size)?);
            if sample.is_key {
                self.key_frames.push(u32::try_from(self.sample_sizes.len()).map_err(|_| Mp4Error::Size)?);
            }
        }
        Ok(())
    }

    /// Writes the tables and returns the writer, at the end of the file.
    ///
    /// # Errors
    ///
    /// [`Mp4Error::EmptyClip`] for a file without clips; [`Mp4Error::Write`] of the writer.
    pub fn finish(mut self) -> Result<W, Mp4Error> {
        let sets = self.parameter_sets.take().ok_or(Mp4Error::EmptyClip)?;
        let tables = self.movie(&sets);
        self.writer.write_all(&tables)?;
        self.writer.seek(SeekFrom::Start(self.media_start + 8))?;
        self.writer.write_all(&self.media_bytes.to_be_bytes())?;
        self.writer.seek(SeekFrom::End(0))?;
        self.writer.flush()?;
        Ok(self.writer)
    }

    fn movie(&self, sets: &ParameterSets) -> Vec<u8> {
        let ticks_per_s = self.fps * TICKS_PER_FRAME;
        let duration = self.sample_sizes.len() as u64 * u64::from(TICKS_PER_FRAME);
        boxed(b"moov", |movie| {
            movie.extend(full_box(b"mvhd", 1, 0, |body| {
                body.extend([0; 16]); // times of creation and change
                body.extend(ticks_per_s.to_be_bytes());
                body.extend(duration.to_be_bytes());
                body.extend(0x1_0000_u32.to_be_bytes()); // rate 1
                body.extend(0x0100_u16.to_be_bytes()); // volume 1
                body.extend([0; 10]);
                IDENTITY.iter().for_each(|number| body.extend(number.to_be_bytes()));
                body.extend([0; 24]);
                body.extend(2_u32.to_be_bytes()); // the next track
            }));
            movie.extend(boxed(b"trak", |track| {
                // Flags 3: the track is enabled and in the presentation.
                track.extend(full_box(b"tkhd", 1, 3, |body| {
                    body.extend([0; 16]);
                    body.extend(1_u32.to_be_bytes()); // number of the track
                    body.extend([0; 4]);
                    body.extend(duration.to_be_bytes());
                    body.extend([0; 16]); // reserved, layer, group, volume
                    IDENTITY.iter().for_each(|number| body.extend(number.to_be_bytes()));
                    body.extend((u32::from(self.width_px) << 16).to_be_bytes());
                    body.extend((u32::from(self.height_px) << 16).to_be_bytes());
                }));
                track.extend(boxed(b"mdia", |media| {
                    media.extend(full_box(b"mdhd", 1, 0, |body| {
                        body.extend([0; 16]);
                        body.extend(ticks_per_s.to_be_bytes());
                        body.extend(duration.to_be_bytes());
                        body.extend([0x55, 0xC4, 0, 0]); // language "und"
                    }));
                    media.extend(full_box(b"hdlr", 0, 0, |body| {
                        body.extend([0; 4]);
                        body.extend(b"vide");
                        body.extend([0; 12]);
                        body.extend(b"video\0");
                    }));
                    media.extend(boxed(b"minf", |information| {
                        information.extend(full_box(b"vmhd", 0, 1, |body| body.extend([0; 8])));
                        information.extend(boxed(b"dinf", |data| {
                            data.extend(full_box(b"dref", 0, 0, |body| {
                                body.extend(1_u32.to_be_bytes());
                                // Flags 1: the samples are in this file.
                                body.extend(full_box(b"url ", 0, 1, |_| {}));
                            }));
                        }));
                        information.extend(self.sample_tables(sets));
                    }));
                }));
            }));
        })
    }

    fn sample_tables(&self, sets: &ParameterSets) -> Vec<u8> {
        boxed(b"stbl", |tables| {
            tables.extend(full_box(b"stsd", 0, 0, |body| {
                body.extend(1_u32.to_be_bytes());
                body.extend(self.sample_entry(sets));
            }));
            let frames = self.sample_sizes.len() as u32;
            tables.extend(table(b"stts", &[frames, TICKS_PER_FRAME], 2));
            tables.extend(table(b"stss", &self.key_frames, 1));
            tables.extend(table(b"stsc", &self.chunk_runs(), 3));
            tables.extend(full_box(b"stsz", 0, 0, |body| {
                body.extend([0; 4]);
                body.extend(frames.to_be_bytes());
                self.sample_sizes.iter().for_each(|size| body.extend(size.to_be_bytes()));
            }));
            tables.extend(full_box(b"co64", 0, 0, |body| {
                body.extend((self.clips.len() as u32).to_be_bytes());
                self.clips.iter().for_each(|(start, _)| body.extend(start.to_be_bytes()));
            }));
        })
    }

    /// First chunk, frames a chunk, sample entry: one line for each run of clips with equally many frames.
    fn chunk_runs(&self) -> Vec<u32> {
        let (mut runs, mut frames_before) = (Vec::new(), 0);
        for (chunk, (_, frames)) in (1_u32..).zip(&self.clips) {
            if *frames != frames_before {
                runs.extend([chunk, *frames, 1]);
                frames_before = *frames;
            }
        }
        runs
    }

    fn sample_entry(&self, sets: &ParameterSets) -> Vec<u8> {
        boxed(b"avc1", |body| {
            body.extend([0, 0, 0, 0, 0, 0, 0, 1]); // reserved, data reference
            body.extend([0; 16]);
            body.extend(self.width_px.to_be_bytes());
            body.extend(self.height_px.to_be_bytes());
            // 72 dots an inch, twice; then one frame a sample.
            body.extend([0, 0x48, 0, 0, 0, 0x48, 0, 0, 0, 0, 0, 0, 0, 1]);
            body.extend([0; 32]);
            body.extend([0, 0x18, 0xFF, 0xFF]); // 24 bits, no color table
            body.extend(boxed(b"avcC", |record| record.extend(sets.configuration_record())));
            body.extend(boxed(b"colr", |color| {
                color.extend(b"nclx");
                // Primaries of BT.709 and the curve of sRGB, as renders have; the matrix of BT.601; limited range.
                [1_u16, 13, 6].iter().for_each(|code| color.extend(code.to_be_bytes()));
                color.push(0);
            }));
        })
    }
}

fn boxed(name: &[u8; 4], fill: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = vec![0; 4];
    bytes.extend(name);
    fill(&mut bytes);
    let size = bytes.len() as u32;
    bytes[..4].copy_from_slice(&size.to_be_bytes());
    bytes
}

fn full_box(name: &[u8; 4], version: u8, flags: u8, fill: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    boxed(name, |body| {
        body.extend([version, 0, 0, flags]);
        fill(body);
    })
}

/// A table of entries that have `columns` numbers.
fn table(name: &[u8; 4], numbers: &[u32], columns: usize) -> Vec<u8> {
    full_box(name, 0, 0, |body| {
        body.extend(((numbers.len() / columns) as u32).to_be_bytes());
        numbers.iter().for_each(|number| body.extend(number.to_be_bytes()));
    })
}
