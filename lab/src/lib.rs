//! What proves the engine: [`evaluate`] counts how often it is right on simulated pairs with their truth, [`reproduce`]
//! repeats the experiments of the paper it implements.

pub mod evaluate;
pub mod reproduce;
