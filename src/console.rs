//! The two streams: results on stdout, `error:` and `warning:` on stderr.
//!
//! All text the program prints goes through here, so here it is decided whether messages are text for people or JSON for
//! editors (`--message-format`). A reader that closed its end (`patina devices | head -1`) is not
//! an error and must not panic, which is why `println!` isn't used.

use std::io::{self, Write};
use std::sync::OnceLock;

use clap::ValueEnum;
use texgen::{Diagnostic, Diagnostics, Severity};

/// How errors and warnings are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MessageFormat {
    /// For people: source lines with carets.
    Text,
    /// For programs: one JSON object per line.
    Json,
}

static FORMAT: OnceLock<MessageFormat> = OnceLock::new();

/// Chooses the format of all messages; the first choice holds.
pub(crate) fn set_format(format: MessageFormat) {
    let _ = FORMAT.set(format);
}

/// Whether messages are JSON.
pub(crate) fn is_json() -> bool {
    FORMAT.get() == Some(&MessageFormat::Json)
}

/// Prints a result line (or several) to stdout.
pub(crate) fn print(text: &str) {
    let _ = writeln!(io::stdout().lock(), "{}", text.trim_end());
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
    let _ = write!(io::stderr().lock(), "{}", shown(diagnostics));
}

/// Prints errors and warnings with their places to stdout: there they are the result.
pub(crate) fn print_diagnostics(diagnostics: &Diagnostics) {
    let _ = write!(io::stdout().lock(), "{}", shown(diagnostics));
}

fn shown(diagnostics: &Diagnostics) -> String {
    if is_json() {
        return diagnostics.to_json_lines();
    }
    let text = diagnostics.render();
    match text.is_empty() {
        true => text,
        false => text + "\n",
    }
}

fn say(severity: Severity, text: &str) {
    let (word, text) = (severity.as_str(), text.trim_end());
    let line = if is_json() {
        let message = text.strip_prefix(word).and_then(|t| t.strip_prefix(": "));
        let bare = Diagnostic::error(message.unwrap_or(text));
        Diagnostic { severity, ..bare }.to_json()
    } else if text.starts_with(word) {
        text.to_owned()
    } else {
        format!("{word}: {text}")
    };
    let _ = writeln!(io::stderr().lock(), "{line}");
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

/// A rate with three digits or so: 950, 27.2 k, 1.31 M. What is no positive number is shown as 0.
pub(crate) fn short(rate: f64) -> String {
    if rate >= 999.5e6 {
        format!("{:.3} G", rate / 1.0e9)
    } else if rate >= 999.5e3 {
        format!("{:.2} M", rate / 1.0e6)
    } else if rate >= 999.5 {
        format!("{:.1} k", rate / 1.0e3)
    } else {
        format!("{:.0}", rate.max(0.0))
    }
}

/// A count with thousands separated by commas.
pub(crate) fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_shown_in_a_readable_unit() {
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(1023), "1023 B");
        assert_eq!(bytes(1536), "1.5 KiB");
        assert_eq!(bytes(128 << 20), "128.0 MiB");
        assert_eq!(bytes(u64::MAX), "16777216.0 TiB");
    }

    #[test]
    fn rates_are_shown_with_few_digits() {
        assert_eq!(short(f64::NAN), "0");
        assert_eq!(short(-3.0), "0");
        assert_eq!(short(950.4), "950");
        assert_eq!(short(27_156.1), "27.2 k");
        assert_eq!(short(1.314e6), "1.31 M");
        assert_eq!(short(2.5e9), "2.500 G");
    }

    #[test]
    fn counts_are_grouped_by_three() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(grouped(12_345_678), "12,345,678");
    }
}
