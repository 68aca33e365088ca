//! Bags that are not held in memory, whole and damaged, beside the same ones in one piece.

use super::*;
use crate::storage::InputFile;
use std::rc::Rc;

/// The same file in a window of so many bytes.
fn read_in_windows(file: &[u8], window_bytes: usize) -> Result<ImportedLog> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bag");
    std::fs::write(&path, file).unwrap();
    let opened = Rc::new(InputFile::open(&path).unwrap());
    let content = Content::in_windows(opened, file.len(), window_bytes);
    let read = match file {
        _ if detect_rosbag1(file) => rosbag1_content,
        _ if detect_rosbag2(file) => rosbag2_content,
        _ => mcap_content,
    };
    read(Path::new("bag"), &content, &LogOptions::default())
}

#[test]
fn a_file_that_is_looked_at_in_windows_says_what_it_says_in_one_piece() {
    for name in FILES {
        let file = bytes(name);
        let mut stream = Seed(2).stream(name);
        let (mut as_read, mut refused) = (0, 0);
        for trial in 0..24 {
            let mut file = file.clone();
            let at = stream.random_range(100..file.len() - 8);
            match trial % 4 {
                _ if trial < 4 => {}
                0 => file.truncate(at),
                1 => file[at] ^= 1 << stream.random_range(0..8),
                2 => file[at..at + 4].fill(0xff),
                _ => drop(file.drain(at..at + 8)),
            }
            let format = [read_rosbag1, read_rosbag2, read_mcap];
            let is = [detect_rosbag1, detect_rosbag2, detect_mcap].map(|is| is(&file));
            let read = format[is.iter().position(|is| *is).unwrap()];
            let expected = read(Path::new("bag"), &file, &LogOptions::default());
            let found = read_in_windows(&file, [5, 64, 1000, 1 << 20][trial / 2 % 4]);
            match (expected, found) {
                (Ok(expected), Ok(found)) => {
                    let same = content(&found.recording) == content(&expected.recording);
                    assert!(same, "{name}, {trial}");
                    assert_eq!(found.account, expected.account, "{name}, {trial}");
                    as_read += 1;
                }
                (expected, found) => {
                    let fault = |log: Result<ImportedLog>| log.map(drop).unwrap_err().to_string();
                    assert_eq!(fault(found), fault(expected), "{name}, {trial}");
                    refused += 1;
                }
            }
        }
        assert!(as_read > 12, "{name}: {as_read} read, {refused} refused");
    }
}
