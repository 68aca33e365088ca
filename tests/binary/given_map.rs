//! Localisers in a map that the user has: a ROS map, in `ballmark compare` and `ballmark localise`.

use crate::support::Workplace;
use serde_json::Value;

/// A hall that a robot with a laser goes round several times, recorded as `hall.npz`, and its plan as `hall.yaml`.
fn workplace() -> Workplace {
    let place = Workplace::new();
    place.write(
        "hall.toml",
        "name = \"hall\"\n\
         [[wall]]\npoints = [[0, 0], [8, 0], [8, 5], [4, 5], [4, 4], [0, 4]]\nclosed = true\n\
         [robot]\nkind = \"b21\"\n\
         [laser]\nbeams = 60\n\
         [path]\nclosed = true\nlaps = 6\ncorners = [[1, 1], [7, 1], [7, 3], [1, 3]]\n\
         [record]\nevery_s = 2.0\n",
    );
    place
        .ballmark(&["simulate", "hall.toml", "-o", "hall.npz"])
        .done();
    place.write("hall.pgm", plan());
    place.write("hall.yaml", yaml("0.05", "-1.0, -1.0"));
    place
}

fn yaml(resolution: &str, origin: &str) -> String {
    format!(
        "image: hall.pgm\nresolution: {resolution}\norigin: [{origin}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
}

/// 10 m by 7 m from (−1, −1) on: the hall free, a wall of a cell around it, beyond it nobody knows.
fn plan() -> Vec<u8> {
    let inside =
        |x: f64, y: f64| x > 0.0 && x < 8.0 && y > 0.0 && y < if x > 4.0 { 5.0 } else { 4.0 };
    let mut picture = b"P5 200 140 255\n".to_vec();
    for row in (0..140).rev() {
        for column in 0..200 {
            let [x, y] = [column, row].map(|cell| -1.0 + 0.05 * (f64::from(cell) + 0.5));
            let near = [-0.05, 0.0, 0.05];
            let beside = near
                .iter()
                .any(|dx| near.iter().any(|dy| inside(x + dx, y + dy)));
            picture.push(match (inside(x, y), beside) {
                (true, _) => 254,
                (false, true) => 0,
                (false, false) => 205,
            });
        }
    }
    picture
}

/// Three localisers in the map of a YAML file, one in the map of the scans.
fn comparison(map: &str) -> String {
    format!(
        "[[dataset]]\nfile = 'hall.npz'\n\
         [[system]]\nkind = 'bayes'\nname = 'field'\nlandmarks = {{ kind = 'likelihood_field', map = '{map}' }}\n\
         [[system]]\nkind = 'bayes'\nname = 'beams'\nlandmarks = {{ kind = 'beam_model', map = '{map}' }}\n\
         [[system]]\nkind = 'monte_carlo'\nname = 'particles'\nmap = '{map}'\n\
         [[system]]\nkind = 'bayes'\nname = 'scans'\nlandmarks = 'likelihood_field'\n\
         [protocol]\nmapping = 'split'\nsplit = {{ test_fold = 0 }}\n\
         [localisation]\ntrials = 6\nresamples = 20\n"
    )
}

#[test]
fn a_map_that_is_given_is_as_good_as_the_scans_own() {
    let place = workplace();
    // File names are relative to the configuration.
    std::fs::create_dir(place.path("configs")).unwrap();
    let text = comparison("../hall.yaml").replace("'hall.npz'", "'../hall.npz'");
    place.write("configs/c.toml", text);
    let played = place.ballmark(&["compare", "configs/c.toml", "--json"]);
    played.done();
    let record: Value = serde_json::from_str(&played.stdout).unwrap();
    let systems = record["localisation"]["records"][0]["done"]["results"].as_array();
    let error_m = |name: &str| {
        let mut named = systems.unwrap().iter().filter(|s| s["name"] == name);
        named.next().unwrap()["error_at_10m_m"].as_f64().unwrap()
    };
    for name in ["field", "beams", "particles", "scans"] {
        assert!(error_m(name) < 0.5, "{name}: {} m", error_m(name));
    }
}

#[test]
fn a_map_that_does_not_belong_here_is_a_named_failure_in_its_cell() {
    let place = workplace();
    place.write("moved.yaml", yaml("0.05", "2.3, 1.2"));
    place.write("scaled.yaml", yaml("0.1", "-2.0, -2.0"));
    place.write("empty.yaml", yaml("0.05", "0, 0").replace("hall", "empty"));
    place.write("empty.pgm", "P2 2 2 255\n254 254 254 254\n");
    for (map, expected) in [
        ("moved.yaml", "moved.yaml: the map does not fit"),
        ("scaled.yaml", "at 0.5000 times its scale, 0.05 m a cell"),
        ("empty.yaml", "empty.pgm: no cell is occupied"),
        ("none.yaml", "none.yaml: cannot read"),
    ] {
        place.write("c.toml", comparison(map));
        let played = place.ballmark(&["compare", "c.toml"]);
        assert_eq!(played.status, 3, "{map}: {}", played.stderr);
        // Whoever fails alike is named together.
        let named = "[localisation] field, beams, particles on hall: ";
        let mut lines = played.stderr.lines().filter(|line| line.contains(named));
        let line = lines
            .next()
            .unwrap_or_else(|| panic!("{map}: {}", played.stderr));
        assert!(line.contains(expected), "{expected} is missing in: {line}");
        assert!(
            !played.stderr.contains("scans on hall"),
            "{}",
            played.stderr
        );
    }
}

#[test]
fn localise_takes_a_map_and_people() {
    let place = workplace();
    let train = [
        "train",
        "hall.npz",
        "-o",
        "m.safetensors",
        "--test-fold",
        "0",
        "--features",
        "2",
        "--steps",
        "5",
    ];
    place.ballmark(&train).done();
    let localise = |more: &[&str]| {
        let usual = ["localise", "m.safetensors", "hall.npz", "--trials", "3"];
        place.ballmark(&[&usual, more].concat())
    };
    let field = |table: &str| {
        let mut rows = table.lines().filter(|l| l.starts_with("occupancy map"));
        rows.next().unwrap().to_string()
    };
    let (scans, given) = (localise(&[]), localise(&["--map", "hall.yaml"]));
    assert_ne!(field(&scans.done().stdout), field(&given.done().stdout));
    // The same by a configuration, whose file names are relative to itself.
    let text = "[localise]\nmap = 'hall.yaml'\nmore_particles = 4\n";
    place.write("c.toml", text);
    let by_file = localise(&["--config", "c.toml"]);
    assert_eq!(field(&by_file.done().stdout), field(&given.stdout));
    // Its own 5,000 and 40,000 particles beside each other; more are asked for in vain.
    let note = "note: more_particles has no effect";
    assert!(by_file.stderr.contains(note), "{}", by_file.stderr);
    assert!(
        scans.stdout.contains("found with 5000 particles,"),
        "{}",
        scans.stdout
    );
    assert!(scans.stdout.contains("found with 40000 particles:"));
    let crowded = localise(&["--people", "0.4"]);
    let said = &crowded.done().stdout;
    assert!(said.contains("people before 40 % of the beams"), "{said}");
    assert_ne!(field(said), field(&scans.stdout));
    localise(&["--people", "2"]).refused(2, &["localise.people", "0 to 1"]);
    localise(&["--map", "m.yaml"]).refused(1, &["m.yaml: cannot read"]);
    place.write("moved.yaml", yaml("0.05", "2.3, 1.2"));
    let moved = localise(&["--map", "moved.yaml"]);
    let said = &moved.done().stdout;
    assert!(
        said.contains("left out: ") && said.contains("moved.yaml: the map does not fit"),
        "{said}"
    );
}
