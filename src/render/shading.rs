//! Lighting: a key light from the upper left, a fill light from the right, and a sky that is brighter above, all
//! white and fixed to the camera, on a nearly Lambertian surface.
//!
//! The lights wrap around the surface and fade quadratically, ((n.l + c) / (1 + c))^2, so that their borders do not
//! show as bands; they add up to less than one, so that nothing is clipped. A faint highlight gives shape to black
//! regions. All computations are in linear light; sRGB is IEC 61966-2-1.

use std::sync::LazyLock;

use nalgebra::Vector3;

const KEY: Vector3<f32> = Vector3::new(-0.42, 0.55, 0.722);
const FILL: Vector3<f32> = Vector3::new(0.75, 0.05, 0.66);
/// Halfway between the key light and the viewer.
const HIGHLIGHT: Vector3<f32> = Vector3::new(-0.226, 0.296, 0.928);

/// The light that a surface with a given normal reflects to the viewer.
#[derive(Clone, Copy)]
pub(super) struct Light {
    /// The factor on the surface's color.
    diffuse: f32,
    /// White added to it.
    highlight: f32,
}

impl Light {
    /// Colors unchanged.
    pub const NONE: Light = Light { diffuse: 1.0, highlight: 0.0 };

    /// The light for a normal of any length, in the camera's axes.
    #[inline(always)]
    pub fn on(normal: Vector3<f32>) -> Self {
        let squared = normal.norm_squared();
        let normal = if squared > 0.0 { normal / squared.sqrt() } else { normal };
        let lamp = |direction: Vector3<f32>| {
            let wrap = 0.35;
            ((normal.dot(&direction) + wrap) / (1.0 + wrap)).max(0.0).powi(2)
        };
        let sky = 0.5 + 0.5 * normal.y;
        Light {
            diffuse: 0.20 + 0.12 * sky + 0.64 * lamp(KEY) + 0.18 * lamp(FILL),
            highlight: 0.035 * normal.dot(&HIGHLIGHT).max(0.0).powi(24),
        }
    }

    #[inline(always)]
    pub fn reflected(self, color: Vector3<f32>) -> Vector3<f32> {
        color * self.diffuse + Vector3::repeat(self.highlight)
    }
}

pub(super) fn linear_from_srgb(color: [f64; 3]) -> [f32; 3] {
    color.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
}

/// Levels of linear light; the darkest ones differ by a fifth of an sRGB level.
const LINEAR_LEVELS: usize = 1 << 14;

/// The sRGB byte of each level.
static SRGB_BYTES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let byte = |i: usize| {
        let c = i as f64 / LINEAR_LEVELS as f64;
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    };
    (0..=LINEAR_LEVELS).map(byte).collect()
});

#[inline(always)]
pub(super) fn srgb_from_linear(color: [f32; 3]) -> [u8; 3] {
    let bytes = &*SRGB_BYTES;
    color.map(|c| bytes[(c.clamp(0.0, 1.0) * LINEAR_LEVELS as f32 + 0.5) as usize])
}
