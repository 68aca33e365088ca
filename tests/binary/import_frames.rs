//! `ballmark import` of camera frames beside a table of poses.

use crate::support::Workplace;
use ballmark::recording::{
    image::{Image, features},
    npz,
};

const HEADER: &str = "time_s,x_m,y_m,heading_rad,light,frame\n";

/// A picture of 120 × 128 pixels whose brightness grows to the right, from a grey of `dark`.
fn picture(dark: u8) -> Image {
    let pixels = (0..120).flat_map(|_| (0..128_u8).map(|column| dark.saturating_add(column)));
    let rgb = pixels.flat_map(|grey| [grey, grey / 2, 20]).collect();
    Image::new(120, 128, rgb).unwrap()
}

fn png(dark: u8) -> Vec<u8> {
    picture(dark).to_png().unwrap()
}

/// A header that declares more pixels than any memory holds; only its checksum is right.
fn gigantic() -> Vec<u8> {
    let mut file = png(0);
    file[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let mut sum = flate2::Crc::new();
    sum.update(&file[12..29]);
    file[29..33].copy_from_slice(&sum.sum().to_be_bytes());
    file
}

#[test]
fn frames_become_the_channel_camera() {
    let place = Workplace::new();
    std::fs::create_dir_all(place.path("walk/frames")).unwrap();
    place.write("walk/frames/a.png", png(0));
    place.write("walk/frames/b.png", png(90));
    let rows = "0,0,0,0,7,frames/a.png\n1,1,0,0,8,frames/b.png\n2,2,0,0,9,\n";
    place.write("walk/poses.csv", format!("{HEADER}{rows}"));
    // Names start from the table's folder, wherever the command is called.
    let call = ["import", "walk/poses.csv", "-o", "walk.npz"];
    place.ballmark(&call).done();
    let dataset = npz::read(&place.path("walk.npz")).unwrap();
    let channels: Vec<_> = dataset
        .channels()
        .iter()
        .map(|c| (c.name.as_str(), c.width))
        .collect();
    assert_eq!(channels, [("light", 1), ("camera", 140)]);
    for (row, dark) in [(0, 0), (1, 90)] {
        let values: Vec<f32> = dataset.values().row(row).iter().skip(1).copied().collect();
        assert_eq!(values, features(&picture(dark)), "row {row}");
    }
    // No picture, no values.
    assert_eq!(dataset.values()[[2, 0]], 9.0);
    assert!(dataset.values().row(2).iter().skip(1).all(|v| v.is_nan()));
}

#[test]
fn each_frame_that_cannot_be_read_is_named_and_its_row_dropped() {
    let place = Workplace::new();
    let whole = png(3);
    place.write("good.png", &whole);
    place.write("half.png", &whole[..whole.len() / 2]);
    place.write("text.png", "time_s,x_m\n");
    place.write("empty.jpg", "");
    place.write("giant.png", gigantic());
    let names = [
        "good.png",
        "half.png",
        "text.png",
        "empty.jpg",
        "giant.png",
        "gone.png",
        ".",
    ];
    for (name, part) in names.into_iter().zip([
        "",
        "`half.png` is a broken picture",
        "`text.png` is not a picture",
        "`empty.jpg` is empty",
        "`giant.png`",
        "`gone.png` cannot be read",
        "`.` is no ordinary file",
    ]) {
        let rows = format!("0,0,0,0,7,good.png\n1,1,0,0,8,{name}\n2,2,0,0,9,good.png\n");
        place.write("poses.csv", format!("{HEADER}{rows}"));
        let answer = place.ballmark(&["import", "poses.csv", "-o", "walk.npz", "--json"]);
        if name == "good.png" {
            answer.done();
            continue;
        }
        assert_eq!(answer.status, 3, "{name}: {}", answer.stderr);
        let lines = answer.stderr.lines();
        let told: Vec<&str> = lines.filter(|line| !line.starts_with("note: ")).collect();
        assert_eq!(told.len(), 1, "{told:?}");
        for part in ["dropped: line 3: frame ", part, "expected"] {
            assert!(
                told[0].contains(part),
                "`{part}` is missing in: {}",
                told[0]
            );
        }
        assert_eq!(npz::read(&place.path("walk.npz")).unwrap().len(), 2);
    }
}

#[test]
fn without_a_single_frame_nothing_is_written() {
    let place = Workplace::new();
    place.write("poses.csv", format!("{HEADER}0,0,0,0,7,gone.png\n"));
    let answer = place.ballmark(&["import", "poses.csv", "-o", "walk.npz"]);
    answer.refused(1, &["poses.csv", "line 2", "gone.png"]);
    assert_eq!(place.files(), ["poses.csv"]);
}

#[test]
fn a_column_of_frame_numbers_is_a_sensor_as_ever() {
    let place = Workplace::new();
    place.write("poses.csv", format!("{HEADER}0,0,0,0,7,\n1,1,0,0,7,12\n"));
    place
        .ballmark(&["import", "poses.csv", "-o", "walk.npz"])
        .done();
    let dataset = npz::read(&place.path("walk.npz")).unwrap();
    assert_eq!(dataset.channels()[1].name, "frame");
    assert_eq!(dataset.values()[[1, 1]], 12.0);
}

#[test]
fn two_columns_of_frames_and_a_camera_besides_are_refused() {
    let place = Workplace::new();
    place.write("a.png", png(0));
    place.write(
        "two.csv",
        "time_s,x_m,y_m,heading_rad,frame,image\n0,0,0,0,a.png,a.png\n",
    );
    let answer = place.ballmark(&["import", "two.csv", "-o", "two.npz"]);
    answer.refused(1, &["two.csv: line 1", "`frame` and `image`"]);
    place.write(
        "camera.csv",
        "time_s,x_m,y_m,heading_rad,camera,frame\n0,0,0,0,5,a.png\n",
    );
    let answer = place.ballmark(&["import", "camera.csv", "-o", "two.npz"]);
    answer.refused(1, &["camera.csv", "`camera`", "two channels"]);
}
