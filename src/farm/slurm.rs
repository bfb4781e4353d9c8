//! Slurm: an array job, and a merge that waits for all of it.

use super::{Plan, shell};

/// The files, and what is to be done with them.
pub(super) fn files(plan: &Plan) -> (Vec<(&'static str, String)>, String) {
    let folder = plan.folder.display().to_string();
    let (quoted, count) = (shell::quoted(&folder), plan.parts.len());
    let name = shell::quoted(&format!("patina-{}", plan.name));
    // A job that loses its node is queued again by itself. Another failure is that of its part alone; the merge then names
    // the missing samples.
    let submit = format!(
        "#!/bin/sh\n# Submits the parts and the merge; further flags are handed to sbatch.\nset -eu\n\
         parts=$(sbatch --parsable --requeue --open-mode=append --job-name={name} --array=1-{count} --ntasks=1 \\\n    \
         --output={quoted}/part-%a.log \"$@\" {quoted}/array.sh)\n\
         sbatch --dependency=afterany:\"${{parts%%;*}}\" --requeue --open-mode=append --job-name={name}-merge --ntasks=1 \\\n    \
         --output={quoted}/merge.log \"$@\" {quoted}/merge.sh\n"
    );
    let array = format!("#!/bin/sh\nexec sh {quoted}/part.sh \"$SLURM_ARRAY_TASK_ID\"\n");
    let files = vec![
        ("part.sh", shell::part_script(plan)),
        ("merge.sh", shell::merge_script(plan)),
        ("array.sh", array),
        ("submit.sh", submit),
    ];
    (
        files,
        format!(
            "submit them by: sh {}",
            shell::quoted(&format!("{folder}/submit.sh"))
        ),
    )
}
