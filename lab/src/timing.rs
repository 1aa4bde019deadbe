//! Times of the engine's answers.

/// Milliseconds since some fixed instant; time is an argument, so that the crate has no clock.
pub type MillisClock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// An answer of the engine and its times.
#[derive(Debug, Clone)]
pub struct Timed<T> {
    /// The answer.
    pub answer: T,
    /// Preparation of the reference, milliseconds.
    pub reference_ms: f64,
    /// From the current view to the answer, milliseconds.
    pub answer_ms: f64,
}

/// Prepares a reference, then compares with it.
pub(crate) fn timed<R, T, E>(
    clock: MillisClock<'_>,
    prepare: impl FnOnce() -> Result<R, E>,
    compare: impl FnOnce(&R) -> Result<T, E>,
) -> Result<Timed<T>, E> {
    let start_ms = clock();
    let reference = prepare()?;
    let prepared_ms = clock();
    let answer = compare(&reference)?;
    Ok(Timed {
        answer,
        reference_ms: prepared_ms - start_ms,
        answer_ms: clock() - prepared_ms,
    })
}
