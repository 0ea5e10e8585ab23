//! Text to tokens.

use super::error::ParseError;

/// A word of a formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    Number(f64),
    Name(&'a str),
    /// `+ - * / ^ ( ) , < <= > >= ==`
    Symbol(&'static str),
    End,
}

const SYMBOLS: [&str; 13] = ["<=", ">=", "==", "+", "-", "*", "/", "^", "(", ")", ",", "<", ">"];

impl Token<'_> {
    /// The token as messages name it.
    pub(super) fn describe(self) -> String {
        match self {
            Self::Number(value) => format!("the number {value:?}"),
            Self::Name(name) => format!("`{name}`"),
            Self::Symbol(symbol) => format!("`{symbol}`"),
            Self::End => "the end".into(),
        }
    }
}

/// The tokens of `text` with the bytes they start at; the last is [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<(Token<'_>, usize)>, ParseError> {
    let mut tokens = Vec::new();
    let mut at = 0;
    loop {
        let rest = &text[at..];
        let Some(first) = rest.chars().next() else { break };
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else {
            let (token, length) = token(rest, first, text, at)?;
            tokens.push((token, at));
            length
        };
        at += length;
    }
    tokens.push((Token::End, text.len()));
    Ok(tokens)
}

fn token<'a>(
    rest: &'a str,
    first: char,
    text: &str,
    at: usize,
) -> Result<(Token<'a>, usize), ParseError> {
    if first.is_ascii_digit() || first == '.' {
        let length = number_length(rest.as_bytes());
        return match rest[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((Token::Number(value), length)),
            Ok(_) => Err(ParseError::new(text, at, "a number greater than 1.797e308")),
            Err(_) => Err(ParseError::new(text, at, "a point without digits")),
        };
    }
    if first.is_ascii_alphabetic() || first == '_' {
        let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let length = end.unwrap_or(rest.len());
        return Ok((Token::Name(&rest[..length]), length));
    }
    if let Some(symbol) = SYMBOLS.into_iter().find(|&symbol| rest.starts_with(symbol)) {
        return Ok((Token::Symbol(symbol), symbol.len()));
    }
    let hint = match first {
        '=' => ", equality is `==`".into(),
        '&' => ", use `min(a, b)` for a and b".into(),
        '|' => ", use `max(a, b)` for a or b".into(),
        '[' | '{' => ", use `(`".into(),
        _ => String::new(),
    };
    let first: String = first.escape_default().collect();
    Err(ParseError::new(text, at, format!("unexpected character `{first}`{{}}{hint}")))
}

/// Bytes of `1`, `.5`, `1.`, `1e-3`; an `e` without digits after it is not part of the number.
fn number_length(text: &[u8]) -> usize {
    let digits = |from: usize| text[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut length = digits(0);
    if text.get(length) == Some(&b'.') {
        length += 1 + digits(length + 1);
    }
    if matches!(text.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(length + 1), Some(b'+' | b'-')));
        let exponent = digits((length + 1 + sign).min(text.len()));
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    length
}
