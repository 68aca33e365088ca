//! Writes a map as map_server reads it.

use crate::{
    error::{Error, Result},
    mapping::{Occupancy, OccupancyMap},
    storage,
};
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding},
};
use std::path::Path;

/// Brightness of what is occupied, free and unknown, as map_server's own maps have it.
const BRIGHTNESS: [u8; 3] = [0, 254, 205];

impl OccupancyMap {
    /// Writes the map for ROS's map_server: the YAML file of this name, and beside it the picture, a PGM of the same name.
    ///
    /// ```
    /// use ballmark::mapping::{Occupancy::{Free, Occupied, Unknown}, OccupancyMap, RosMap};
    /// # let folder = tempfile::tempdir().unwrap();
    /// let map = OccupancyMap::from_cells(0.5, [-1.0, 2.0], 3, vec![Free, Occupied, Unknown, Free, Free, Free])?;
    /// let yaml = folder.path().join("cell.yaml");
    /// map.write_ros(&yaml)?;
    /// assert_eq!(RosMap::read(&yaml)?.occupancy_map()?, map);
    /// assert!(std::fs::read(yaml.with_extension("pgm")).unwrap().starts_with(b"P5"));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where one of them can't be written.
    pub fn write_ros(&self, yaml: &Path) -> Result<()> {
        let picture = yaml.with_extension("pgm");
        let [width, height] = self.size();
        let brightness = |cell: &Occupancy| match cell {
            Occupancy::Occupied => BRIGHTNESS[0],
            Occupancy::Free => BRIGHTNESS[1],
            Occupancy::Unknown => BRIGHTNESS[2],
        };
        // Pictures begin with their northernmost row.
        let rows = self.cells().chunks(width).rev();
        let pixels: Vec<u8> = rows.flatten().map(brightness).collect();
        let too_large = |_| Error::file(&picture, "more cells than a picture has; expected fewer");
        let (columns, rows) = (
            u32::try_from(width).map_err(too_large)?,
            u32::try_from(height).map_err(too_large)?,
        );
        storage::write_file(&picture, |out| {
            // Grey values alone; by itself the encoder writes PAM, which map_server doesn't read.
            let grey = PnmSubtype::Graymap(SampleEncoding::Binary);
            let encoder = PnmEncoder::new(out).with_subtype(grey);
            let encoded = encoder.write_image(&pixels, columns, rows, ExtendedColorType::L8);
            encoded.map_err(std::io::Error::other)
        })?;
        let name = picture.file_name().unwrap_or_default().to_string_lossy();
        let [x_m, y_m] = self.origin_m();
        let text = format!(
            "image: {name}\nmode: trinary\nresolution: {}\norigin: [{x_m}, {y_m}, 0]\nnegate: 0\noccupied_thresh: 0.65\n\
             free_thresh: 0.196\n",
            self.cell_m()
        );
        storage::write_file(yaml, |out| out.write_all(text.as_bytes()))
    }
}
