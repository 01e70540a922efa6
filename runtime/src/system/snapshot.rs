//! All of a frame at an instant: to go back to, or to go on from in another process.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::core_unit::CoreSnapshot;
use super::sharing::Sharing;
use super::tiles::TileQueue;
use crate::memory::SystemMemory;
use crate::memory::path::MemoryPath;
use crate::scene_image::SceneImage;

/// How far a frame is.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Instant {
    /// The SRP cycle that comes next.
    pub(super) srp: u64,
    /// The cycle of the T&I units that comes next.
    pub(super) tni: u64,
    /// The last SRP cycle in which something moved.
    pub(super) progress: u64,
    /// Results of the T&I units by then.
    pub(super) results: u64,
    /// When the outside is looked at next.
    pub(super) look_up: u64,
}

/// All of a frame at an instant.
#[derive(Clone)]
pub struct SystemSnapshot {
    pub(super) cores: Vec<CoreSnapshot>,
    pub(super) memory: Arc<SystemMemory>,
    pub(super) sharing: Sharing,
    pub(super) tiles: TileQueue,
    pub(super) paths: Vec<MemoryPath>,
    pub(super) at: Instant,
}

/// What is kept of a snapshot: of the memory only what cores may write, for the rest is the scene's.
#[derive(Serialize, Deserialize)]
struct Kept<C, W, S, T, P> {
    cores: C,
    written: W,
    sharing: S,
    tiles: T,
    paths: P,
    at: Instant,
}

impl SystemSnapshot {
    /// About how many bytes it takes, but for the memory, which snapshots may share.
    pub fn bytes(&self) -> usize {
        self.cores.iter().map(CoreSnapshot::bytes).sum()
    }

    /// The SRP cycle that comes next.
    pub fn cycle(&self) -> u64 {
        self.at.srp
    }

    /// For each core the cycle from which its engine goes on.
    pub fn ready(&self) -> Vec<u64> {
        let ready = self.cores.iter().map(CoreSnapshot::ready);
        ready.map(|cycle| cycle.max(self.at.srp)).collect()
    }

    /// It as bytes, from which [`decode`](Self::decode) makes the same.
    ///
    /// # Errors
    ///
    /// The units do not run cycle by cycle.
    pub fn encode(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_allocvec(&Kept {
            cores: &self.cores,
            written: self.memory.writable(),
            sharing: &self.sharing,
            tiles: &self.tiles,
            paths: &self.paths,
            at: self.at,
        })
    }

    /// The snapshot of a frame that began with this image on this machine. The bytes must be those of
    /// [`encode`](Self::encode) for the same frame.
    ///
    /// # Errors
    ///
    /// They are not.
    pub fn decode(bytes: &[u8], image: &SceneImage) -> Result<SystemSnapshot, postcard::Error> {
        let kept: Kept<Vec<CoreSnapshot>, Vec<u8>, Sharing, TileQueue, Vec<MemoryPath>> =
            postcard::from_bytes(bytes)?;
        let mut memory = image.memory.clone();
        let writable = memory.writable_mut();
        match writable.len() == kept.written.len() {
            true => writable.copy_from_slice(&kept.written),
            false => return Err(postcard::Error::DeserializeUnexpectedEnd),
        }
        Ok(SystemSnapshot {
            cores: kept.cores,
            memory: Arc::new(memory),
            sharing: kept.sharing,
            tiles: kept.tiles,
            paths: kept.paths,
            at: kept.at,
        })
    }
}
