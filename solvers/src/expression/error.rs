//! What is wrong with a formula, and where.

use std::fmt;

/// Characters shown on either side of the place of an error.
const CONTEXT: usize = 36;

/// A formula that could not be read: the reason, the place, and a line that points at it.
///
/// ```
/// let error = solvers::expression::Expression::parse("u * w", &["u", "v"]).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "unknown name `w` at column 5, did you mean `u`? known names: u, v, e, pi, tau\n  \
///        u * w\n      ^"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseError {
    message: String,
    line: usize,
    column: usize,
    excerpt: String,
    caret: usize,
    lines: usize,
}

impl ParseError {
    /// `message` at the byte `at` of `text`; it may hold one `{}` for the place.
    pub(super) fn new(text: &str, at: usize, message: impl Into<String>) -> Self {
        let before = &text[..at];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = text[start..at].chars().count();
        let line: Vec<char> = text[start..].chars().take_while(|&c| c != '\n').collect();
        let (first, last) = (column.saturating_sub(CONTEXT), (column + CONTEXT).min(line.len()));
        let plain = |&c: &char| if c.is_control() { ' ' } else { c };
        Self {
            message: message.into(),
            line: before.matches('\n').count() + 1,
            column: column + 1,
            excerpt: line[first..last].iter().map(plain).collect(),
            caret: column - first,
            lines: text.lines().count(),
        }
    }

    /// What is wrong, without the place.
    pub fn message(&self) -> String {
        self.message.replace("{}", "")
    }

    /// Line of the error, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// Column of the error in its line, in characters, from 1.
    pub fn column(&self) -> usize {
        self.column
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut place = format!(" at column {}", self.column);
        if self.lines > 1 {
            place += &format!(" of line {}", self.line);
        }
        let message = match self.message.contains("{}") {
            true => self.message.replace("{}", &place),
            false => format!("{}{place}", self.message),
        };
        write!(f, "{message}\n  {}\n  {:caret$}^", self.excerpt, "", caret = self.caret)
    }
}

impl std::error::Error for ParseError {}

impl From<ParseError> for crate::Error {
    fn from(error: ParseError) -> Self {
        Self::Invalid(error.to_string())
    }
}

/// The word of `known` nearest to `word` by edits, if it is near at all: at most one edit
/// for every two letters. Of equally near words one of the same length.
pub(super) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let distance = |other: &str| {
        let lengths = word.len().abs_diff(other.len());
        (edits(&word.to_lowercase(), &other.to_lowercase()), lengths)
    };
    let best = known.iter().map(|&other| (distance(other), other)).min_by_key(|&(d, _)| d)?;
    (best.0.0 <= word.chars().count().div_ceil(2)).then_some(best.1)
}

/// Insertions, deletions, substitutions and swaps of neighbours between two words (the
/// restricted distance of Damerau).
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut table = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                table[i][j] = i + j;
                continue;
            }
            let substituted = table[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = substituted.min(table[i - 1][j] + 1).min(table[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(table[i - 2][j - 2] + 1);
            }
            table[i][j] = least;
        }
    }
    table[a.len()][b.len()]
}
