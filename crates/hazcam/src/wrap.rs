//! Sentences as lines that fit a terminal.

/// Lines of at most 96 characters, broken between words.
pub fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= 96 => line.extend([" ", word]),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        let text = "word ".repeat(40);
        let lines = wrapped(text.trim());
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| line.len() <= 96 && line.ends_with("word")));
        assert_eq!(lines.join(" "), text.trim());
    }
}
