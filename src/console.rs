//! The two streams: results on stdout, `error:` and `warning:` on stderr.
//!
//! All text the program prints goes through here, so here it is decided whether messages are text for people or JSON for
//! editors (`--message-format`), that nothing of a file's text can steer a terminal ([`printable`]), and whether there are
//! colours. A reader that closed its end (`patina devices | head -1`) is no error and must not panic, which is why
//! `println!` isn't used; a disk that is full is one ([`failure`]).

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;

use anstream::{AutoStream, ColorChoice};
use clap::ValueEnum;
use clap::builder::styling::{AnsiColor, Style};
use texgen::diagnostic::must_be_escaped;
pub(crate) use texgen::diagnostic::printable;
use texgen::{Diagnostic, Diagnostics, Severity};

pub(crate) use engine::stats::grouped;

/// How errors and warnings are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// For people: source lines with carets.
    Text,
    /// For programs: one JSON object per line.
    Json,
}

static FORMAT: OnceLock<MessageFormat> = OnceLock::new();
static QUIET: AtomicBool = AtomicBool::new(false);
/// Why stdout takes nothing any more.
static BROKEN: Mutex<Option<io::Error>> = Mutex::new(None);

/// Chooses the format of all messages; the first choice holds.
pub(crate) fn set_format(format: MessageFormat) {
    let _ = FORMAT.set(format);
}

/// Whether messages are JSON.
pub(crate) fn is_json() -> bool {
    FORMAT.get() == Some(&MessageFormat::Json)
}

/// From now on there are neither notes nor progress.
pub(crate) fn set_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether notes and progress are unwanted.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a result line (or several) to stdout.
pub(crate) fn print(text: &str) {
    to_stdout(&format!("{}\n", printable(text.trim_end())));
}

/// A time as the flags take it: `90s`, `10m`, `1h30m`.
pub(crate) fn duration(time: Duration) -> String {
    let seconds = time.as_secs();
    let parts = [
        (seconds / 3600, "h"),
        (seconds / 60 % 60, "m"),
        (seconds % 60, "s"),
    ];
    let shown = parts.into_iter().filter(|(count, _)| *count > 0);
    let text: String = shown
        .map(|(count, unit)| format!("{count}{unit}"))
        .collect();
    match text.is_empty() {
        true => format!("{}s", time.as_secs_f64()),
        false => text,
    }
}

/// A number with three digits that count.
pub(crate) fn significant(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - number.abs().max(1e-12).log10().floor() as i32;
    format!("{number:.*}", digits.clamp(0, 12) as usize)
}

/// Prints to stdout what was done, unless that is unwanted.
pub(crate) fn note(text: &str) {
    if !is_quiet() {
        print(text);
    }
}

/// Prints a line about the progress to stderr.
pub(crate) fn progress(text: &str) {
    to_stderr(&format!("{}\n", printable(text)));
}

/// Prints an error to stderr. A text that already says `error:` (a diagnostic with source lines) is left as it is.
pub(crate) fn error(text: &str) {
    say(Severity::Error, text);
}

/// Prints a warning to stderr.
pub(crate) fn warning(text: &str) {
    say(Severity::Warning, text);
}

/// Prints errors and warnings with their places to stderr.
pub(crate) fn diagnostics(diagnostics: &Diagnostics) {
    let columns = columns_of(io::stderr());
    let colors = AutoStream::choice(&io::stderr()) != ColorChoice::Never;
    to_stderr(&shown(diagnostics, columns, colors));
}

/// Prints errors and warnings with their places to stdout: there they are the result.
pub(crate) fn print_diagnostics(diagnostics: &Diagnostics) {
    let columns = columns_of(io::stdout());
    let colors = AutoStream::choice(&io::stdout()) != ColorChoice::Never;
    to_stdout(&shown(diagnostics, columns, colors));
}

/// How wide the terminal is that a stream goes to; none where it goes to a file or a program, whose lines stay whole.
#[cfg(unix)]
fn columns_of(stream: impl std::os::fd::AsFd) -> Option<usize> {
    terminal_size::terminal_size_of(stream).map(|(width, _)| width.0.into())
}

/// How wide the terminal is that a stream goes to.
#[cfg(windows)]
fn columns_of(stream: impl std::os::windows::io::AsHandle) -> Option<usize> {
    terminal_size::terminal_size_of(stream).map(|(width, _)| width.0.into())
}

/// What kept stdout from taking all that was printed. That its reader had enough is no failure.
pub(crate) fn failure() -> Option<String> {
    let broken = BROKEN.lock().unwrap_or_else(PoisonError::into_inner);
    let error = broken.as_ref()?;
    (error.kind() != io::ErrorKind::BrokenPipe)
        .then(|| format!("cannot write to the standard output: {error}"))
}

