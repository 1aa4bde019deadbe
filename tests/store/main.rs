//! References, visits, alarms and retention in a store on disk.

mod alarms;
mod kit;
mod mixtures;
mod records;
mod retention;
