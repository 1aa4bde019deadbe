//! References, visits, alarms and retention in a store on disk.

mod alarms;
mod dialogue;
#[path = "../harness/faulty_disk.rs"]
mod faulty_disk;
mod failing_calls;
mod faults;
mod health;
mod incidents;
mod kit;
mod backup;
mod rebuild;
mod restore;
mod log;
mod mixtures;
mod records;
mod retention;
mod untouched_rows;
mod upgrade;