/// Keeps that something could not be written to stdout, see [`failure`].
pub(crate) fn stdout_outcome(outcome: io::Result<()>) {
    if let Err(error) = outcome {
        let mut broken = BROKEN.lock().unwrap_or_else(PoisonError::into_inner);
        broken.get_or_insert(error);
    }
}

/// JSON escapes control characters of ASCII; a terminal may know others.
fn printable_json(json: &str) -> String {
    let mut shown = String::with_capacity(json.len());
    for c in json.chars() {
        match must_be_escaped(c) {
            // All of them have four digits, and appear in strings only.
            true => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => shown.push(c),
        }
    }
    shown
}

fn to_stdout(text: &str) {
    let mut stdout = anstream::stdout().lock();
    stdout_outcome(
        stdout
            .write_all(text.as_bytes())
            .and_then(|()| stdout.flush()),
    );
}

fn to_stderr(text: &str) {
    // There is no place left to say that it failed.
    let _ = anstream::stderr().lock().write_all(text.as_bytes());
}

fn shown(diagnostics: &Diagnostics, columns: Option<usize>, colors: bool) -> String {
    if is_json() {
        return printable_json(&diagnostics.to_json_lines());
    }
    let text = columns.map_or_else(
        || diagnostics.render(),
        |columns| diagnostics.render_within(columns),
    );
    let text = match colors {
        true => colored(&printable(&text)),
        false => printable(&text).into_owned(),
    };
    match text.is_empty() {
        true => text,
        false => text + "\n",
    }
}

/// The text with its heads, `error:` and `warning:` at the beginning of lines, in colour.
fn colored(text: &str) -> String {
    let color = |color: AnsiColor| Style::new().bold().fg_color(Some(color.into()));
    let heads = [
        (Severity::Error, color(AnsiColor::Red)),
        (Severity::Warning, color(AnsiColor::Yellow)),
    ];
    let line = |line: &str| {
        let head = heads.iter().find_map(|(severity, style)| {
            let rest = line.strip_prefix(severity.as_str())?;
            let rest = rest.strip_prefix(':')?;
            Some(format!("{style}{}:{style:#}{rest}", severity.as_str()))
        });
        head.unwrap_or_else(|| line.to_owned())
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

fn say(severity: Severity, text: &str) {
    let (word, text) = (severity.as_str(), text.trim_end());
    let line = if is_json() {
        let message = text.strip_prefix(word).and_then(|t| t.strip_prefix(": "));
        let bare = Diagnostic::error(message.unwrap_or(text));
        printable_json(&Diagnostic { severity, ..bare }.to_json())
    } else {
        let text = match text.starts_with(word) {
            true => text.to_owned(),
            false => format!("{word}: {text}"),
        };
        let text = printable(&text);
        match AutoStream::choice(&io::stderr()) {
            ColorChoice::Never => text.into_owned(),
            _ => colored(&text),
        }
    };
    to_stderr(&format!("{line}\n"));
}

/// A number of bytes in the largest binary unit that keeps it above one.
pub(crate) fn bytes(count: u64) -> String {
    const UNITS: [&str; 5] = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = count as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 {
        format!("{count} B")
    } else {
        format!("{value:.1} {}", UNITS[unit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_steers_a_terminal() {
        let name = "a\u{1b}]0;owned\u{7}b\u{9b}31m\u{202e}c\r\n\td\re";
        let shown = printable(name);
        assert_eq!(
            shown,
            "a\\u{1b}]0;owned\\u{7}b\\u{9b}31m\\u{202e}c\n\td\\u{d}e"
        );
        assert!(matches!(
            printable("Größe 世\n"),
            std::borrow::Cow::Borrowed(_)
        ));
        let json = printable_json("\"\u{9b}\u{202e}\"");
        let read: String = serde_json::from_str(&json).expect("JSON");
        assert_eq!(
            (json.as_str(), read.as_str()),
            ("\"\\u009b\\u202e\"", "\u{9b}\u{202e}")
        );
    }

    #[test]
    fn heads_have_colours_and_nothing_else_has() {
        let text = colored("error: no\n  error: quoted\nwarning: odd");
        assert!(text.starts_with("\u{1b}[1m") && text.contains("\n  error: quoted\n"));
        assert_eq!(text.matches("\u{1b}[0m").count(), 2, "{text:?}");
    }

    #[test]
    fn bytes_are_shown_in_a_readable_unit() {
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(128 << 20), "128.0 MiB");
        assert_eq!(bytes(u64::MAX), "16777216.0 TiB");
    }
}
