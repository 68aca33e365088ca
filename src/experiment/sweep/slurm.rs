//! The same work for schedulers that people have: a Slurm array, and a line of GNU parallel.

use super::folder::Sweep;
use std::path::Path;

/// Most tasks of an array: what Slurm allows where nobody set `MaxArraySize`.
const MOST_TASKS: usize = 1000;

/// A script for `sbatch`. Its tasks deal the cells among them, so that an array is never longer than Slurm allows; a task that is killed and
/// put back in the queue goes on with what it has not done.
pub fn slurm_script(sweep: &Sweep) -> String {
    let cells = sweep.plan.cells;
    let tasks = cells.clamp(1, MOST_TASKS);
    let folder = quoted(sweep.folder());
    format!(
        "#!/bin/bash
# {cells} cells dealt among {tasks} tasks. Each cell is done once, however often this is submitted: sbatch run.slurm
#SBATCH --job-name=ballmark-sweep
#SBATCH --array=1-{tasks}
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu=2G
#SBATCH --time=04:00:00
#SBATCH --requeue
#SBATCH --output=/dev/null

# The folder as every node sees it, and the program there.
sweep=${{SWEEP:-{folder}}}
ballmark=${{BALLMARK:-ballmark}}
export RAYON_NUM_THREADS=${{SLURM_CPUS_PER_TASK:-1}}

failed=0
while read -r cell; do
    \"$ballmark\" sweep run-cell \"$sweep\" \"$cell\" --quiet || failed=1
done < <(awk -F'\"' -v task=\"$SLURM_ARRAY_TASK_ID\" '(NR - 1) % {tasks} + 1 == task {{ print $4 }}' \"$sweep/cells.jsonl\")
exit $failed
"
    )
}

/// A line for a shell that has GNU parallel, here or with its `--sshlogin`.
pub fn parallel_line(sweep: &Sweep) -> String {
    let folder = quoted(sweep.folder());
    format!(
        "awk -F'\"' '{{ print $4 }}' {folder}/cells.jsonl | RAYON_NUM_THREADS=1 parallel -j 100% ballmark sweep run-cell {folder} {{}} --quiet"
    )
}

/// A folder from the root on, as a shell reads it.
fn quoted(folder: &Path) -> String {
    let whole = folder
        .canonicalize()
        .unwrap_or_else(|_| folder.to_path_buf());
    let name = whole.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+".contains(c);
    match name.chars().all(plain) {
        true => name.into_owned(),
        false => format!("'{}'", name.replace('\'', r"'\''")),
    }
}
