use super::*;

#[test]
fn numbers_of_any_length_are_read() {
    for (bytes, value) in [
        (&[0x05][..], 5),
        (&[0x81, 0x00], 128),
        (&[0xff; 9], -1),
        (&[0x80; 9], 128), // all eight bits of the ninth byte count
    ] {
        let mut unread = bytes;
        assert_eq!(varint(&mut unread), Some(value));
        assert!(unread.is_empty());
    }
    assert_eq!(varint(&mut &[0x81][..]), None);
}

#[test]
fn cells_have_their_types() {
    // Null, one byte, two bytes, a float, 1, a text of three letters.
    let head = [7, 0, 1, 2, 7, 9, 19];
    let body = [&[0xff, 0x01, 0x02][..], &1.5_f64.to_be_bytes(), b"abc"].concat();
    let content = [&head[..], &body].concat();
    let row = cells(Cow::Borrowed(&content)).unwrap();
    assert_eq!(
        row[..5],
        [
            Value::Null,
            Value::Integer(-1),
            Value::Integer(258),
            Value::Real(1.5),
            Value::Integer(1)
        ]
    );
    assert_eq!(row[5].text(), Some("abc"));
    for end in 0..content.len() {
        assert_eq!(cells(Cow::Borrowed(&content[..end])), None);
    }
}

#[test]
fn columns_are_found_in_the_statement() {
    let sql = "CREATE TABLE \"m\" (id INTEGER PRIMARY KEY, \"topic_id\" INTEGER CHECK (a IN (1, 2)), [data] BLOB NOT NULL)";
    assert_eq!(column_names(sql), ["id", "topic_id", "data"]);
    assert!(column_names("CREATE TABLE").is_empty());
}

#[test]
fn what_is_no_database_is_refused() {
    let opens = |file: &[u8]| Database::open(&Content::of_bytes(file)).is_ok();
    assert!(!opens(b"SQLite format 3\0"));
    let mut header = vec![0; 4096];
    header[16..18].copy_from_slice(&1000_u16.to_be_bytes());
    assert!(!opens(&header));
    header[16..18].copy_from_slice(&512_u16.to_be_bytes());
    assert!(opens(&header));
    header[20] = 255;
    assert!(!opens(&header));
}
