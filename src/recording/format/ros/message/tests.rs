use super::*;

/// Writes messages as the serialisations have them.
struct Writer {
    bytes: Vec<u8>,
    big_endian: bool,
    cdr: bool,
}

impl Writer {
    fn all() -> [Self; 3] {
        let writer = |start: &[u8], big_endian| Writer {
            bytes: start.to_vec(),
            big_endian,
            cdr: !start.is_empty(),
        };
        [
            writer(&[], false),
            writer(&[0, 1, 0, 0], false),
            writer(&[0, 0, 0, 0], true),
        ]
    }

    fn serialisation(&self) -> Serialisation {
        match self.cdr {
            true => Serialisation::Cdr,
            false => Serialisation::Ros1,
        }
    }

    fn number(&mut self, little_endian: &[u8]) -> &mut Self {
        while self.cdr && !(self.bytes.len() - 4).is_multiple_of(little_endian.len()) {
            self.bytes.push(0);
        }
        let mut number = little_endian.to_vec();
        if self.big_endian {
            number.reverse();
        }
        self.bytes.extend(number);
        self
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.number(&value.to_le_bytes())
    }

    fn f32s(&mut self, values: &[f32]) -> &mut Self {
        for value in values {
            self.number(&value.to_le_bytes());
        }
        self
    }

    fn f64s(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.number(&value.to_le_bytes());
        }
        self
    }

    fn string(&mut self, text: &str) -> &mut Self {
        self.u32((text.len() + usize::from(self.cdr)) as u32);
        self.bytes.extend(text.bytes());
        if self.cdr {
            self.bytes.push(0);
        }
        self
    }

    fn header(&mut self, frame: &str) -> &mut Self {
        if !self.cdr {
            self.u32(77); // sequence number
        }
        self.u32(12).u32(500_000_000).string(frame)
    }
}

#[test]
fn a_scan_reads_the_same_in_every_serialisation() {
    for mut writer in Writer::all() {
        writer
            .header("las")
            .f32s(&[-1.5, 1.5, 0.5, 0.0, 0.1, 0.2, 8.0]);
        writer.u32(3).f32s(&[1.0, f32::INFINITY, 2.5]);
        writer.u32(1).f32s(&[9.0]);
        let message = decode(Kind::Scan, &writer.bytes, writer.serialisation()).unwrap();
        assert_eq!((message.stamp_s, message.frame.as_str()), (12.5, "las"));
        let expected = Scan {
            first_rad: -1.5,
            step_rad: 0.5,
            nearest_m: 0.2,
            farthest_m: 8.0,
            ranges: vec![1.0, f32::INFINITY, 2.5],
        };
        assert_eq!(message.content, Content::Scan(expected));
    }
}

#[test]
fn poses_and_transforms_are_aligned() {
    let numbers = [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8];
    for mut writer in Writer::all() {
        // A frame of three letters: what follows is at an odd place.
        writer.header("/map").f64s(&numbers);
        let message = decode(Kind::Pose, &writer.bytes, writer.serialisation()).unwrap();
        assert_eq!(message.frame, "map");
        let Content::Pose { pose, child: None } = message.content else {
            panic!("a pose")
        };
        assert_eq!(pose.translation.vector.as_slice(), [1.0, 2.0, 3.0]);
        assert!((pose.rotation.euler_angles().2 - 2.0 * 0.6_f64.asin()).abs() < 1e-12);
    }
    for mut writer in Writer::all() {
        writer.header("odom").string("base").f64s(&numbers);
        writer.f64s(&[0.0; 36 + 6 + 36]);
        let message = decode(Kind::Odometry, &writer.bytes, writer.serialisation()).unwrap();
        let Content::Pose { child, .. } = message.content else {
            panic!("a pose")
        };
        assert_eq!(child.as_deref(), Some("base"));
    }
    for mut writer in Writer::all() {
        writer.u32(2);
        for child in ["a", "bcd"] {
            writer.header("map").string(child).f64s(&numbers);
        }
        let message = decode(Kind::Transforms, &writer.bytes, writer.serialisation()).unwrap();
        let Content::Transforms(transforms) = message.content else {
            panic!("transforms")
        };
        assert_eq!(transforms[1].child, "bcd");
        assert_eq!(transforms[1].parent_from_child.translation.z, 3.0);
    }
}

#[test]
fn ranges_and_pictures_are_read() {
    for mut writer in Writer::all() {
        writer.header("ir").bytes.push(1);
        writer.f32s(&[0.3, 0.1, 2.0, 1.25]);
        let whole = writer.bytes.clone();
        let message = decode(Kind::Range, &whole, writer.serialisation()).unwrap();
        let Content::Range(range) = message.content else {
            panic!("a range")
        };
        assert_eq!(
            (range.infrared, range.farthest_m, range.range),
            (true, 2.0, 1.25)
        );
        // Newer versions have a variance behind it.
        writer.f32s(&[0.0]);
        assert!(decode(Kind::Range, &writer.bytes, writer.serialisation()).is_ok());
    }
    for mut writer in Writer::all() {
        writer
            .header("eye")
            .string("png")
            .u32(2)
            .bytes
            .extend([7, 8]);
        let message = decode(Kind::Picture, &writer.bytes, writer.serialisation()).unwrap();
        let expected = Content::Picture {
            format: "png".into(),
            file: &[7, 8],
        };
        assert_eq!(message.content, expected);
    }
}

#[test]
fn damaged_messages_say_what_is_wrong() {
    let [mut ros1, mut cdr, _] = Writer::all();
    ros1.header("l").f32s(&[0.0; 7]).u32(u32::MAX);
    let fault = decode(Kind::Scan, &ros1.bytes, Serialisation::Ros1).unwrap_err();
    assert!(
        fault.contains("announces 4294967295 items with 0 bytes left"),
        "{fault}"
    );
    cdr.header("map")
        .f64s(&[0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let fault = decode(Kind::Pose, &cdr.bytes, Serialisation::Cdr).unwrap_err();
    assert!(fault.contains("`NaN`"), "{fault}");
    let [mut longer, ..] = Writer::all();
    longer
        .header("map")
        .f64s(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 5.0]);
    let fault = decode(Kind::Pose, &longer.bytes, Serialisation::Ros1).unwrap_err();
    assert!(fault.contains("8 bytes are left"), "{fault}");
    let [mut flat, ..] = Writer::all();
    flat.header("map").f64s(&[0.0; 7]);
    let fault = decode(Kind::Pose, &flat.bytes, Serialisation::Ros1).unwrap_err();
    assert!(fault.contains("length 0.000"), "{fault}");
    let fault = decode(Kind::Scan, b"\x09\x09\x09\x09 what", Serialisation::Cdr).unwrap_err();
    assert!(fault.contains("starts with `09 09 09 09`"), "{fault}");
    for end in 0..cdr.bytes.len() {
        assert!(decode(Kind::Pose, &cdr.bytes[..end], Serialisation::Cdr).is_err());
    }
    let [mut late, ..] = Writer::all();
    late.u32(0).u32(1).u32(1_000_000_000).string("map");
    let fault = decode(Kind::Pose, &late.bytes, Serialisation::Ros1).unwrap_err();
    assert!(fault.contains("less than a second"), "{fault}");
}

#[test]
fn types_are_known_in_both_spellings() {
    assert_eq!(
        ros1_spelling("sensor_msgs/msg/LaserScan"),
        "sensor_msgs/LaserScan"
    );
    assert_eq!(Kind::named("sensor_msgs/LaserScan"), Some(Kind::Scan));
    assert_eq!(Kind::named(&ros1_spelling("std_msgs/msg/String")), None);
}
