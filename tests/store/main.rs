//! References, visits, alarms and retention in a store on disk.

mod alarm_filters;
mod alarms;
mod dialogue;
mod busy;
mod call_faults;
mod compaction;
#[path = "../harness/faulty_disk.rs"]
mod faulty_disk;
mod failing_accepts;
mod failing_calls;
mod failing_copies;
mod failing_restores;
mod faults;
mod health;
mod held;
mod incidents;
mod kills;
mod kit;
mod backup;
mod rebuild;
mod restore;
mod log;
mod mixtures;
mod records;
mod retention;
mod rights;
mod space;
mod teaching;
mod untouched_rows;
mod upgrade;
