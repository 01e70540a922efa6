//! Checkpoints: the state of a frame or a program on the way, in a file, to go on from in another process.
//!
//! A checkpoint fits the build of the tools, the schedule, the machine and the scene that it was made with, and nothing
//! else: the words of an engine mean nothing to another. Its head has a digest over all of these, and one over the
//! state, so that what does not fit, or is damaged, is refused before anything is made of it.

use crate::files::{self, Kind};
use crate::{BUILD_ID, Error};
use serde::{Deserialize, Serialize};
use srp_ir::check::Checked;
use srp_runtime::core::CoreState;
use srp_runtime::scene_image::SceneImage;
use srp_runtime::solo::{Finish, Solo};
use srp_runtime::system::SystemSnapshot;
use std::path::Path;

/// The version of the form.
const VERSION: u32 = 1;

/// How a file of this kind begins.
const MAGIC: &[u8; 8] = b"SRPCHKPT";

/// What stands before the state.
#[derive(Serialize, Deserialize)]
struct Head {
    version: u32,
    build: String,
    /// The SRP cycle that comes next.
    cycle: u64,
    /// Over schedule and machine, and over the frame, where there is one.
    program: [u8; 32],
    subject: [u8; 32],
    /// Over the state.
    state: [u8; 32],
}

/// What a checkpoint is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subject {
    program: [u8; 32],
    subject: [u8; 32],
}

/// A program without a frame on the way.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ProgramState {
    engine: Vec<u32>,
    solo: Solo,
    finish: Finish,
}

impl Subject {
    /// A program by itself.
    ///
    /// # Errors
    ///
    /// The program cannot be written as bytes.
    pub fn program(program: &Checked) -> Result<Subject, Error> {
        Ok(Subject {
            program: digest(&(&**program, program.arch()))?,
            subject: *blake3::hash(b"a program").as_bytes(),
        })
    }

    /// A frame: a program over a scene.
    ///
    /// # Errors
    ///
    /// The program cannot be written as bytes.
    pub fn frame(program: &Checked, image: &SceneImage) -> Result<Subject, Error> {
        let frame = image.frame;
        let mut hasher = blake3::Hasher::new();
        hasher.update(image.memory.bytes());
        for word in [frame.address, frame.width, frame.height, frame.stride] {
            hasher.update(&word.to_le_bytes());
        }
        Ok(Subject {
            subject: *hasher.finalize().as_bytes(),
            ..Subject::program(program)?
        })
    }
}

impl ProgramState {
    /// The state of a core and what is round it.
    pub fn new(engine: CoreState, solo: Solo, finish: Finish) -> ProgramState {
        let engine = engine.words;
        ProgramState {
            engine,
            solo,
            finish,
        }
    }

    /// The state of the core, what is round it, and the cycles until then.
    pub fn parts(self) -> (CoreState, Solo, Finish) {
        let words = self.engine;
        (CoreState { words }, self.solo, self.finish)
    }
}

/// The digest of a value, all of it.
fn digest(value: &impl Serialize) -> Result<[u8; 32], Error> {
    let bytes = postcard::to_allocvec(value).map_err(Error::invalid)?;
    Ok(*blake3::hash(&bytes).as_bytes())
}

/// The file of a frame on the way.
///
/// # Errors
///
/// The units do not run cycle by cycle.
pub fn of_frame(subject: Subject, snapshot: &SystemSnapshot) -> Result<Vec<u8>, Error> {
    let state = snapshot.encode().map_err(Error::invalid)?;
    file(subject, snapshot.cycle(), &state)
}

/// The file of a program on the way.
///
/// # Errors
///
/// The state cannot be written as bytes.
pub fn of_program(subject: Subject, state: &ProgramState) -> Result<Vec<u8>, Error> {
    let bytes = postcard::to_allocvec(state).map_err(Error::invalid)?;
    file(subject, state.finish.cycles(), &bytes)
}

fn file(subject: Subject, cycle: u64, state: &[u8]) -> Result<Vec<u8>, Error> {
    let head = Head {
        version: VERSION,
        build: BUILD_ID.to_owned(),
        cycle,
        program: subject.program,
        subject: subject.subject,
        state: *blake3::hash(state).as_bytes(),
    };
    let head = postcard::to_allocvec(&head).map_err(Error::invalid)?;
    let length = (head.len() as u32).to_le_bytes();
    Ok([MAGIC.as_slice(), &length, &head, state].concat())
}

/// Reads the state of a frame, and says where it goes on.
///
/// # Errors
///
/// The file cannot be read, is damaged, or is of something else.
pub fn read_frame(
    path: &Path,
    subject: Subject,
    image: &SceneImage,
) -> Result<SystemSnapshot, Error> {
    let state = read(path, subject)?;
    SystemSnapshot::decode(&state, image).map_err(|_| damaged(path))
}

/// Reads the state of a program.
///
/// # Errors
///
/// The file cannot be read, is damaged, or is of something else.
pub fn read_program(path: &Path, subject: Subject) -> Result<ProgramState, Error> {
    let state = read(path, subject)?;
    postcard::from_bytes(&state).map_err(|_| damaged(path))
}

fn damaged(path: &Path) -> Error {
    Error::invalid(format_args!("{} is a damaged checkpoint", path.display()))
}

/// The state in a file that fits.
fn read(path: &Path, subject: Subject) -> Result<Vec<u8>, Error> {
    let bytes = files::read_bytes(path, Kind::Checkpoint)?;
    let refuse = |why: &str| Err(Error::invalid(format_args!("{} {why}", path.display())));
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        return refuse("is no checkpoint");
    };
    let parts = rest.split_first_chunk().and_then(|(length, rest)| {
        let (head, state) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        Some((postcard::from_bytes::<Head>(head).ok()?, state))
    });
    let Some((head, state)) = parts else {
        return Err(damaged(path));
    };
    if head.version != VERSION || head.build != BUILD_ID {
        return refuse(&format!(
            "was made by another build of srp ({}; this is {BUILD_ID}): make it again",
            head.build
        ));
    }
    if head.program != subject.program {
        return refuse("is of another program, machine, or choice of options");
    }
    if head.subject != subject.subject {
        return refuse("is of another scene, camera, or size");
    }
    if head.state != *blake3::hash(state).as_bytes() {
        return Err(damaged(path));
    }
    Ok(state.to_vec())
}
