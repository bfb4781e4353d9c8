//! Command lines for POSIX shells.

use crate::words::FILM_EXTENSION;

use super::Plan;

/// Words as a shell takes them apart again.
pub(super) fn line(words: &[String]) -> String {
    words
        .iter()
        .map(|word| quoted(word))
        .collect::<Vec<_>>()
        .join(" ")
}

pub(super) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// What follows when a render has been started in the background: signals are passed on to it, and its end is waited for. A signal ends
/// a `wait` at once, so that this is done again; a render that has ended before isn't known to it any more, which is 127.
const WAIT: &str = r#"pid=$!
[ -z "$heard" ] || kill -TERM "$pid" 2>/dev/null || :
code=127 heard=1
while [ -n "$heard" ]; do
  heard=''
  wait "$pid" && status=0 || status=$?
  [ "$status" -eq 127 ] || code=$status
done
[ "$code" -eq 0 ] || exit "$code"
"#;

/// A script that renders the part of the number that it is given, from 1 on, unless its film is there. The film gets its name when
/// it is whole: a render that a scheduler ends early writes what it has, too.
pub(super) fn part_script(plan: &Plan) -> String {
    let mut cases = String::new();
    for (number, part) in plan.parts.iter().enumerate() {
        let (samples, film) = (&part.samples, quoted(&part.film.display().to_string()));
        let (start, end) = (samples.start, samples.end);
        cases += &format!("  {}) samples={start}..{end} film={film} ;;\n", number + 1);
    }
    let words = plan.render("@samples@", "@begun@");
    let render = line(&words)
        .replace("@samples@", "\"$samples\"")
        .replace("@begun@", "\"$begun\"");
    let begun = quoted(&plan.folder.join("begun").display().to_string());
    // Schedulers signal the shell, which would leave its render behind.
    format!(
        "#!/bin/sh\n# Renders a part: `sh part.sh N`, N from 1 to {count}.\nset -eu\ncd {here}\ncase \"$1\" in\n{cases}  \
         *) echo \"there is no part $1\" >&2; exit 2 ;;\nesac\n[ -s \"$film\" ] && exit 0\nmkdir -p {begun}\n\
         begun={begun}/$(uname -n)-$$.{FILM_EXTENSION}\nheard='' pid=''\ntrap 'rm -f \"$begun\"' EXIT\n\
         trap 'heard=1; [ -z \"$pid\" ] || kill -TERM \"$pid\" 2>/dev/null || :' TERM HUP INT\n\
         {render} &\n{WAIT}mv \"$begun\" \"$film\"\n",
        count = plan.parts.len(),
        here = quoted(&plan.here.display().to_string()),
    )
}

/// A script that merges the parts that there are; where one is missing, the merge says which samples.
pub(super) fn merge_script(plan: &Plan) -> String {
    let films: String = (plan.films.iter())
        .map(|film| format!(" \\\n  {}", quoted(&film.display().to_string())))
        .collect();
    format!(
        "#!/bin/sh\n# Merges all parts; where one is missing, it says which samples.\nset -eu\ncd {here}\nset --\nfor film in{films}\ndo\n  \
         if [ -s \"$film\" ]; then set -- \"$@\" \"$film\"; fi\ndone\nif [ $# -eq 0 ]; then\n  \
         echo 'no part is there: samples 0..{spp} are missing; nothing was written' >&2\n  exit 1\nfi\nexec {merge} \"$@\"\n",
        here = quoted(&plan.here.display().to_string()),
        spp = plan.spp,
        merge = line(&plan.merge(&[])),
    )
}
