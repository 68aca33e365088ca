//! Pictures in files: as SVG, which is what they are, and as PNG for what can't show that.

use super::files::write_text;
use crate::{
    error::{Error, Result},
    storage,
};
use resvg::{
    tiny_skia::{Pixmap, Transform},
    usvg::{self, Options, Tree, fontdb},
};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, LazyLock},
};

/// Letters are drawn in this font, whatever the machine has: the same bytes everywhere. Signs of other scripts are left out.
static FONT: &[u8] = include_bytes!("picture/DejaVuSans-subset.ttf");

/// Pixels a unit of the drawing: sharp in print at a column's width.
const SCALE: f32 = 2.0;

static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// Writes a picture to two files, of this name and the endings `.svg` and `.png`.
///
/// # Errors
/// Where it can't be drawn, or a file can't be written.
pub(super) fn write_picture(name: &Path, svg: &str) -> Result<()> {
    let png = png(svg).map_err(|e| e.in_file(name))?; // one that can't be drawn leaves no half
    let ending = |ending: &str| {
        let mut name = name.as_os_str().to_os_string();
        name.push(ending);
        PathBuf::from(name)
    };
    write_text(&ending(".svg"), svg)?;
    storage::write_file(&ending(".png"), |out| out.write_all(&png))
}

fn png(svg: &str) -> Result<Vec<u8>> {
    let options = Options {
        font_family: "DejaVu Sans".into(),
        fontdb: Arc::clone(&FONTS),
        ..Options::default()
    };
    let fault = |why: String| Error::work(format!("picture as PNG: {why}"));
    let tree: Tree =
        usvg::Tree::from_str(svg, &options).map_err(|e: usvg::Error| fault(e.to_string()))?;
    let size = tree.size();
    let pixels = |length: f32| (SCALE * length).ceil() as u32;
    let pixmap = Pixmap::new(pixels(size.width()), pixels(size.height()));
    let mut pixmap = pixmap.ok_or_else(|| fault("it has no size".into()))?;
    let scale = Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, scale, &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|e| fault(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{Curve, Panel, framed_plot};

    /// As large as the drawing, with letters and a line in it: of a white picture neither would be left.
    #[test]
    fn a_plot_is_the_same_picture_as_png() {
        let panel = Panel {
            y_label: "error (m), ± 95 %".into(),
            curves: vec![Curve {
                name: "α".into(),
                x: vec![0.0, 1.0],
                y: vec![0.0, 1.0],
                band: None,
            }],
            y_range: None,
        };
        let svg = framed_plot("title", "distance (m)", &panel).unwrap();
        let ink = |svg: &str| {
            let image = image::load_from_memory(&png(svg).unwrap())
                .unwrap()
                .to_rgb8();
            let dark = image.pixels().filter(|p| p.0.iter().all(|&c| c < 128));
            (image.width(), dark.count())
        };
        let (width, dark) = ink(&svg);
        assert_eq!(width, 1800);
        assert!(dark > 1000, "{dark}");
        let (_, silent) = ink(&svg.replace("title", " "));
        assert!(silent < dark, "{silent} {dark}");
        assert!(png("<svg").is_err());
    }
}
