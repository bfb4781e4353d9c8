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
    format!(
        "#!/bin/sh\n# Renders a part: `sh part.sh N`, N from 1 to {count}.\nset -eu\ncd {here}\ncase \"$1\" in\n{cases}  \
         *) echo \"there is no part $1\" >&2; exit 2 ;;\nesac\n[ -s \"$film\" ] && exit 0\nmkdir -p {begun}\n\
         begun={begun}/$(uname -n)-$$.{FILM_EXTENSION}\ntrap 'rm -f \"$begun\"' EXIT\n{render}\nmv \"$begun\" \"$film\"\n",
        count = plan.parts.len(),
        here = quoted(&plan.here.display().to_string()),
    )
}

/// A script that merges all parts.
pub(super) fn merge_script(plan: &Plan) -> String {
    format!(
        "#!/bin/sh\n# Merges all parts; where one is missing, it says which samples.\nset -eu\ncd {}\nexec {}\n",
        quoted(&plan.here.display().to_string()),
        line(&plan.merge())
    )
}
