#[test]
fn bank() {
    use ballmark::experiment::thrun1998::{self, Thrun1998Config};
    let runs = std::env::var("BANK_RUNS").map_or(4, |r| r.parse().unwrap());
    let set = std::env::var("BANK_SET").unwrap_or("d1".into());
    let seed = std::env::var("BANK_SEED").map_or(1, |r| r.parse().unwrap());
    let config = Thrun1998Config {
        seed,
        sets: vec![set.clone()],
        runs: 2,
        steps: 100,
        doubled: false,
        harder: false,
        bank_runs: runs,
        choice_seeds: std::env::var("CHOICES").map_or(0, |r| r.parse().unwrap()),
        ..Default::default()
    };
    let record = thrun1998::run(&config, &mut |_, _, _| ()).unwrap();
    if !record.choices.is_empty() {
        for s in ballmark::report::thrun1998::sheets(&record) {
            if s.name == "choices" || s.name == "bank" {
                println!("{}", s.table.text());
            }
        }
    }
    std::fs::write(
        format!("/tmp/r18/bank-{set}-{runs}-{seed}.json"),
        serde_json::to_string(&record.bank).unwrap(),
    )
    .unwrap();
}
