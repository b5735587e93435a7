//! The help: what keys, mouse and fingers do, drawn from the tables that are obeyed.

use eframe::egui::{Context, Grid, RichText, ScrollArea, Ui, Window};

use super::keys::{HANDS, ROWS};

/// Draws the help where it is open.
pub(super) fn help(ctx: &Context, is_open: &mut bool) {
    Window::new("Keys, mouse and touch").open(is_open).collapsible(false).default_width(460.0).show(
        ctx,
        |ui| {
            ScrollArea::vertical().max_height(ctx.content_rect().height() * 0.75).show(ui, |ui| {
                ui.label(RichText::new("On the picture").strong());
                table(ui, "hands", HANDS.iter().copied());
                ui.add_space(8.0);
                ui.label(RichText::new("Keys").strong());
                table(ui, "keys", ROWS.iter().map(|row| (row.keys, row.does)));
            });
        },
    );
}

fn table(ui: &mut Ui, name: &str, rows: impl Iterator<Item = (&'static str, &'static str)>) {
    Grid::new(name).num_columns(2).spacing([16.0, 4.0]).striped(true).show(ui, |ui| {
        for (what, does) in rows {
            ui.label(RichText::new(what).monospace());
            ui.label(does);
            ui.end_row();
        }
    });
}
