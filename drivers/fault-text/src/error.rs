//! Why a text is no fault.

/// A text that is no fault. Each message lists what is valid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "each message shows what its fields are")]
pub enum FaultTextError {
    #[error("expected a fault ({valid}), got `{got}`")]
    Kind { got: String, valid: String },
    #[error("fault `{kind}` has no key `{key}`; valid keys: {valid}")]
    Key {
        kind: String,
        key: String,
        valid: String,
    },
    #[error("fault `{kind}`: expected `key=value`, got `{got}`")]
    NotAPair { kind: String, got: String },
    #[error("fault `{kind}`: expected {key} to be {expected}, got `{got}`")]
    Value {
        kind: String,
        key: String,
        expected: &'static str,
        got: String,
    },
}
