//! Where the values of an image stand in its channel, laid out as in Thrun (1998), 5.1.3: ten rows, then ten columns, of seven
//! values each, all in standard deviations of the image.

use crate::recording::Channel;
use ndarray::ArrayView1;

/// Rows, and columns, of an image.
pub(super) const STRIPS: usize = 10;
/// Values of one.
const VALUES: usize = 7;

/// Mean brightness of a strip, among its values.
pub(super) const BRIGHTNESS: usize = 0;
/// Mean difference of neighbouring pixels in red, among its values.
pub(super) const TEXTURE_IN_RED: usize = 4;

/// The channel `camera`, where it has these 140 values.
pub(super) struct Camera {
    /// Where they begin among those of a snapshot.
    from: usize,
}

impl Camera {
    /// `None` where there is no such channel.
    pub fn find(channels: &[Channel]) -> Option<Self> {
        let mut from = 0;
        for channel in channels {
            if channel.name == "camera" && channel.width == 2 * STRIPS * VALUES {
                return Some(Self { from });
            }
            from += channel.width;
        }
        None
    }

    /// A value of row `row` from the top; 0 where it is not finite.
    pub fn row(&self, values: ArrayView1<f32>, row: usize, value: usize) -> f64 {
        finite(values[self.from + row * VALUES + value])
    }

    /// A value of column `column` from the left; 0 where it is not finite.
    pub fn column(&self, values: ArrayView1<f32>, column: usize, value: usize) -> f64 {
        finite(values[self.from + (STRIPS + column) * VALUES + value])
    }
}

/// The image's mean for what is no number.
fn finite(value: f32) -> f64 {
    if value.is_finite() { value.into() } else { 0.0 }
}

/// Evidence as a probability in (0, 1): 0 stands for one half. Never quite certain, as no detector is.
pub(super) fn probability(evidence: f64) -> f32 {
    const DOUBT: f64 = 1e-3;
    let certain = 1.0 / (1.0 + (-evidence).exp());
    certain.clamp(DOUBT, 1.0 - DOUBT) as f32
}
