//! `OpenCue`: a job in its XML (cjsl 1.15), a layer for the parts, one for the merge that depends on it.

use super::{Plan, shell};

/// The files, and what is to be done with them.
pub(super) fn files(plan: &Plan) -> (Vec<(&'static str, String)>, String) {
    let folder = shell::quoted(&plan.folder.display().to_string());
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            '_'
        }
    };
    let name: String = plan.name.chars().map(plain).collect();
    let layer = |name: &str, kind: &str, command: String, range: String| {
        format!(
            "      <layer name=\"{name}\" type=\"{kind}\">\n        <cmd>{}</cmd>\n        <range>{range}</range>\n        <chunk>1</chunk>\n        \
             <services>\n          <service>shell</service>\n        </services>\n      </layer>\n",
            escaped(&command)
        )
    };
    let parts = layer(
        "parts",
        "Render",
        format!("sh {folder}/part.sh #IFRAME#"),
        format!("1-{}", plan.parts.len()),
    );
    // Not `Post`: layers of that type become a job of their own, which begins when this one has ended, with gaps or without.
    let merge = layer(
        "merge",
        "Util",
        format!("sh {folder}/merge.sh"),
        "1".to_owned(),
    );
    // Show, shot and user are the site's own business. More than one retry is more than the server gives.
    let job = format!(
        "<?xml version=\"1.0\"?>\n<!DOCTYPE spec PUBLIC \"SPI Cue Specification Language\" \"http://localhost:8080/spcue/dtd/cjsl-1.15.dtd\">\n<spec>\n  \
         <facility>local</facility>\n  <show>testing</show>\n  <shot>patina</shot>\n  <user>patina</user>\n  <uid>1000</uid>\n  <job name=\"patina_{name}\">\n    \
         <paused>False</paused>\n    <maxretries>1</maxretries>\n    <autoeat>False</autoeat>\n    <layers>\n{parts}{merge}    </layers>\n  </job>\n  <depends>\n    \
         <depend type=\"LAYER_ON_LAYER\" anyframe=\"False\">\n      <depjob>patina_{name}</depjob>\n      <deplayer>merge</deplayer>\n      \
         <onjob>patina_{name}</onjob>\n      <onlayer>parts</onlayer>\n    </depend>\n  </depends>\n</spec>\n"
    );
    let files = vec![
        ("part.sh", shell::part_script(plan)),
        ("merge.sh", shell::merge_script(plan)),
        ("job.opencue.xml", job),
    ];
    let path = plan.folder.join("job.opencue.xml");
    (
        files,
        format!(
            "set facility, show, shot and user in {}, and launch it",
            path.display()
        ),
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
