//! Flamenco 3: a job type in its JavaScript, with the parts of this job; a task for each, and a merge that depends on them all.

use serde_json::json;

use super::{Plan, shell};

/// The files, and what is to be done with them.
pub(super) fn files(plan: &Plan) -> (Vec<(&'static str, String)>, String) {
    let part = plan.folder.join("part.sh").display().to_string();
    let merge = plan.folder.join("merge.sh").display().to_string();
    let count = plan.parts.len();
    let script = format!(
        "// A job type: put it into the folder `scripts` of Flamenco's manager.\nconst JOB_TYPE = {{\n  label: {label},\n  settings: [],\n}};\n\n\
         function compileJob(job) {{\n  \
         const merge = author.Task(\"merge\", \"misc\");\n  merge.addCommand(author.Command(\"exec\", {{ exe: \"sh\", args: [{merge}] }}));\n  \
         for (let part = 1; part <= {count}; part++) {{\n    const task = author.Task(\"part \" + part, \"misc\");\n    \
         task.addCommand(author.Command(\"exec\", {{ exe: \"sh\", args: [{part}, String(part)] }}));\n    job.addTask(task);\n    \
         merge.addDependency(task);\n  }}\n  job.addTask(merge);\n}}\n",
        label = json!(format!("Patina {}", plan.name)),
        merge = json!(merge),
        part = json!(part),
    );
    let files = vec![
        ("part.sh", shell::part_script(plan)),
        ("merge.sh", shell::merge_script(plan)),
        ("patina.js", script),
    ];
    let path = plan.folder.join("patina.js");
    (files, format!("the job type is {}", path.display()))
}
