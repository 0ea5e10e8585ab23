//! What a flag that is no number is told.

use clap::Error;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::error::Error as _;
use std::num::{IntErrorKind, ParseFloatError, ParseIntError};

/// The same refusal, saying what is wanted where the parser of a number says only what it met
/// ("invalid digit found in string" of -5).
pub(super) fn explained(error: Error) -> Error {
    let Some((told, wanted)) = wanted(&error) else { return error };
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    Error::raw(error.kind(), text.replace(&told, wanted))
}

/// What the parser says, and what is wanted.
fn wanted(error: &Error) -> Option<(String, &'static str)> {
    let source = match error.kind() {
        ErrorKind::ValueValidation => error.source()?,
        _ => return None,
    };
    if source.is::<ParseFloatError>() {
        return Some((source.to_string(), "a number is wanted"));
    }
    let Some(ContextValue::String(value)) = error.get(ContextKind::InvalidValue) else {
        return None;
    };
    let wanted = match source.downcast_ref::<ParseIntError>()?.kind() {
        IntErrorKind::InvalidDigit if value.parse::<i128>().is_ok() => {
            "a whole number of 0 or more is wanted"
        }
        IntErrorKind::PosOverflow => "a smaller whole number is wanted",
        _ => "a whole number is wanted",
    };
    Some((source.to_string(), wanted))
}

#[cfg(test)]
mod tests {
    use super::explained;
    use crate::cli::command;

    #[test]
    fn numbers_are_refused_with_what_is_wanted() {
        for (flag, value, wanted) in [
            ("--evaluations", "-5", "a whole number of 0 or more is wanted"),
            ("--evaluations", "1.5", "a whole number is wanted"),
            ("--evaluations", "99999999999999999999", "a smaller whole number is wanted"),
            ("--mass", "much", "a number is wanted"),
        ] {
            let line = ["patterns", "curvature", flag, value];
            let error = command().try_get_matches_from(line).unwrap_err();
            let told = explained(error).to_string();
            let start = format!("error: invalid value '{value}' for '{flag} <");
            assert!(told.starts_with(&start) && told.contains(wanted), "{told}");
            assert_eq!(told.matches("error: ").count(), 1, "{told}");
        }
    }
}
