//! Text inside HTML and XML, for whoever writes pages and reports.

/// Text that markup can hold: its special characters escaped, and characters that no XML may
/// contain replaced.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_stays_text() {
        assert_eq!(
            escaped("<a href='\"x\"'>&\x07\n"),
            "&lt;a href=&#39;&quot;x&quot;&#39;&gt;&amp;\u{fffd}\n"
        );
    }
}
