//! How the window looks: a dark, neutral grey in which colours are judged well, one accent, and room around everything.

use eframe::egui::{
    self, Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Theme, Vec2, Visuals,
};

/// The one accent: of what is chosen, moved and held. A blue that people with any colour vision tell from grey.
pub const ACCENT: Color32 = Color32::from_rgb(0x5a, 0xa9, 0xe6);
/// Behind the picture: the grey of a room for judging colours, no hue at all.
pub const BEHIND: Color32 = Color32::from_gray(0x26);
/// What went wrong.
pub const WRONG: Color32 = Color32::from_rgb(0xff, 0xb0, 0x7a);
/// What is being done.
pub const QUIET: Color32 = Color32::from_gray(0x9a);

/// Side of the window's icon, px.
const ICON: u32 = 64;
/// Corners of everything that can be pressed, points.
const CORNER: u8 = 4;

/// Gives a window its looks.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.visuals = visuals();
        style.text_styles = [
            (TextStyle::Small, 11.0, FontFamily::Proportional),
            (TextStyle::Body, 13.0, FontFamily::Proportional),
            (TextStyle::Button, 13.0, FontFamily::Proportional),
            (TextStyle::Heading, 15.0, FontFamily::Proportional),
            (TextStyle::Monospace, 12.0, FontFamily::Monospace),
        ]
        .map(|(style, size, family)| (style, FontId::new(size, family)))
        .into();
        let spacing = &mut style.spacing;
        spacing.item_spacing = Vec2::new(8.0, 6.0);
        spacing.button_padding = Vec2::new(8.0, 4.0);
        // Wide enough for fingers.
        spacing.interact_size = Vec2::new(40.0, 24.0);
        spacing.menu_margin = Margin::same(6);
        spacing.window_margin = Margin::same(12);
        spacing.slider_width = 130.0;
        style.animation_time = 0.08;
    });
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    let grey = Color32::from_gray;
    visuals.panel_fill = grey(0x1e);
    visuals.window_fill = grey(0x22);
    visuals.extreme_bg_color = grey(0x14);
    visuals.faint_bg_color = grey(0x24);
    visuals.window_stroke = Stroke::new(1.0, grey(0x3a));
    visuals.window_corner_radius = CornerRadius::same(6);
    visuals.menu_corner_radius = CornerRadius::same(6);
    visuals.selection.bg_fill = ACCENT.linear_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    visuals.hyperlink_color = ACCENT;
    visuals.slider_trailing_fill = true;
    visuals.warn_fg_color = WRONG;
    visuals.error_fg_color = WRONG;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, grey(0x32));
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, grey(0xc4));
    widgets.inactive.fg_stroke = Stroke::new(1.0, grey(0xd6));
    widgets.inactive.weak_bg_fill = grey(0x2e);
    widgets.inactive.bg_fill = grey(0x36);
    widgets.hovered.weak_bg_fill = grey(0x3a);
    widgets.hovered.bg_stroke = Stroke::new(1.0, grey(0x60));
    widgets.active.weak_bg_fill = grey(0x44);
    widgets.active.bg_stroke = Stroke::new(1.0, ACCENT);
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(CORNER);
    }
    visuals
}

/// The window's icon: a ball whose hue turns towards its rim, as thin films do.
#[must_use]
pub fn icon() -> egui::IconData {
    let centre = |place: u32| 2.0 * (f64::from(place) + 0.5) / f64::from(ICON) - 1.0;
    let rgba = (0..ICON * ICON).flat_map(|pixel| {
        let (x, y) = (centre(pixel % ICON), centre(pixel / ICON));
        let radius = x.hypot(y);
        // One pixel of the rim is partly covered.
        let covered = ((1.0 - radius) * f64::from(ICON) / 2.0).clamp(0.0, 1.0);
        let hue = 0.38 + 0.4 * radius * radius + 0.06 * y;
        let light = (0.55 - 0.35 * (x + y) / 2.0).clamp(0.1, 1.0);
        let colour: Color32 = egui::ecolor::Hsva::new(hue as f32, 0.75, light as f32, 1.0).into();
        [colour.r(), colour.g(), colour.b(), (255.0 * covered).round() as u8]
    });
    egui::IconData { rgba: rgba.collect(), width: ICON, height: ICON }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surroundings_of_colours_have_none() {
        let visuals = visuals();
        for colour in [visuals.panel_fill, visuals.window_fill, visuals.extreme_bg_color, BEHIND] {
            assert!(colour.r() == colour.g() && colour.g() == colour.b(), "{colour:?}");
        }
    }

    #[test]
    fn the_icon_is_a_ball_on_nothing() {
        let icon = icon();
        assert_eq!(icon.rgba.len(), 4 * (ICON * ICON) as usize);
        let alpha = |x: u32, y: u32| icon.rgba[4 * (y * ICON + x) as usize + 3];
        assert_eq!((alpha(0, 0), alpha(ICON / 2, ICON / 2)), (0, 255));
    }
}
