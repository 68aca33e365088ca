//! Small maps, and their walls.

use super::*;
use image::{DynamicImage, GrayImage, ImageFormat};
use nalgebra::Point2;
use std::io::Cursor;

/// A map in a folder of its own, and its walls or why there are none.
fn read(yaml: &str, files: &[(&str, Vec<u8>)]) -> Result<Vec<Wall>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).unwrap();
    }
    let file = folder.path().join("map.yaml");
    std::fs::write(&file, yaml).unwrap();
    walls(&file, Material::PLAIN)
}

/// What sensors see of it, without the bound around the free.
fn seen(walls: Vec<Wall>) -> Vec<Wall> {
    walls
        .into_iter()
        .filter(|wall| wall.stands_at(0.1))
        .collect()
}

const YAML: &str = "image: map.pgm\nresolution: 0.5\norigin: [1.0, 2.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
/// An L of occupied cells in the lower left: two in the lowest row, one above the left one.
const L: &[u8] = b"P2\n3 3\n255\n254 254 254\n0 254 205\n0 0 254\n";

fn has(walls: &[Wall], from: [f64; 2], to: [f64; 2]) -> bool {
    let at = |a: Point2<f64>, b: [f64; 2]| (a - Point2::from(b)).norm() < 1e-9;
    walls
        .iter()
        .any(|wall| at(wall.from, from) && at(wall.to, to))
}

#[test]
fn the_outline_is_made_of_straight_walls_where_the_origin_says() {
    let walls = seen(read(YAML, &[("map.pgm", L.to_vec())]).unwrap());
    assert_eq!(walls.len(), 6);
    for (from, to) in [
        ([1.0, 2.0], [2.0, 2.0]), // below, two cells in one
        ([1.5, 2.5], [2.0, 2.5]),
        ([1.0, 3.0], [1.5, 3.0]),
        ([1.0, 2.0], [1.0, 3.0]), // left, two cells in one
        ([1.5, 2.5], [1.5, 3.0]),
        ([2.0, 2.0], [2.0, 2.5]),
    ] {
        assert!(has(&walls, from, to), "{from:?} to {to:?} in {walls:?}");
    }
    // Turned by a quarter about the origin: x to y, y to −x.
    let turned = YAML.replace("0.0]", "1.5707963267948966]");
    let walls = read(&turned, &[("map.pgm", L.to_vec())]).unwrap();
    assert!(has(&walls, [1.0, 2.0], [1.0, 3.0]) && has(&walls, [1.0, 2.0], [0.0, 2.0]));
}

#[test]
fn png_and_binary_pgm_and_sixteen_bits_say_the_same() {
    let expected = read(YAML, &[("map.pgm", L.to_vec())]).unwrap();
    let grey = GrayImage::from_raw(3, 3, vec![254, 254, 254, 0, 254, 205, 0, 0, 254]).unwrap();
    let encoded = |picture: DynamicImage, format| {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    };
    for picture in [
        encoded(grey.clone().into(), ImageFormat::Pnm),
        encoded(grey.clone().into(), ImageFormat::Png),
        encoded(
            DynamicImage::from(grey.clone()).to_luma16().into(),
            ImageFormat::Png,
        ),
        encoded(
            DynamicImage::from(grey.clone()).to_rgb8().into(),
            ImageFormat::Png,
        ),
        encoded(DynamicImage::from(grey).to_rgb8().into(), ImageFormat::Bmp),
    ] {
        assert_eq!(read(YAML, &[("map.pgm", picture)]).unwrap(), expected);
    }
}

#[test]
fn a_bound_that_no_sensor_sees_keeps_the_robot_where_the_floor_is_known() {
    let walls = read(YAML, &[("map.pgm", L.to_vec())]).unwrap();
    let bound: Vec<Wall> = walls
        .into_iter()
        .filter(|wall| !wall.stands_at(0.1))
        .collect();
    for (from, to) in [
        ([2.0, 2.0], [2.5, 2.0]), // below, where the lowest row is free
        ([1.0, 3.5], [2.5, 3.5]), // above
        ([1.0, 3.0], [1.0, 3.5]), // left
        ([2.0, 2.5], [2.5, 2.5]), // around the unknown cell
        ([2.0, 3.0], [2.5, 3.0]),
        ([2.0, 2.5], [2.0, 3.0]),
        ([2.5, 2.0], [2.5, 2.5]), // right, but for the unknown cell
        ([2.5, 3.0], [2.5, 3.5]),
    ] {
        assert!(has(&bound, from, to), "{from:?} to {to:?} in {bound:?}");
    }
    assert_eq!(bound.len(), 8);
}

