//! A Slurm script that submits itself: one job before all frames, an array with a task per chunk, one job after it.
//!
//! In: [`Plan`]. Out: a bash script. Its first lines explain its use. Tasks lost with a node are requeued and continue
//! where they stopped (`--requeue`, `--resume`).

use super::{Plan, list_of};
use crate::files::GENERATOR;
use anyhow::bail;

/// Maximum number of tasks of an array: Slurm's default limit is 1001 (`MaxArraySize`), and indices begin at 0.
const MAX_TASKS: usize = 1000;

/// Returns the script.
pub(super) fn script(plan: &Plan) -> anyhow::Result<String> {
    let tasks = plan.frames.len().div_ceil(plan.chunk);
    if tasks > MAX_TASKS {
        bail!(
            "{tasks} tasks are more than an array of Slurm takes ({MAX_TASKS}); give --chunk {} or more",
            plan.frames.len().div_ceil(MAX_TASKS)
        );
    }
    let chunks: Vec<String> =
        plan.frames.chunks(plan.chunk).map(|chunk| format!("  {}", quoted(&list_of(chunk)))).collect();
    let words = |words: &[String]| words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    let (bake, all) = (words(&plan.bake), quoted(&list_of(&plan.frames)));
    let (name, program) = (quoted(&plan.name), quoted(&plan.program));
    let (work, report, extra_arguments, chunks) =
        (words(&plan.work), words(&plan.report), words(&plan.extra_arguments), chunks.join("\n"));
    Ok(format!(
        r#"#!/bin/bash
# Renders a shot on a Slurm cluster; written by {GENERATOR}. Run it on a machine that can submit jobs:
#   bash THIS [OPTIONS OF SBATCH], e.g. --partition=render --cpus-per-task=16 --mem=32G
# All nodes must have access to all files and folders. Submitting again renders only the missing frames.
set -euo pipefail
program=({program})
chunks=(
{chunks}
)
case "${{1:-submit}}" in
  prepare) exec "${{program[@]}}" {bake} ;;
  render)
    "${{program[@]}}" {work} --frames "${{chunks[$SLURM_ARRAY_TASK_ID]}}" --resume {extra_arguments} && exit
    code=$?
    # Bad input (exit code 2) is not retried; a task that fails otherwise is requeued at most twice.
    if [ $code != 2 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt 2 ]; then scontrol requeue "$SLURM_JOB_ID"; fi
    exit $code ;;
  report) exec "${{program[@]}}" {report} --frames {all} --verify ;;
esac
[ "${{1:-}}" = submit ] && shift
this=$(realpath "$0")
name={name}
prepare=$(sbatch --parsable --job-name="$name.prepare" "$@" "$this" prepare)
render=$(sbatch --parsable --job-name="$name" --requeue --dependency="afterok:${{prepare%%;*}}" --array="0-$((${{#chunks[@]}} - 1))" "$@" "$this" render)
report=$(sbatch --parsable --job-name="$name.report" --dependency="afterany:${{render%%;*}}" "$@" "$this" report)
echo "submitted $name: prepare $prepare, ${{#chunks[@]}} tasks in array $render, report $report"
"#
    ))
}

/// Quotes a word for bash.
fn quoted(word: &str) -> String {
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_./,:#=%@+".contains(letter);
    if !word.is_empty() && word.chars().all(is_plain) && !word.starts_with('#') {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn words_are_quoted_for_bash() {
        for (word, quoted) in
            [("a b", "'a b'"), ("it's", r"'it'\''s'"), ("f.####.exr", "f.####.exr"), ("", "''"), ("$x", "'$x'")]
        {
            assert_eq!(super::quoted(word), quoted);
        }
    }
}
