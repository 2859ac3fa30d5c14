//! Colours: perceptual maps and the sRGB transfer function.

use crate::math::Vec3;

/// Colour (sRGB) of obstacles, because rods must stand out before them.
pub(in crate::io) const PALE: [u8; 3] = [196, 201, 210];

/// A colour map from 0 to 1 (values of matplotlib's maps of the same name, Smith & van der Walt 2015; Moreland 2009).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Palette {
    /// Dark violet, green, yellow: for amounts.
    #[default]
    Viridis,
    /// Dark blue, magenta, yellow: for amounts.
    Plasma,
    /// Blue, grey, red: for signed quantities.
    CoolWarm,
}

const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 45, 123],
    [59, 82, 139],
    [44, 114, 142],
    [33, 145, 140],
    [40, 174, 128],
    [94, 201, 98],
    [173, 220, 48],
    [253, 231, 37],
];
const PLASMA: [[u8; 3]; 9] = [
    [13, 8, 135],
    [76, 2, 161],
    [126, 3, 168],
    [170, 35, 149],
    [204, 71, 120],
    [230, 108, 92],
    [248, 149, 64],
    [253, 197, 39],
    [240, 249, 33],
];
const COOL_WARM: [[u8; 3]; 9] = [
    [59, 76, 192],
    [98, 130, 234],
    [141, 176, 254],
    [185, 208, 249],
    [221, 220, 220],
    [245, 196, 172],
    [244, 152, 122],
    [221, 95, 75],
    [180, 4, 38],
];

impl Palette {
    /// Colour (sRGB) at `x`, clamped to [0, 1]; NaN is grey.
    pub fn color(self, x: f64) -> [u8; 3] {
        if x.is_nan() {
            return [150, 150, 150];
        }
        let table = match self {
            Self::Viridis => &VIRIDIS,
            Self::Plasma => &PLASMA,
            Self::CoolWarm => &COOL_WARM,
        };
        let place = x.clamp(0.0, 1.0) * (table.len() - 1) as f64;
        let index = (place as usize).min(table.len() - 2);
        let u = place - index as f64;
        let mix =
            |k: usize| (f64::from(table[index][k]) * (1.0 - u) + f64::from(table[index + 1][k]) * u).round() as u8;
        [mix(0), mix(1), mix(2)]
    }
}

/// Colours of a list of values, `range` (lowest and highest, or the values' own if `None`) spread over the palette.
///
/// A single value, or a range of no width, takes the palette's middle; values outside are clamped, NaN is grey.
pub fn colors_by_value(values: &[f64], palette: Palette, range: Option<(f64, f64)>) -> Vec<[u8; 3]> {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let own = || (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    let (low, high) = range.unwrap_or_else(own);
    let place = |v: f64| if high > low || v.is_nan() { (v - low) / (high - low) } else { 0.5 };
    values.iter().map(|&v| palette.color(place(v))).collect()
}

/// sRGB → linear light.
pub(in crate::io) fn linear(color: [u8; 3]) -> Vec3 {
    let channel = |c: u8| {
        let v = f64::from(c) / 255.0;
        if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    Vec3::new(channel(color[0]), channel(color[1]), channel(color[2]))
}

/// Linear light → sRGB.
pub(super) fn encoded(light: Vec3) -> [u8; 3] {
    let channel = |v: f64| {
        let v = v.clamp(0.0, 1.0);
        let s = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (255.0 * s).round() as u8
    };
    [channel(light.x), channel(light.y), channel(light.z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_function_is_its_inverse() {
        for c in 0..=255 {
            assert_eq!(encoded(linear([c, 255 - c, c / 2])), [c, 255 - c, c / 2]);
        }
    }

    #[test]
    fn values_spread_over_the_palette() {
        let colors = colors_by_value(&[2.0, f64::NAN, 4.0, 3.0], Palette::Viridis, None);
        assert_eq!(colors, [[68, 1, 84], [150, 150, 150], [253, 231, 37], [33, 145, 140]]);
        assert_eq!(colors_by_value(&[7.0], Palette::CoolWarm, None), [[221, 220, 220]]);
        assert_eq!(colors_by_value(&[9.0], Palette::Plasma, Some((0.0, 1.0))), [[240, 249, 33]]);
    }
}
