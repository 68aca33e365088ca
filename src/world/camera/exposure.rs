//! From light to pixels: blooming, noise, and 255 steps.

use super::{config::CameraConfig, trace::Light};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// Steps of the scale above black.
const FULL: f64 = 255.0;

/// The values of an image, `[row, column, colour]`, from the light along its rays.
pub(super) fn exposed(config: &CameraConfig, rays: &[Light], random: &mut impl Rng) -> Vec<u8> {
    let mut pixels = pixels(config, rays);
    bloom(config, &mut pixels);
    let levels = pixels.iter().flatten();
    levels.map(|share| level(config, *share, random)).collect()
}

/// Each pixel the mean of its rays, as a share of the full scale.
fn pixels(config: &CameraConfig, rays: &[Light]) -> Vec<Light> {
    let side = config.samples;
    let scale = config.exposure / (side * side) as f64;
    let mut pixels = vec![[0.0; 3]; config.rows * config.columns];
    for (index, light) in rays.iter().enumerate() {
        let (row, column) = (
            index / (config.columns * side),
            index % (config.columns * side),
        );
        let pixel = &mut pixels[row / side * config.columns + column / side];
        (0..3).for_each(|c| pixel[c] += scale * light[c]);
    }
    pixels
}

/// Some of the light past the full scale spills over, fading by a factor e every `bloom_pixels`.
fn bloom(config: &CameraConfig, pixels: &mut [Light]) {
    if config.bloom == 0.0 || pixels.iter().flatten().all(|share| *share <= 1.0) {
        return;
    }
    let mut spilt: Vec<Light> = pixels
        .iter()
        .map(|pixel| pixel.map(|share| (share - 1.0).max(0.0)))
        .collect();
    let kept = (-1.0 / config.bloom_pixels).exp();
    let (rows, columns) = (config.rows, config.columns);
    (0..rows).for_each(|row| spread(&mut spilt, row * columns, 1, columns, kept));
    (0..columns).for_each(|column| spread(&mut spilt, column, columns, rows, kept));
    for (pixel, spilt) in pixels.iter_mut().zip(spilt) {
        (0..3).for_each(|c| pixel[c] += config.bloom * spilt[c]);
    }
}

/// Spreads a line of pixels to both sides; of an endless line the sum stays.
fn spread(pixels: &mut [Light], first: usize, step: usize, count: usize, kept: f64) {
    let place = |index: usize| first + index * step;
    let mut pass = |order: &mut dyn Iterator<Item = usize>| {
        let mut carried = [0.0; 3];
        for index in order {
            let pixel = &mut pixels[place(index)];
            for c in 0..3 {
                carried[c] = kept * carried[c] + (1.0 - kept) * pixel[c];
            }
            *pixel = carried;
        }
    };
    pass(&mut (0..count));
    pass(&mut (0..count).rev());
}

/// The step that a share of the full scale is read as: normal noise whose variance is that of the electronics plus that
/// of the electrons' number.
fn level(config: &CameraConfig, share: f64, random: &mut impl Rng) -> u8 {
    let normal: f64 = random.sample(StandardNormal);
    let shot = FULL * FULL * share.min(1.0) / config.full_well;
    let deviation = (config.read_noise * config.read_noise + shot).sqrt();
    // Rust's `as` ends at 0 and 255.
    (FULL * share + deviation * normal).round() as u8
}
