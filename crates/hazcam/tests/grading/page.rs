//! The board as a page: complete in itself, and at work in a real browser.

use std::fs;
use std::path::PathBuf;

use crate::board::{ADD, Course};
use crate::browser::Browser;

/// A board with three entrants, one of whom would like to be markup, and its page.
fn exported() -> Option<(Course, PathBuf)> {
    let course = Course::new()?;
    for (matcher, id) in [
        ("fast:best", "Alice & Bob"),
        ("fast:fast", "<script>alert(1)</script>"),
        ("balanced:balanced", "zebra"),
    ] {
        let mut arguments = ADD.to_vec();
        arguments.extend(["--matcher", matcher, "--owner", id, "--secret-id", id]);
        course.done(&arguments);
    }
    course.done(&["export", "board.html", "--title", "Stereo <2026>"]);
    let page = course.0.path("board.html");
    Some((course, page))
}

#[test]
fn it_is_complete_in_itself_and_escapes_names() {
    let Some((course, path)) = exported() else { return };
    let page = fs::read_to_string(&path).unwrap();
    for outside in ["http:", "https:", "src=\"/", "url(", "@import", "import("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("<title>Stereo &lt;2026&gt;</title>"));
    assert!(
        page.contains("&lt;script&gt;alert(1)&lt;/script&gt;") && !page.contains("<script>alert")
    );
    assert!(page.contains("Alice &amp; Bob"));
    // Two tests a person with truth, disparity and error; those of the hold-out stay secret.
    assert_eq!(page.matches("data:image/png;base64,").count(), 3 * 2 * 3);
    assert!(page.contains("score = ( E<sub>RMS</sub> / 5 px + p<sub>bad</sub> / 0.11 ) / 2"));
    course.done(&["export", "all.html", "--reveal-holdout"]);
    let all = fs::read_to_string(course.0.path("all.html")).unwrap();
    assert_eq!(all.matches("data:image/png;base64,").count(), 3 * 3 * 3);
}

/// The names in the table, from top to bottom.
const NAMES: &str = "[...document.querySelectorAll('tbody td:nth-child(2) a')].map(a => \
                     a.textContent).slice(0, 3)";

