//! The names on a leaderboard. They come from people who are not trusted and stand beside others' on pages and in
//! spreadsheets: none may be invisible, look like another, spill over its neighbours or be a formula.

use unicode_normalization::UnicodeNormalization;
use unicode_normalization::char::is_combining_mark;
use unicode_security::skeleton;

/// A text that begins with one of these is a formula to spreadsheets.
pub(crate) const BEGINS_A_FORMULA: [char; 4] = ['=', '+', '-', '@'];
/// Accents that may follow one another.
const MOST_MARKS: usize = 2;

/// Whether this can be a secret ID: 4 to 32 printable characters, no space at an end, none of `= + - @` at the
/// beginning (spreadsheets take it for a formula), no accent without a letter and at most two on one, spaces that
/// are plain ones. `inspecting.py` refuses at least the same, and tells the author why.
pub fn is_secret_id(text: &str) -> bool {
    let marks = text.split(|c| !is_combining_mark(c)).map(|marks| marks.chars().count());
    (4..=32).contains(&text.chars().count())
        && !text.chars().any(|c| c.is_control() || is_unseen(c))
        && text.trim() == text
        && !text.starts_with(BEGINS_A_FORMULA)
        && !text.starts_with(is_combining_mark)
        && marks.max().unwrap_or(0) <= MOST_MARKS
}

/// Characters by which one name could look like another: zero-width ones, marks of direction, tags, letters without
/// a picture, spaces that are not the usual one.
fn is_unseen(c: char) -> bool {
    let is_invisible = matches!(c, '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{17b4}'..='\u{17b5}'
        | '\u{180b}'..='\u{180f}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
        | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e01ef}');
    let is_blank = matches!(c, '\u{115f}' | '\u{1160}' | '\u{2800}' | '\u{3164}' | '\u{ffa0}');
    is_invisible || is_blank || (c != ' ' && c.is_whitespace())
}

/// What names that are one name share: letter case, the ways to write an accent or a letter's width, and how many
/// spaces stand between words make no difference.
pub(crate) fn folded(secret_id: &str) -> String {
    let lower: String = secret_id.nfkc().flat_map(char::to_lowercase).nfkc().collect();
    lower.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Whether nobody could tell two names apart that are written with other letters: a Cyrillic o, a one or a capital i for
/// an l (Unicode Technical Standard 39, confusables). As they are written and in lower case: an I looks like an l, an i
/// does not.
pub(crate) fn look_alike(one: &str, other: &str) -> bool {
    let [one_as_it_is, other_as_it_is] = [one, other].map(|id| id.nfkc().collect::<String>());
    skeleton(&folded(one)).eq(skeleton(&folded(other)))
        || skeleton(&one_as_it_is).eq(skeleton(&other_as_it_is))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_secret_id_is_short_and_can_be_seen() {
        for good in ["abcd", "Jaff Bozos", "Ünïcödé ✓", "Jose\u{301}", "a-b+c@d=", &"x".repeat(32)]
        {
            assert!(is_secret_id(good), "{good:?}");
        }
        let tower = format!("A{}", "\u{301}".repeat(3));
        for bad in [
            "abc",
            &"x".repeat(33),
            "a\nbcd",
            " abcd",
            "abcd ",
            "ab\u{a0}cd",
            "=1+1",
            "+abc",
            "-abc",
            "@abc",
            "\u{301}abc",
            &format!("abc{tower}"),
        ] {
            assert!(!is_secret_id(bad), "{bad:?}");
        }
    }

    #[test]
    fn what_has_no_picture_is_no_part_of_one() {
        let unseen = [
            '\u{ad}',
            '\u{61c}',
            '\u{180e}',
            '\u{200b}',
            '\u{202e}',
            '\u{feff}',
            '\u{e0041}',
            '\u{fe0f}',
            '\u{3164}',
            '\u{2800}',
            '\u{115f}',
            '\u{1160}',
            '\u{ffa0}',
            '\u{3000}',
            '\u{2003}',
        ];
        for unseen in unseen {
            assert!(!is_secret_id(&format!("ab{unseen}cd")), "{unseen:?}");
        }
    }

    #[test]
    fn names_that_look_alike_are_one_name() {
        for (one, other) in [
            ("Nam_Good", "nam_good"),
            ("Jos\u{e9} X", "Jose\u{301} X"),
            ("nam good", "nam  good"),
            ("\u{ff2e}\u{ff41}\u{ff4d}_x", "nam_x"),
        ] {
            assert_eq!(folded(one), folded(other), "{one:?}");
        }
        assert_ne!(folded("José"), folded("Jose"));
        for other in ["R\u{43e}ver Fan 1", "rover f\u{430}n l", "Rover Fan 1"] {
            assert!(look_alike("Rover Fan 1", other), "{other:?}");
        }
        for (one, other) in
            [("Iris Team", "lris Team"), ("ROVER FAN", "R0VER FAN"), ("Il1I", "lIIl")]
        {
            assert!(look_alike(one, other), "{one:?} {other:?}");
        }
        for other in ["Rover Fan 2", "Rover Fun 1", "R\u{f6}ver Fan 1"] {
            assert!(!look_alike("Rover Fan 1", other), "{other:?}");
        }
        assert_eq!(folded("Plain Name-1"), "plain name-1");
    }
}
