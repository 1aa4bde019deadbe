//! `patrold diagnose --out FILE`: what a person who helps from afar asks for, in one file.

mod collect;
mod command;
mod tar_file;

pub(super) use command::{DiagnoseArgs, run};
