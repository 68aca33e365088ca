//! `localise --rerun` on the real binary.

use crate::support::Workplace;

#[cfg(not(feature = "rerun"))]
#[test]
fn a_build_without_rerun_says_how_to_get_one_before_it_reads_anything() {
    let place = Workplace::new();
    let call = ["localise", "no.safetensors", "no.npz", "--rerun", "t.rrd"];
    place
        .ballmark(&call)
        .refused(2, &["--rerun", "cargo install --path . --features rerun"]);
    assert!(place.files().is_empty());
}

#[cfg(feature = "rerun")]
mod in_a_build_with_it {
    use super::*;
    use re_log_encoding::DecoderApp;
    use re_log_types::LogMsg;
    use std::{collections::BTreeSet, path::Path, process::Command};

    fn shipped(path: &str) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        path.to_str().unwrap().to_string()
    }

    fn entities(bytes: &[u8]) -> BTreeSet<String> {
        let messages = DecoderApp::decode_lazy(bytes).map(|message| message.unwrap());
        let paths = messages.filter_map(|message| match message {
            LogMsg::ArrowMsg(store, message) if store.is_recording() => {
                let chunk = re_chunk::Chunk::from_arrow_msg(&message).unwrap();
                Some(chunk.entity_path().to_string())
            }
            _ => None,
        });
        paths.collect()
    }

    #[test]
    fn rerun_holds_what_the_page_shows_and_is_the_same_with_any_number_of_threads() {
        let place = Workplace::new();
        let (model, data) = (
            shipped("models/corridor-2m.safetensors"),
            shipped("datasets/corridor-small.npz"),
        );
        let call = ["localise", &model, &data, "--trials", "3"];
        let recorded = |more: &[&str], threads: &str| {
            let mut command = Command::new(crate::support::binary());
            let command = command.args(call).args(["--rerun", "t.rrd"]).args(more);
            let command = command.env("RAYON_NUM_THREADS", threads);
            crate::support::answer(command.current_dir(place.path(""))).done();
            std::fs::read(place.path("t.rrd")).unwrap()
        };
        let bytes = recorded(&["--out", "report"], "1");
        assert!(
            recorded(&[], "3") == bytes,
            "threads or --out change the recording"
        );
        let player = std::fs::read_to_string(place.path("report/player.json")).unwrap();
        let player: serde_json::Value = serde_json::from_str(&player).unwrap();
        let entities = entities(&bytes);
        let has = |path: String| assert!(entities.contains(&path), "{path} in {entities:?}");
        for trial in player["trials"].as_array().unwrap() {
            let trial = format!("/trials/{}", trial["number"].as_u64().unwrap() + 1);
            for system in player["systems"].as_array().unwrap() {
                let name = system[0].as_str().unwrap();
                has(format!("{trial}/answer/{name}"));
                has(format!("{trial}/expected_error_m/{name}"));
            }
            has(format!("{trial}/belief/learned"));
            has(format!("{trial}/robot/scan/sonar"));
            has(format!("{trial}/features/over_time"));
        }
    }

    #[test]
    fn rerun_refuses_what_can_not_be_written_before_the_trials() {
        let place = Workplace::new();
        for (file, status, words) in [
            ("no/t.rrd", 1, "the folder no does not exist"),
            ("t.txt", 2, "ends with .rrd"),
        ] {
            let call = ["localise", "no.safetensors", "no.npz", "--rerun", file];
            place.ballmark(&call).refused(status, &[words, file]);
        }
        assert!(place.files().is_empty());
    }
}
