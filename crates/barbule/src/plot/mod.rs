//! Figures from data: SVG and PNG.
