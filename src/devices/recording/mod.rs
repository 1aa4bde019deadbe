//! The dialogue of a sweep with both devices: every byte as it came, with its instant, and from it the sweep again.
//!
//! | file | input | output |
//! |---|---|---|
//! | `tap` | what ports and station do, in their order | the dialogue of one sweep |
//! | `recorded_driver` | a driver | the same driver, its inputs and outputs recorded |
//! | `dialogue` | the dialogue | its entries |
//! | `container` | the dialogue | bytes of docs/recording.md, and back |
//! | `byte_reader`, `byte_writer`, `recorded_plan`, `recorded_laser` | numbers, plan, state | bytes, and back |
//! | `replay` | the bytes of a container | the raw sweep, or why they give none |
//!
//! A driver is a function of its bytes and instants, and so is the sweep of the events of both drivers; so the same entries
//! give the same sweep to the last bit.

mod byte_reader;
mod byte_writer;
mod constants;
mod container;
mod dialogue;
mod error;
mod recorded_driver;
mod recorded_laser;
mod recorded_plan;
mod replay;
mod tap;

pub(crate) use byte_reader::ByteReader;
pub(crate) use byte_writer::ByteWriter;
pub(in crate::devices) use constants::{BEGIN_ATTEMPTS, IDLE_LIMIT};
pub use dialogue::{DialogueEnd, DialogueEntry, DialogueEntryKind, SweepDialogue};
pub use error::DialogueError;
pub(crate) use recorded_driver::RecordedDriver;
pub(crate) use recorded_laser::{decode_laser, encode_laser};
pub(in crate::devices) use recorded_plan::encode_plan;
pub use replay::{ReplayError, ReplayedSweep, replay_sweep};
pub(crate) use tap::DialogueTap;
