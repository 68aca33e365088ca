//! Small maps in every mode.

use super::{
    yaml::{Mode, Negate},
    *,
};
use image::RgbaImage;

fn config(mode: Mode, negate: i64) -> MapFile {
    MapFile {
        image: "map.pgm".into(),
        resolution: 0.05,
        origin: [0.0; 3],
        negate: Negate::Number(negate),
        occupied_thresh: 0.65,
        free_thresh: 0.196,
        mode,
    }
}

#[test]
fn each_mode_reads_brightness_as_map_server_does() {
    let of = |mode, negate, value: f64| config(mode, negate).of_shade(value / 255.0);
    let occupied = |mode, negate, value| of(mode, negate, value) == Occupancy::Occupied;
    for mode in [Mode::Trinary, Mode::Scale] {
        // (255 − 89) / 255 = 0.651, (255 − 90) / 255 = 0.647
        assert!(occupied(mode, 0, 0.0) && occupied(mode, 0, 89.0) && !occupied(mode, 0, 90.0));
        assert!(!occupied(mode, 0, 205.0) && !occupied(mode, 0, 254.0));
        assert!(occupied(mode, 1, 255.0) && occupied(mode, 1, 166.0) && !occupied(mode, 1, 165.0));
    }
    for (value, is) in [
        (0.0, false),
        (65.0, false),
        (66.0, true),
        (100.0, true),
        (101.0, false),
        (255.0, false),
    ] {
        assert_eq!(occupied(Mode::Raw, 0, value), is, "{value}");
        assert_eq!(occupied(Mode::Raw, 1, 255.0 - value), is, "negated {value}");
    }
}

#[test]
fn the_mode_s_name_may_have_capitals_and_full_is_occupied_in_degrees() {
    let mode = |name: &str| {
        let yaml = format!(
            "image: a\nresolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: {name}\n"
        );
        serde_saphyr::from_str::<MapFile>(&yaml).map(|file| file.mode)
    };
    assert_eq!(mode("Trinary").unwrap(), Mode::Trinary);
    assert_eq!(mode("SCALE").unwrap(), Mode::Scale);
    assert!(
        mode("grey")
            .unwrap_err()
            .to_string()
            .contains("`mode` is `grey`")
    );
    // Masks of nav2's filters have thresholds of 0 and 1.
    let mask = MapFile {
        occupied_thresh: 1.0,
        free_thresh: 0.0,
        ..config(Mode::Scale, 0)
    };
    assert_eq!(mask.of_shade(0.0), Occupancy::Occupied);
    assert_eq!(mask.of_shade(0.1), Occupancy::Unknown);
}

#[test]
fn transparency_is_one_more_colour_in_the_trinary_mode_alone() {
    let cells = |mode, rgba: [u8; 4]| {
        let picture = RgbaImage::from_pixel(1, 1, image::Rgba(rgba));
        config(mode, 0).cells(&picture.into())[(0, 0)] == Occupancy::Occupied
    };
    // Opaque black: (0 + 0 + 0 + 255) / 4 = 63.75, 0.75 occupied; dark grey 60: 108.75, 0.57.
    assert!(cells(Mode::Trinary, [0, 0, 0, 255]) && cells(Mode::Scale, [0, 0, 0, 255]));
    assert!(!cells(Mode::Trinary, [60, 60, 60, 255]) && cells(Mode::Scale, [60, 60, 60, 255]));
    // Black that shows through: (0 + 0 + 0 + 0) / 4 in the one mode, unknown in the other.
    assert!(cells(Mode::Trinary, [0, 0, 0, 0]) && !cells(Mode::Scale, [0, 0, 0, 0]));
}

#[test]
fn what_lies_between_the_thresholds_is_unknown() {
    let of = |mode, value: f64| config(mode, 0).of_shade(value / 255.0);
    for mode in [Mode::Trinary, Mode::Scale] {
        // (255 − 205) / 255 = 0.1961, not below 0.196; (255 − 206) / 255 = 0.192
        assert_eq!(of(mode, 205.0), Occupancy::Unknown);
        assert_eq!(of(mode, 206.0), Occupancy::Free);
        assert_eq!(of(mode, 90.0), Occupancy::Unknown);
    }
    assert_eq!(of(Mode::Raw, 19.0), Occupancy::Free);
    assert_eq!(of(Mode::Raw, 20.0), Occupancy::Unknown);
    assert_eq!(of(Mode::Raw, 101.0), Occupancy::Unknown);
}

/// An L of occupied cells in the lower left: two in the lowest row, one above the left one; the one above the right is unknown.
fn map(origin: &str) -> OccupancyMap {
    let folder = tempfile::tempdir().unwrap();
    let picture = "P2\n3 3\n255\n254 254 254\n0 254 205\n0 0 254\n";
    std::fs::write(folder.path().join("map.pgm"), picture).unwrap();
    let file = folder.path().join("map.yaml");
    let yaml = format!(
        "image: map.pgm\nresolution: 0.5\norigin: {origin}\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
    std::fs::write(&file, yaml).unwrap();
    RosMap::read(&file).unwrap().occupancy_map().unwrap()
}

#[test]
fn cells_lie_where_the_origin_says() {
    use Occupancy::{Free, Occupied, Unknown};
    let straight = map("[1.0, 2.0, 0.0]");
    assert_eq!((straight.size(), straight.origin_m()), ([3, 3], [1.0, 2.0]));
    assert_eq!(
        straight.cells(),
        [
            Occupied, Occupied, Free, Occupied, Free, Unknown, Free, Free, Free
        ]
    );
    // Turned by a quarter about the origin: x to y, y to −x.
    let turned = map("[1.0, 2.0, 1.5707963267948966]");
    assert_eq!(turned.size(), [3, 3]);
    assert!((turned.origin_m()[0] + 0.5).abs() < 1e-9 && (turned.origin_m()[1] - 2.0).abs() < 1e-9);
    assert_eq!(
        turned.cells(),
        [
            Free, Occupied, Occupied, Free, Free, Occupied, Free, Unknown, Free
        ]
    );
    // By an eighth: no wall is lost; its bounds hold all corners, outside nothing is known.
    let eighth = map("[0.0, 0.0, 0.7853981633974483]");
    let half = 0.5f64.sqrt();
    for own in [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75]] {
        let [x, y] = [half * (own[0] - own[1]), half * (own[0] + own[1])];
        assert_eq!(eighth.at(x, y), Occupied, "{own:?}");
    }
    assert_eq!(eighth.at(-1.0, 0.1), Unknown);
    assert!((eighth.origin_m()[0] + 1.5 * half).abs() < 1e-9);
}