#[test]
fn a_browser_sorts_opens_and_closes_without_complaint() {
    let Some((_course, path)) = exported() else { return };
    let Some(mut browser) = Browser::start() else { return };
    browser.screen(1200, 900, "light");
    browser.open(&path);
    let ranked = browser.eval(NAMES);
    assert_eq!(ranked.as_array().unwrap().len(), 3);

    browser.click("th:nth-child(2) button");
    let rising = browser.eval(NAMES);
    assert_eq!(rising, serde_json::json!(["<script>alert(1)</script>", "Alice & Bob", "zebra"]));
    assert_eq!(browser.eval("document.querySelectorAll('th[aria-sort]').length"), 1);
    browser.click("th:nth-child(2) button");
    let mut falling = browser.eval(NAMES);
    falling.as_array_mut().unwrap().reverse();
    assert_eq!(falling, rising);
    for column in 3..=9 {
        browser.click(&format!("th:nth-child({column}) button"));
        let keys = browser.eval(&format!(
            "[...document.querySelectorAll('.sortable td:nth-child({column})')].map(c => \
             +c.dataset.key)"
        ));
        let keys: Vec<f64> =
            keys.as_array().unwrap().iter().map(|key| key.as_f64().unwrap()).collect();
        assert!(keys.is_sorted(), "column {column}: {keys:?}");
    }
    browser.click("th:nth-child(1) button");
    assert_eq!(browser.eval(NAMES), ranked);

    let open = "document.querySelector('section.entrant:target')?.getAttribute('aria-label') ?? ''";
    assert_eq!(browser.eval(open), "");
    browser.click("tbody tr:nth-child(1) a");
    assert_eq!(browser.eval(open), ranked[0]);
    let drawn = "[...document.querySelectorAll('section.entrant:target img')].map(i => \
                 i.decode().then(() => i.naturalWidth > 0, () => false))";
    let drawn = browser.eval(&format!("Promise.all({drawn})"));
    assert_eq!(drawn, serde_json::json!([true, true, true, true, true, true]));
    // What it hides cannot get the keyboard's focus.
    let focused =
        "(b => (b.focus(), document.activeElement === b))(document.querySelector('th button'))";
    assert_eq!(browser.eval(focused), false);
    browser.press("Escape");
    assert_eq!(browser.eval(open), "");
    assert_eq!(browser.eval("document.activeElement.textContent"), ranked[0]);
    assert_eq!(browser.eval(focused), true);
    browser.click("tbody tr:nth-child(2) a");
    browser.click("section.entrant:target .close");
    assert_eq!(browser.eval(open), "");
    // The dots of the plot lead to the same place.
    browser.click(".pareto circle");
    assert_ne!(browser.eval(open), "");
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn it_can_be_read_on_a_phone_and_in_the_dark() {
    let Some((_course, path)) = exported() else { return };
    let Some(mut browser) = Browser::start() else { return };
    let mut grounds = Vec::new();
    for (width, colours) in [(1200, "light"), (360, "light"), (360, "dark"), (1200, "dark")] {
        browser.screen(width, 740, colours);
        browser.open(&path);
        let table = "(e => e.scrollWidth - e.clientWidth)(document.querySelector('.scroll'))";
        assert_eq!(browser.eval(table), 0, "{width}: the ranking has to be scrolled");
        for hash in ["#board", "#entrant-1"] {
            browser.eval(&format!("location.hash = '{hash}'"));
            let shown = "document.querySelector('section.entrant:target') ?? document.body";
            let overflow = browser.eval(&format!(
                "[(e => e.scrollWidth - e.clientWidth)(document.documentElement), (e => e.scrollWidth - \
                 e.clientWidth)({shown})]"
            ));
            assert_eq!(overflow, serde_json::json!([0, 0]), "{width} {hash}");
            let smallest = browser.eval(&format!(
                "Math.min(...[...({shown}).querySelectorAll('td, p, h1, h2, figcaption')].map(e => \
                 parseFloat(getComputedStyle(e).fontSize)))"
            ));
            assert!(smallest.as_f64().unwrap() >= 14.0, "{width} {hash}: {smallest}");
            // Contrast of text on its ground, as WCAG 2 defines it; 4.5 is asked of small text.
            let contrast = browser.eval(&format!("({CONTRAST})({shown})"));
            assert!(contrast.as_f64().unwrap() >= 4.5, "{width} {colours} {hash}: {contrast}");
        }
        grounds.push(browser.eval("getComputedStyle(document.body).backgroundColor"));
        if let Some(folder) = std::env::var_os("HAZCAM_TEST_SCREENSHOTS") {
            let folder = PathBuf::from(folder);
            fs::create_dir_all(&folder).unwrap();
            browser.screenshot(&folder.join(format!("entrant-{width}-{colours}.png")));
            browser.eval("location.hash = '#board'");
            browser.eval("scrollTo(0, 0)");
            browser.screenshot(&folder.join(format!("board-{width}-{colours}.png")));
        }
    }
    assert_eq!(grounds[0], grounds[1]);
    assert_ne!(grounds[1], grounds[2]);
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

/// The lowest contrast of any text below an element on the ground it stands on.
const CONTRAST: &str = "root => {
  const light = colour => {
    const [r, g, b] = colour.match(/[\\d.]+/g).map(Number).map(v => v / 255)
      .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const ground = e => {
    for (; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (colour !== 'rgba(0, 0, 0, 0)') return colour;
    }
    return 'rgb(255, 255, 255)';
  };
  return Math.min(...[...root.querySelectorAll('td, th, p, h1, h2, h3, a, figcaption')]
    .filter(e => e.textContent.trim() && !e.closest('svg')).map(e => {
      const [a, b] = [light(getComputedStyle(e).color), light(ground(e))];
      return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    }));
}";
