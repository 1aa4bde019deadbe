//! The life of references and alarms in the store, told as a guard and an engineer would see it.

mod alarms;
mod kit;
mod records;
mod retention;
