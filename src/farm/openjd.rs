//! Open Job Description (2023-09): a step for the parts, one for the merge. The template is JSON, which YAML readers take, too.

use serde_json::{Value, json};

use super::{Plan, shell};

/// The files, and what is to be done with them.
pub(super) fn files(plan: &Plan) -> (Vec<(&'static str, String)>, String) {
    let part = "{{Task.Param.Part}}";
    let run = |script: &str, args: Vec<String>| -> Value {
        let path = plan.folder.join(script).display().to_string();
        let args: Vec<String> = [path].into_iter().chain(args).collect();
        let cancelation = json!({ "mode": "NOTIFY_THEN_TERMINATE", "notifyPeriodInSeconds": 20 });
        json!({ "actions": { "onRun": { "command": "sh", "args": args, "cancelation": cancelation } } })
    };
    let count = plan.parts.len();
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": format!("Patina {}", plan.name),
        "steps": [
            {
                "name": "Parts",
                "parameterSpace": {
                    "taskParameterDefinitions": [{ "name": "Part", "type": "INT", "range": format!("1-{count}") }],
                },
                "script": run("part.sh", vec![part.to_owned()]),
            },
            {
                "name": "Merge",
                "dependencies": [{ "dependsOn": "Parts" }],
                "script": run("merge.sh", Vec::new()),
            },
        ],
    });
    let files = vec![
        ("part.sh", shell::part_script(plan)),
        ("merge.sh", shell::merge_script(plan)),
        ("job.openjd.json", format!("{template:#}\n")),
    ];
    let path = plan.folder.join("job.openjd.json");
    (files, format!("the template is {}", path.display()))
}
