//! Times of the engine's answers, and the size of what they were compared with.

use patrold_engine::blob::{encode_mixture, encode_view};
use patrold_engine::novelty::Reference;

/// Milliseconds since some fixed instant; time is an argument, so that the crate has no clock.
pub type MillisClock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// An answer of the engine, its times, and the size of its reference.
#[derive(Debug, Clone)]
pub struct Timed<T> {
    /// The answer.
    pub answer: T,
    /// Preparation of the reference, milliseconds.
    pub reference_ms: f64,
    /// From the current view to the answer, milliseconds.
    pub answer_ms: f64,
    /// Bytes of the reference as the store keeps it: its mixture, and its view.
    pub stored_bytes: [usize; 2],
}

/// Prepares a reference, then compares with it.
pub(crate) fn timed<T, E>(
    clock: MillisClock<'_>,
    prepare: impl FnOnce() -> Result<Reference, E>,
    compare: impl FnOnce(&Reference) -> Result<T, E>,
) -> Result<Timed<T>, E> {
    let start_ms = clock();
    let reference = prepare()?;
    let prepared_ms = clock();
    let answer = compare(&reference)?;
    Ok(Timed {
        answer,
        reference_ms: prepared_ms - start_ms,
        answer_ms: clock() - prepared_ms,
        stored_bytes: stored_bytes(&reference),
    })
}

fn stored_bytes(reference: &Reference) -> [usize; 2] {
    [
        encode_mixture(&reference.gamma).len(),
        encode_view(&reference.prepared.view).len(),
    ]
}
