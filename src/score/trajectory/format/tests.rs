use super::*;

fn format_of(text: &str) -> Result<Format> {
    Format::of_content("t".as_ref(), text.as_bytes())
}

fn read(format: Format, text: &str) -> Result<Trajectory> {
    format.read_bytes("t".as_ref(), text.as_bytes())
}

#[test]
fn content_tells_its_format() {
    for (text, format) in [
        ("# stamp\n\n0 1 2 3 0 0 0 1\n", Format::Tum),
        ("0\t1\t2\t3\t0\t0\t0\t1\r\n", Format::Tum),
        ("1 0 0 5 0 1 0 6 0 0 1 7\n", Format::Kitti),
        ("\u{feff}stamp,x,y,yaw\n", Format::Csv),
        ("x_m;y_m;heading_deg\n", Format::Csv),
        ("VERTEX_SE2 0 1 2 0.5\n", Format::Graph),
        ("PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n", Format::Graph),
    ] {
        assert_eq!(format_of(text).unwrap(), format, "{text}");
    }
    for (text, part) in [
        ("", "is empty"),
        ("# only\n", "is empty"),
        ("0 1 2\n", "line 1: 3 words"),
        ("\n0,1,2,3,0,0,0,1\n", "line 2: 1 word"),
        ("a\0b\n", "zero byte"),
    ] {
        let error = format_of(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn one_walk_reads_alike_in_every_format() {
    let half = 0.5f64.sqrt();
    let tum = format!("1.5 1 2 0.5 0 0 {half} {half}\n2 3 4 0 0 0 0 2e0\n");
    let tum = tum.replace("2e0", "1");
    let kitti = "0 -1 0 1 1 0 0 2 0 0 1 0.5\n1 0 0 3 0 1 0 4 0 0 1 0\n";
    let csv = "note,stamp,z,y,x,yaw\na,1.5,0.5,2,1,1.5707963267948966\nb,2,0,4,3,0\n";
    let degrees = "time_s;x_m;y_m;z_m;heading_deg\n1.5;1;2;0.5;90\n2;3;4;0;0\n";
    let expected = read(Format::Tum, &tum).unwrap();
    assert_eq!(expected.stamps(), Some(&[1.5, 2.0][..]));
    for (format, text) in [
        (Format::Kitti, kitti),
        (Format::Csv, csv),
        (Format::Csv, degrees),
    ] {
        let read = read(format, text).unwrap();
        for (pose, expected) in read.poses().iter().zip(expected.poses()) {
            assert!((pose.position_m - expected.position_m).norm() < 1e-15);
            assert!((pose.rotation - expected.rotation).norm() < 1e-15, "{text}");
        }
        assert_eq!(read.stamps().is_some(), format == Format::Csv);
    }
}

#[test]
fn a_graph_s_vertices_come_in_the_order_of_their_numbers() {
    let text = "VERTEX_SE2 7 1 2 0.5\nEDGE_SE2 0 7 1 0 0 1 0 0 1 0 1\nVERTEX2 0 3 4 -0.5\n\
                VERTEX_SE3:QUAT 9 5 6 7 0 0 0 1\nROBOTLASER1 0 1 2\nFIX 0\n";
    let graph = read(Format::Graph, text).unwrap();
    let places: Vec<f64> = graph.poses().iter().map(|p| p.position_m.x).collect();
    assert_eq!((places, graph.stamps()), (vec![3.0, 1.0, 5.0], None));
    assert!((graph.poses()[1].to_plane().heading_rad - 0.5).abs() < 1e-12);
    for (text, part) in [
        ("EDGE_SE2 0 1 1 0 0\n", "holds no pose"),
        ("VERTEX_SE2 0 1 2\n", "line 1: 3 "),
        (
            "VERTEX_SE2 0.5 1 2 0\n",
            "vertex 0.5; expected a whole number",
        ),
        (
            "VERTEX_SE2 3 1 2 0\nFIX 3\nVERTEX2 3 1 2 0\n",
            "line 3: vertex 3 twice, first in line 1",
        ),
        ("VERTEX_SE2 0 1 x 0\n", "line 1"),
    ] {
        let error = read(Format::Graph, text).unwrap_err().to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
}

#[test]
fn what_is_written_reads_the_same() {
    let text = "0.1 1.25 -2 0.001 0.1 -0.2 0.3 0.927\n0.30000000000000004 7 8 9 0 0 0 1\n";
    let walk = read(Format::Tum, text).unwrap();
    for (output, format) in [
        (OutputFormat::Tum, Format::Tum),
        (OutputFormat::Csv, Format::Csv),
    ] {
        let again = read(format, &output.text(&walk).unwrap()).unwrap();
        assert_eq!(again.stamps(), walk.stamps());
        for (a, b) in again.poses().iter().zip(walk.poses()) {
            assert_eq!(a.position_m, b.position_m);
            assert!((a.rotation - b.rotation).norm() < 1e-15);
        }
    }
    let unstamped = read(Format::Kitti, "1 0 0 5 0 1 0 6 0 0 1 7\n").unwrap();
    assert!(OutputFormat::Tum.text(&unstamped).unwrap_err().is_usage());
    let csv = OutputFormat::Csv.text(&unstamped).unwrap();
    assert!(csv.starts_with("x_m,"), "{csv}");
    assert_eq!(read(Format::Csv, &csv).unwrap(), unstamped);
}

#[test]
fn the_first_fault_is_named_however_long_the_file_is() {
    let mut text: String = (0..9000).map(|k| format!("{k} 0 0 0 0 0 0 1\n")).collect();
    text = text.replace("\n7000 0", "\n7000 NaN");
    text = text.replace("\n4000 0", "\n4000 inf");
    let error = read(Format::Tum, &text).unwrap_err().to_string();
    assert_eq!(
        error,
        "t: line 4001: `x` holds `inf`; expected a finite number"
    );
}
