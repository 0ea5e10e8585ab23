//! The font that the program carries: a machine may have none.

use plotters::style::{
    FontStyle, FontTransform, IntoFont as _, TextStyle, register_font,
    text_anchor::{HPos, Pos, VPos},
};
use plotters_backend::BackendColor;
use std::sync::Once;

/// DejaVu Sans 2.37; `src/assets/DejaVuSans-LICENSE.txt`.
static DEJAVU_SANS: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");

/// Where a text hangs on its anchor point.
#[derive(Clone, Copy)]
pub(crate) enum Hang {
    /// The point is at the middle of its top.
    Below,
    /// The point is at its left end, half way up.
    Right,
    /// The point is at its right end, half way up.
    Left,
    /// Turned to read upwards; the point is at its middle.
    Upwards,
}

/// Makes the font known to plotters, once.
fn register() {
    static REGISTER: Once = Once::new();
    REGISTER.call_once(|| {
        // A failure shows as an error of the first text that is drawn.
        let _ = register_font("sans-serif", FontStyle::Normal, DEJAVU_SANS);
    });
}

/// A style of `size` pixels for plotters.
pub(crate) fn style(size: f64, color: [u8; 3], hang: Hang) -> TextStyle<'static> {
    register();
    let (h, v) = match hang {
        Hang::Below => (HPos::Center, VPos::Top),
        Hang::Right => (HPos::Left, VPos::Center),
        Hang::Left => (HPos::Right, VPos::Center),
        Hang::Upwards => (HPos::Center, VPos::Center),
    };
    let turn = match hang {
        Hang::Upwards => FontTransform::Rotate270,
        _ => FontTransform::None,
    };
    let [r, g, b] = color;
    let font = ("sans-serif", size).into_font().transform(turn);
    let mut style = TextStyle::from(font).pos(Pos::new(h, v));
    style.color = BackendColor { alpha: 1.0, rgb: (r, g, b) };
    style
}

/// Width of a text in pixels.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    register();
    let font = ("sans-serif", size).into_font();
    // Without a font nothing is drawn anyway; drawing reports it.
    font.box_size(text).map_or(0.0, |(w, _)| f64::from(w))
}
