//! Colours and spacing, dark and light. The surroundings of a picture are neutral, so that they do not tint its
//! appearance.

use eframe::egui::{self, Color32, CornerRadius, Stroke, Theme, Visuals, vec2};

/// The selection colour, in both themes.
pub(super) const ACCENT: Color32 = Color32::from_rgb(232, 146, 36);

/// Returns the colour around the picture.
pub(super) const fn surroundings(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_gray(38) } else { Color32::from_gray(150) }
}

/// Returns the colour behind a transparent picture.
pub(super) const fn backdrop(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode { Color32::from_gray(62) } else { Color32::from_gray(178) }
}

/// Installs both themes.
pub(super) fn install(ctx: &egui::Context) {
    ctx.set_visuals_of(Theme::Dark, dark());
    ctx.set_visuals_of(Theme::Light, light());
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = vec2(6.0, 5.0);
        style.spacing.button_padding = vec2(7.0, 3.0);
        style.spacing.interact_size.y = 22.0;
        style.spacing.slider_width = 110.0;
        // The edges of panels are caught from this far.
        style.interaction.resize_grab_radius_side = 7.0;
    });
}

/// Returns the dark theme.
pub(super) fn dark() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = Color32::from_gray(30);
    visuals.window_fill = Color32::from_gray(36);
    visuals.extreme_bg_color = Color32::from_gray(20);
    visuals.faint_bg_color = Color32::from_gray(36);
    visuals.weak_text_color = Some(Color32::from_gray(156));
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(50));
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(188));
    visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_gray(208));
    visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(48);
    visuals.widgets.inactive.bg_fill = Color32::from_gray(56);
    common(&mut visuals);
    visuals.selection.bg_fill = Color32::from_rgb(122, 74, 14);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(255, 232, 200));
    visuals
}

/// Returns the light theme.
pub(super) fn light() -> Visuals {
    let mut visuals = Visuals::light();
    visuals.panel_fill = Color32::from_gray(238);
    visuals.window_fill = Color32::from_gray(246);
    visuals.faint_bg_color = Color32::from_gray(228);
    visuals.weak_text_color = Some(Color32::from_gray(88));
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(208));
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, Color32::from_gray(56));
    visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, Color32::from_gray(40));
    visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(218);
    visuals.widgets.inactive.bg_fill = Color32::from_gray(206);
    common(&mut visuals);
    visuals.selection.bg_fill = Color32::from_rgb(250, 205, 140);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(70, 38, 0));
    visuals
}

fn common(visuals: &mut Visuals) {
    let round = CornerRadius::same(4);
    let widgets = &mut visuals.widgets;
    for widget in [&mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open] {
        widget.corner_radius = round;
    }
    visuals.hyperlink_color = ACCENT;
    visuals.indent_has_left_vline = false;
}

/// Returns the colour of a stretch factor: 1 is blue, 2.5 and above red.
pub(super) fn heat(stretch: f64) -> Color32 {
    let t = ((stretch - 1.0).clamp(0.0, 1.5) / 1.5) as f32;
    let channel =
        |a: f32, b: f32, c: f32| (if t < 0.5 { a + (b - a) * 2.0 * t } else { b + (c - b) * (2.0 * t - 1.0) }) as u8;
    Color32::from_rgb(channel(60.0, 250.0, 230.0), channel(140.0, 220.0, 40.0), channel(220.0, 60.0, 30.0))
}
