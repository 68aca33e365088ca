//! Programs that are run: ended with all that they started, and what they printed last.

use std::{
    fs::File,
    io::{Read, Seek, SeekFrom},
    path::Path,
    process::{Child, Command},
};

/// Bytes at the end of what a program printed that are looked at.
const LAST_BYTES: u64 = 4096;

/// To be started in a process group of its own: Ctrl-C comes to whoever starts it, and [`end`] ends what it starts, too.
pub(super) fn in_own_group(command: &mut Command) {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    #[cfg(not(unix))]
    let _ = command;
}

/// Ends a program that was started in a group of its own, with all that it started; it is to be waited for.
pub(super) fn end(child: &mut Child) {
    #[cfg(unix)]
    {
        use rustix::process::{Pid, Signal, kill_process_group};
        let group = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        if let Some(Ok(())) = group.map(|group| kill_process_group(group, Signal::KILL)) {
            return;
        }
    }
    let _ = child.kill(); // one that has ended meanwhile needs no end
}

/// The last lines that aren't empty of what a program printed to a file, however long that is; at most so many.
pub(super) fn last_lines(file: &Path, most: usize) -> Vec<String> {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(file)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LAST_BYTES)))?;
        let mut end = Vec::new();
        file.take(LAST_BYTES).read_to_end(&mut end)?;
        Ok(end)
    };
    let end = read().unwrap_or_default(); // without them a message does, too
    let end = String::from_utf8_lossy(&end);
    let lines: Vec<&str> = end.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = &lines[lines.len().saturating_sub(most)..];
    last.iter().map(|line| (*line).to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What it started holds the other end of the pipe, and would for half a minute.
    #[cfg(unix)]
    #[test]
    fn what_a_program_started_ends_with_it() {
        use std::{process::Stdio, sync::mpsc::channel, thread, time::Duration};
        let mut command = Command::new("sh");
        command
            .args(["-c", "sleep 30 & echo begun; wait"])
            .stdout(Stdio::piped());
        in_own_group(&mut command);
        let mut child = command.spawn().unwrap();
        let mut printed = child.stdout.take().unwrap();
        printed.read_exact(&mut [0; 6]).unwrap();
        end(&mut child);
        child.wait().unwrap();
        let (closed, told) = channel();
        thread::spawn(move || {
            let _ = printed.read_to_end(&mut Vec::new());
            let _ = closed.send(());
        });
        assert!(told.recv_timeout(Duration::from_secs(15)).is_ok());
    }

    #[test]
    fn the_end_of_what_was_printed_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stderr");
        let lines: Vec<String> = (0..5000).map(|n| format!("line {n}")).collect();
        std::fs::write(&path, lines.join("\n\n")).unwrap();
        let last = last_lines(&path, 20);
        assert_eq!(last, lines[4980..]);
        assert!(last_lines(&folder.path().join("none"), 20).is_empty());
    }
}
