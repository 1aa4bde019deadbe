//! `patrold rejudge`: stored sweeps judged again with the settings in force now; nothing is written.

mod args;
mod command;
mod judge;
mod many;
mod one;
mod source;

pub(super) use args::RejudgeArgs;
pub(super) use command::run;
