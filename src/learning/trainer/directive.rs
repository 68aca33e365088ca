//! What a training's callback answers: go on, stop, or cancel.

/// What a training does next.
///
/// A callback that returns nothing lets it go on: `()` becomes [`Directive::Continue`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Directive {
    /// Take the next step.
    #[default]
    Continue,
    /// End here and keep the best weights so far, as if this were the last step.
    Stop,
    /// End here without a result: the training fails with an error of which
    /// [`is_cancelled`](crate::Error::is_cancelled) is true, and leaves a checkpoint where it keeps one.
    Cancel,
}

impl From<()> for Directive {
    fn from((): ()) -> Self {
        Self::Continue
    }
}
