//! Frames of one episode into an episode unit. It holds encoded frames, never images.

use crate::EpisodeError;
use crate::camera_track::CameraEncoder;
use crate::description::DatasetDescription;
use crate::episode::{EpisodeHeader, Outcome};
use crate::format::{Encodings, Format};
use crate::frame::{Frame, fault_of};
use crate::point_cloud::PointCloudTrack;
use crate::preview::PreviewEncoder;
use crate::unit::EpisodeUnit;

/// Name of the small video in errors, in place of a camera.
const PREVIEW: &str = "preview";

/// An episode that is being recorded.
pub struct EpisodeEncoder {
    description: DatasetDescription,
    encodings: Encodings,
    header: EpisodeHeader,
    state: Vec<f32>,
    action: Vec<f32>,
    servo_command: Vec<f32>,
    cameras: Vec<CameraEncoder>,
    points: PointCloudTrack,
    preview: Option<PreviewEncoder>,
    frames: usize,
}

impl EpisodeEncoder {
    /// An episode without frames, encoded for these formats.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Episode`] for a task that the dataset does not have; [`EpisodeError::Video`] where a video
    /// encoder does not start.
    pub fn new(
        description: &DatasetDescription,
        formats: &[Format],
        header: EpisodeHeader,
    ) -> Result<Self, EpisodeError> {
        let (episode, tasks) = (header.number, description.tasks().len());
        if header.task >= tasks {
            let what = format!("it names task {}, the dataset has {tasks}", header.task);
            let correction = "name a task by its place in the description, from 0";
            return Err(EpisodeError::Episode { episode, what, correction });
        }
        let encodings = Encodings::of(formats);
        let begin = |camera| CameraEncoder::new(camera, encodings, description.fps());
        let cameras = description
            .cameras()
            .iter()
            .map(|camera| begin(camera).map_err(|source| EpisodeError::video(episode, &camera.name, source)))
            .collect::<Result<_, _>>()?;
        let preview = if encodings.video { PreviewEncoder::new(description) } else { Ok(None) };
        let preview = preview.map_err(|source| EpisodeError::video(episode, PREVIEW, source))?;
        Ok(Self {
            description: description.clone(),
            encodings,
            header,
            state: Vec::new(),
            action: Vec::new(),
            servo_command: Vec::new(),
            cameras,
            points: PointCloudTrack::default(),
            preview,
            frames: 0,
        })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Frame`] for a frame that does not fit the description: lengths, sizes, numbers that are not
    /// finite or outside their range, a pose that is not rigid, a quaternion whose sign is not that of the frame
    /// before, or not in state and action alike. [`EpisodeError::Video`] where an encoder fails. The episode should be
    /// given up then.
    pub fn add(&mut self, frame: &Frame) -> Result<(), EpisodeError> {
        let episode = self.header.number;
        let fault = fault_of(frame, &self.description).or_else(|| self.jump_of_sign(frame));
        if let Some((what, correction)) = fault {
            return Err(EpisodeError::Frame { episode, frame: self.frames, what, correction });
        }
        self.state.extend(frame.state);
        self.action.extend(frame.action);
        self.servo_command.extend(frame.servo_command);
        let described = self.description.cameras();
        for ((encoder, camera), image) in self.cameras.iter_mut().zip(described).zip(frame.cameras) {
            encoder.add(image).map_err(|source| EpisodeError::video(episode, &camera.name, source))?;
        }
        if let Some(preview) = &mut self.preview {
            let images = frame.cameras.iter().map(|camera| camera.image);
            preview.add(images).map_err(|source| EpisodeError::video(episode, PREVIEW, source))?;
        }
        if let Some(points) = frame.points.filter(|_| self.encodings.points_zlib) {
            self.points.add(&points);
        }
        self.frames += 1;
        Ok(())
    }

    /// The unit of the episode.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Episode`] for no frames, for a failure without a reason, and for actions that are copies of
    /// the state: a policy that learns from those stands still. [`EpisodeError::Video`] where the preview fails.
    pub fn finish(self, outcome: Outcome) -> Result<EpisodeUnit, EpisodeError> {
        let episode = self.header.number;
        let failed = |what: &str, correction| {
            Err(EpisodeError::Episode { episode, what: what.to_owned(), correction })
        };
        if self.frames == 0 {
            return failed("it has no frames", "record at least one");
        }
        if outcome.label().trim().is_empty() {
            return failed("it failed without a reason", "state the reason");
        }
        if self.action_copies_state() {
            let what = "every action equals the state it was recorded with, while the state changes";
            return failed(what, "record the commanded targets as actions");
        }
        let preview = self.preview.map(PreviewEncoder::finish).transpose();
        let preview = preview.map_err(|source| EpisodeError::video(episode, PREVIEW, source))?;
        Ok(EpisodeUnit {
            description: self.description.digest(),
            encodings: self.encodings,
            header: self.header,
            outcome,
            frames: self.frames,
            state: self.state,
            action: self.action,
            servo_command: self.servo_command,
            cameras: self.cameras.into_iter().map(CameraEncoder::finish).collect(),
            points: self.points,
            preview_mp4: preview.unwrap_or_default(),
        })
    }

    /// A quaternion q and -q are one rotation: numbers that jump between them are no motion, and teach one.
    fn jump_of_sign(&self, frame: &Frame) -> Option<(String, &'static str)> {
        let (states, actions) = (self.description.state(), self.description.action());
        let before = self.state.chunks_exact(states.dimension()).next_back();
        let of_state = before.and_then(|before| states.other_sign(frame.state, states, before));
        let in_state = of_state.map(|group| format!("`{group}` of the state has the other sign than before"));
        let in_action = || {
            let group = actions.other_sign(frame.action, states, frame.state)?;
            Some(format!("`{group}` of the action has the other sign than that of the state"))
        };
        let what = in_state.or_else(in_action)?;
        Some((what, "negate the quaternion: of its two forms take the nearer one"))
    }

    /// Whether numbers that the state and the action both have are equal in every frame, though they change.
    fn action_copies_state(&self) -> bool {
        let (states, actions) = (self.description.state(), self.description.action());
        let names = states.full_names();
        let pairs: Vec<(usize, usize)> = actions
            .full_names()
            .iter()
            .enumerate()
            .filter_map(|(a, name)| Some((names.iter().position(|other| other == name)?, a)))
            .collect();
        let rows =
            || self.state.chunks_exact(states.dimension()).zip(self.action.chunks_exact(actions.dimension()));
        let changes = pairs.iter().any(|(s, _)| rows().any(|(state, _)| state[*s] != self.state[*s]));
        changes && rows().all(|(state, action)| pairs.iter().all(|(s, a)| state[*s] == action[*a]))
    }
}