#[test]
fn a_photograph_is_refused_before_it_fills_the_memory() {
    let speckled = GrayImage::from_fn(1500, 1500, |x, y| {
        image::Luma([if x % 2 == 0 && y % 2 == 0 { 0 } else { 254 }])
    });
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::from(speckled)
        .write_to(&mut bytes, ImageFormat::Pnm)
        .unwrap();
    let error = read(YAML, &[("map.pgm", bytes.into_inner())]).unwrap_err();
    assert!(
        error.to_string().contains("more than 1000000 edges"),
        "{error}"
    );
}

#[test]
fn the_greatest_value_of_a_pgm_counts_as_white() {
    let dim = b"P2\n3 3\n100\n100 100 100\n0 100 80\n0 0 100\n".to_vec();
    assert_eq!(seen(read(YAML, &[("map.pgm", dim)]).unwrap()).len(), 6);
}

#[test]
fn each_fault_is_told_in_one_line_with_its_file() {
    let good = || vec![("map.pgm", L.to_vec())];
    let with = |from: &str, to: &str| YAML.replace(from, to);
    for (yaml, files, expected) in [
        (YAML.to_string(), vec![], "map.pgm: cannot read"),
        (
            YAML.to_string(),
            vec![("map.pgm", b"no picture".to_vec())],
            "map.pgm: ",
        ),
        (
            YAML.to_string(),
            vec![("map.pgm", L[..20].to_vec())],
            "map.pgm: ",
        ),
        (YAML.to_string(), vec![("map.pgm", vec![])], "map.pgm: "),
        (
            YAML.to_string(),
            vec![("map.pgm", b"P5 60000 60000 255\n".to_vec())],
            "map.pgm: 60000 × 60000 cells",
        ),
        (
            YAML.to_string(),
            vec![("map.pgm", b"P2 1 1 255\n254\n".to_vec())],
            "no cell is occupied",
        ),
        (
            with("resolution: 0.5", "resolution: 0"),
            good(),
            "`resolution`: is 0",
        ),
        (
            with("resolution: 0.5", "resolution: .nan"),
            good(),
            "`resolution`",
        ),
        (with("resolution: 0.5\n", ""), good(), "resolution"),
        (with("negate: 0", "negate: 7"), good(), "`negate`: is 7"),
        (
            with("free_thresh: 0.196", "free_thresh: 0.7"),
            good(),
            "`free_thresh`: is 0.7",
        ),
        (with("[1.0, 2.0, 0.0]", "[1.0, 2.0]"), good(), "map.yaml: "),
        (
            with("[1.0, 2.0, 0.0]", "[1.0, .inf, 0.0]"),
            good(),
            "`origin`: is inf in y",
        ),
        (
            with("[1.0, 2.0, 0.0]", "[1.0, 2.0, -nan]"),
            good(),
            "`origin`: is NaN in yaw",
        ),
        (
            with("[1.0, 2.0, 0.0]", "[1.0, 2.0, east]"),
            good(),
            "`origin`: the yaw is `east`",
        ),
        (
            with("map.pgm", "/home/somebody/map.pgm"),
            good(),
            "(os error 2); `map.pgm` lies beside",
        ),
        (format!("{YAML}mode: quaternary\n"), good(), "map.yaml: "),
        ("[".to_string(), good(), "map.yaml: "),
    ] {
        let error = read(&yaml, &files).unwrap_err();
        let line = error.to_string();
        assert!(
            line.contains(expected) && !line.contains('\n'),
            "{expected}: {line}"
        );
        assert!(!error.is_usage(), "{line}");
    }
}
