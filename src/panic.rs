//! What a mistake in the program looks like to the user. The exit code is then 101.

use std::io::Write;

/// Shows a short apology and what to report instead of a backtrace.
pub(crate) fn install() {
    std::panic::set_hook(Box::new(|info| {
        let what = info
            .payload()
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| info.payload().downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "unknown".into());
        let place = info.location().map_or_else(String::new, |at| format!(" ({}:{})", at.file(), at.line()));
        let command: Vec<String> = std::env::args_os().map(|word| quoted(&word.to_string_lossy())).collect();
        let mut text = format!(
            "internal error: {what}{place}\n\
             Sorry: this is a mistake in aam, not in what you did. Please report it together with this:\n  \
             version: aam {} on {} {}\n  \
             command: {}\n",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH,
            command.join(" "),
        );
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
            text.push_str(&std::backtrace::Backtrace::force_capture().to_string());
        } else {
            text.push_str("  (RUST_BACKTRACE=1 shows where it happened)\n");
        }
        // Nobody is left to tell when standard error is gone.
        let _ = anstream::stderr().write_all(text.as_bytes());
    }));
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%#".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
