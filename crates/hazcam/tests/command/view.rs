//! `hazcam view`: the page as a file, and at work in a real browser.

use std::path::PathBuf;

use camera::StereoCamera;
use formats::picture::{self, ColourMap, LOG_ERROR_COLOURS};
use raster::{Image, Plane, Reason};
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::folder::Folder;

const COLUMNS: usize = 64;
const ROWS: usize = 48;
/// Where two walls meet: the left one at 40 px, the right one at 20.
const EDGE: usize = COLUMNS / 2;
/// Without a disparity.
const HOLE: (usize, usize) = (5, 40);
const RED: [u8; 3] = [220, 40, 30];
const GREEN: [u8; 3] = [30, 160, 60];
/// Focal length times baseline is 32: depths of 0.8 and 1.6 m.
const CAMERA: &str = "--focal 64 --baseline 0.5";

const VIEW: &str = "view walls.pfm --image left.png --confidence sure.pfm --reasons why.png \
                    --truth truth.pfm -o view.html";

/// Two walls: the left one red, sure and right, the right one green, unsure and 10 px off.
fn folder() -> Folder {
    let folder = Folder::new();
    let walls = |left: f32, right: f32| {
        Plane::from_fn(COLUMNS, ROWS, |x, y| match (x, y) {
            HOLE => f32::NAN,
            _ if x < EDGE => left,
            _ => right,
        })
    };
    for (name, left, right) in
        [("walls.pfm", 40.0, 20.0), ("sure.pfm", 0.75, 0.25), ("truth.pfm", 40.0, 30.0)]
    {
        formats::write_disparity(folder.path(name), &walls(left, right)).unwrap();
    }
    let image = Plane::from_fn(COLUMNS, ROWS, |x, _| if x < EDGE { RED } else { GREEN });
    let reasons = Plane::from_fn(COLUMNS, ROWS, |x, y| match (x, y) {
        HOLE => Reason::MismatchedHole,
        _ if x < EDGE => Reason::Matched,
        _ => Reason::OccludedFilled,
    });
    for (name, colours) in [("left.png", image), ("why.png", picture::reasons(&reasons))] {
        formats::write_image(folder.path(name), &Image::Rgb8(colours)).unwrap();
    }
    folder
}

#[test]
fn a_page_is_written_that_asks_for_nothing() {
    let folder = folder();
    let outcome = folder.run(&format!("{VIEW} {CAMERA}")).done();
    assert_eq!(outcome.stdout, "");
    assert!(outcome.stderr.contains("view.html shows 3071 points of 3072 pixels"));
    let page = std::fs::read_to_string(folder.path("view.html")).unwrap();
    assert!(page.contains("<title>walls.pfm</title>"));
    for outside in ["http:", "https:", "src=\"/", "url(", "@import", "import(", "fetch("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("content=\"default-src 'none';"));
}

#[test]
fn without_a_camera_the_page_and_a_note_say_that_it_is_a_relief() {
    let folder = folder();
    let outcome = folder.run("view walls.pfm -o view.html").done();
    assert!(outcome.stderr.contains("the page shows a relief in pixels"), "{}", outcome.stderr);
    let page = std::fs::read_to_string(folder.path("view.html")).unwrap();
    assert!(page.contains("this is a relief and no shape"));
    let outcome = folder.run(&format!("view walls.pfm {CAMERA} -o view.html")).done();
    assert!(!outcome.stderr.contains("relief"), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("in front of the cameras"), "{}", outcome.stderr);
}

#[test]
fn what_depth_warns_of_is_said_of_a_page_too() {
    let folder = folder();
    // One pixel in four is in front of the cameras.
    let values = [-9.0, -4.0, -2.0, 30.0].repeat(25);
    formats::write_disparity(folder.path("behind.pfm"), &Plane::new(10, 10, values).unwrap())
        .unwrap();
    folder.record("behind.pfm", r#"{"matched": 0.5, "occluded-filled": 0.5}"#);
    let outcome = folder.run(&format!("view behind.pfm {CAMERA} -o view.html")).done();
    for words in
        ["75 of 100 disparities are of nothing in front", "50.0 % of the disparities were filled"]
    {
        assert!(outcome.stderr.contains(words), "{}", outcome.stderr);
    }
}

#[test]
fn what_cannot_be_shown_is_said_and_nothing_is_written() {
    let folder = folder();
    folder.disparities("small.pfm", &[1.0]);
    std::fs::write(folder.path("view.html"), "what was there").unwrap();
    for (arguments, expected) in [
        (
            "-o view.pdf",
            "cannot tell the format of view.pdf from its extension `.pdf`: use one of .html",
        ),
        ("-o no/view.html", "the folder no does not exist"),
        ("-o view.html --image small.pfm", "small.pfm is a PFM file of floats"),
        ("-o view.html --truth small.pfm", "small.pfm is 1 x 1 but walls.pfm is 64 x 48"),
        ("-o view.html --truth truth.pfm --truth-encoding png8/4", "truth.pfm is a PFM file"),
        ("-o view.html --truth-encoding png8/4", "--truth"),
        ("-o view.html --reasons left.png", "row 0 has the colour 220,40,30"),
        (
            "-o view.html --confidence truth.pfm",
            "truth.pfm holds no confidence: the pixel at column 0",
        ),
        ("-o view.html --confidence sure.pfm --min-confidence 2", "give a number from 0 to 1"),
        ("-o view.html --min-confidence 0.5", "--confidence"),
        ("-o view.html --focal 64", "--baseline"),
        ("-o view.html --focal 64 --baseline -1", "the camera's baseline in metres"),
        ("-o view.html --disparity-error 0", "give a number above 0"),
        ("-o view.html --disparity-error 3", "--calibration <FILE>"),
    ] {
        folder.refuses(&format!("view walls.pfm {arguments}"), &[expected]);
    }
    // No input is an HTML file, but one may be named like one.
    std::fs::rename(folder.path("small.pfm"), folder.path("small.html")).unwrap();
    let only = |name: &str, value: f32| {
        formats::write_disparity(folder.path(name), &Plane::filled(5, 4, value)).unwrap();
    };
    only("none.pfm", f32::NAN);
    only("behind.pfm", -3.0);
    let nothing = "none.pfm: no pixel of it has a disparity, so there is nothing to show";
    folder.refuses("view none.pfm -o view.html", &[nothing]);
    let behind = "behind.pfm: none of its disparities is of anything in front of the cameras";
    folder.refuses(&format!("view behind.pfm {CAMERA} -o view.html"), &[behind]);
    folder.refuses("view small.html -o ./small.html", &["would replace an input"]);
    assert_eq!(std::fs::read(folder.path("view.html")).unwrap(), b"what was there");
}

/// A page in a browser on a screen for desks, once it has drawn; `None` where there is no browser.
fn shown(folder: &Folder, options: &str) -> Option<Browser> {
    folder.run(&format!("{VIEW} {options}")).done();
    let mut browser = Browser::start()?;
    browser.screen(1200, 900, "light");
    browser.open(&folder.path("view.html"));
    browser.wait_for("!document.querySelector('main').hasAttribute('aria-busy')");
    Some(browser)
}

/// Where on the screen a pixel's point is.
fn place(browser: &mut Browser, (x, y): (usize, usize)) -> [f64; 2] {
    let place = browser.eval(&format!(
        "(r => eye.placeOf(space.pointOf({}), r.width, r.height).map((side, at) => side + [r.x, \
         r.y][at]))(document.querySelector('#cloud').getBoundingClientRect())",
        y * COLUMNS + x
    ));
    [0, 1].map(|at| place[at].as_f64().unwrap())
}

/// The colours on the screen at these pixels' points.
fn colours(browser: &mut Browser, folder: &Folder, pixels: [(usize, usize); 2]) -> [[u8; 3]; 2] {
    let path = folder.path("screen.png");
    browser.screenshot(&path);
    let screen = picture::image(&formats::read_image(&path).unwrap());
    pixels.map(|pixel| {
        let [x, y] = place(browser, pixel);
        screen.row(y as usize)[x as usize]
    })
}

/// From where both walls are seen whole.
fn look_as_the_left_camera(browser: &mut Browser) {
    browser.click("#left-camera");
    browser.wait_for("JSON.stringify({ ...eye, ...eye.left }) === JSON.stringify(eye)");
}

fn text(browser: &mut Browser, selector: &str) -> String {
    let text = browser.eval(&format!("document.querySelector({selector:?}).textContent"));
    text.as_str().unwrap().to_owned()
}

fn choose(browser: &mut Browser, colouring: &str) {
    browser.eval(&format!(
        "(list => (list.value = {colouring:?}, list.dispatchEvent(new \
         Event('change'))))(document.querySelector('#colouring'))"
    ));
}

const WALLS: [(usize, usize); 2] = [(10, 24), (50, 24)];

#[test]
fn points_stand_where_the_camera_says() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, "--focal 64 --baseline 0.5 --doffs 4 --principal 30,20")
    else {
        return;
    };
    let camera = StereoCamera::new(64.0, 0.5, 4.0, 30.0, 20.0).unwrap();
    // Z = 32 / 44, X = (10 - 30) Z / 64.
    for ((x, y), disparity) in WALLS.into_iter().zip([40.0, 20.0]) {
        let found = browser.eval(&format!("space.pointOf({})", y * COLUMNS + x));
        let expected = camera.point(x as f64, y as f64, disparity).unwrap();
        for at in 0..3 {
            let found = found[at].as_f64().unwrap();
            assert!((found - expected[at]).abs() < 1e-6, "{found} {expected:?}");
        }
    }
    let hole = browser.eval(&format!("space.pointOf({})", HOLE.1 * COLUMNS + HOLE.0));
    assert_eq!(hole[2], Value::Null, "NaN is no JSON");
}

#[test]
fn a_browser_shows_the_points_in_the_colours_that_are_chosen() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, CAMERA) else { return };
    assert_eq!(text(&mut browser, "#count"), "3,071 of 3,071 points are shown.");
    assert_eq!(browser.eval("document.querySelector('#message').hidden"), true);
    let path = folder.path("screen.png");
    browser.screenshot(&path);
    let screen = picture::image(&formats::read_image(&path).unwrap());
    for wall in [RED, GREEN] {
        let count = screen.samples().iter().filter(|&&colour| colour == wall).count();
        assert!(count > 10_000, "{wall:?}: {count}");
    }

    // From where the left camera stood, everything is where it is in its image.
    look_as_the_left_camera(&mut browser);
    let stage = browser.eval(
        "(r => [r.x + r.width / 2, r.y + r.height / 2, Math.min(r.width / 64, r.height / \
         48)])(document.querySelector('#cloud').getBoundingClientRect())",
    );
    let [middle_x, middle_y, zoom] = [0, 1, 2].map(|at| stage[at].as_f64().unwrap());
    for (x, y) in WALLS {
        let [found_x, found_y] = place(&mut browser, (x, y));
        assert!((found_x - middle_x - (x as f64 - 31.5) * zoom).abs() < 1e-3, "{found_x}");
        assert!((found_y - middle_y - (y as f64 - 23.5) * zoom).abs() < 1e-3, "{found_y}");
    }

    let (near, far) = (ColourMap::Turbo.colour(1.0), ColourMap::Turbo.colour(0.0));
    let grey = picture::confidence(&Plane::new(2, 1, vec![0.75, 0.25]).unwrap());
    let [sure, unsure] = [0, 1].map(|at| [grey.samples()[at]; 3]);
    let [matched, occluded] = [Reason::Matched, Reason::OccludedFilled].map(picture::reason_colour);
    // 10 px of 30 are n = 10 / 3.
    let [right, wrong] = [0, 6].map(|step| LOG_ERROR_COLOURS[step]);
    for (colouring, expected) in [
        ("Disparity", [near, far]),
        ("Depth", [near, far]),
        ("Confidence", [sure, unsure]),
        ("Reason", [matched, occluded]),
        ("Error", [right, wrong]),
        ("Left image", [RED, GREEN]),
    ] {
        choose(&mut browser, colouring);
        let found = colours(&mut browser, &folder, WALLS);
        assert_eq!(found, expected, "{colouring}");
    }
    choose(&mut browser, "Disparity");
    let legend = text(&mut browser, "#legend");
    for part in ["20 px", "40 px", "1.6 m", "0.8 m"] {
        assert!(legend.contains(part), "{legend}");
    }
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn points_that_are_not_sure_enough_are_hidden_and_counted() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, &format!("{CAMERA} --min-confidence 0.5")) else {
        return;
    };
    let depth =
        format!("depth walls.pfm {CAMERA} --confidence sure.pfm --min-confidence 0.5 --json");
    let report: Value = serde_json::from_str(&folder.run(&depth).done().stdout).unwrap();
    assert_eq!(report["pixels"]["kept"], 1535);
    let hidden =
        "1,535 of 3,071 points are shown, 1,536 are hidden because they are less sure than that.";
    assert_eq!(text(&mut browser, "#count"), hidden);
    look_as_the_left_camera(&mut browser);
    let [left, right] = colours(&mut browser, &folder, WALLS);
    assert_eq!(left, RED);
    assert!(right != GREEN && right != RED, "{right:?}");
    let move_to = |browser: &mut Browser, value: f32| {
        browser.eval(&format!(
            "(slider => (slider.value = {value}, slider.dispatchEvent(new \
             Event('input'))))(document.querySelector('#least'))"
        ));
    };
    move_to(&mut browser, 0.25);
    assert_eq!(text(&mut browser, "#count"), "3,071 of 3,071 points are shown.");
    assert_eq!(colours(&mut browser, &folder, WALLS), [RED, GREEN]);
    move_to(&mut browser, 0.95);
    assert!(text(&mut browser, "#count").starts_with("0 of 3,071 points"));
    assert_eq!(colours(&mut browser, &folder, WALLS), [right, right]);
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn what_is_pointed_at_is_told_and_marked_everywhere() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, CAMERA) else { return };
    // Not that the mouse stands there already.
    assert!(!text(&mut browser, "#pixel").contains("column"));
    look_as_the_left_camera(&mut browser);
    let at = place(&mut browser, (50, 24));
    browser.mouse("mouseMoved", at);
    let told = text(&mut browser, "#pixel");
    for part in [
        "column 50, row 24",
        "20.000 px",
        "1.6 m",
        // 32 / 21 and 32 / 19
        "\u{b1} 1 px are",
        "1.524 m to 1.684 m",
        "0.25",
        "seen by the left camera only, filled",
        "30.000 px, off by -10.000 px",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let marks = "[...document.querySelectorAll('.mark')].map(mark => mark.hidden)";
    assert_eq!(browser.eval(marks), json!([false, false, false]));
    let mark = "(m => [m.style.left, m.style.top])(document.querySelector('#map + .mark'))";
    let [left, top] = [50.5 / 64.0, 24.5 / 48.0].map(|share: f64| 100.0 * share);
    let found = browser.eval(mark);
    let percent = |at: usize| found[at].as_str().unwrap().trim_end_matches('%').parse::<f64>();
    assert!((percent(0).unwrap() - left).abs() < 0.01 && (percent(1).unwrap() - top).abs() < 0.01);

    // In the map, a pixel without a value: it is no point.
    let at = browser.eval(&format!(
        "(r => [r.x + {} * r.width / 64, r.y + {} * r.height / \
         48])(document.querySelector('#map').getBoundingClientRect())",
        HOLE.0 as f64 + 0.5,
        HOLE.1 as f64 + 0.5
    ));
    browser.mouse("mouseMoved", [0, 1].map(|side| at[side].as_f64().unwrap()));
    let told = text(&mut browser, "#pixel");
    for part in ["column 5, row 40", "Disparitynone", "matched wrongly or ambiguously, left open"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert_eq!(browser.eval(marks), json!([true, false, false]));
    // With the keyboard from there on.
    browser.eval("document.querySelector('#map').focus()");
    browser.press("ArrowRight");
    assert!(text(&mut browser, "#pixel").contains("column 6, row 40"));
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn pictures_stay_where_they_are_while_one_points_at_them() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, CAMERA) else { return };
    for width in [1280, 360] {
        browser.screen(width, 800, "light");
        let top = "document.querySelector('#map').getBoundingClientRect().top + scrollY";
        let before = browser.eval(top);
        // An occluded one, one without a value, a matched one.
        for (x, y) in [(50, 24), HOLE, (20, 10)] {
            browser.eval(&format!("point({y} * 64 + {x})"));
            assert!(text(&mut browser, "#pixel").contains(&format!("column {x}, row {y}")));
            assert_eq!(browser.eval(top), before, "{width} pixels wide, column {x}");
        }
        // What was told there must not be what holds the place.
        browser.eval("element('pixel').replaceChildren()");
    }
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn mouse_and_keys_move_the_points() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, CAMERA) else { return };
    let seen = "JSON.stringify([eye.yaw, eye.pitch, eye.distance, eye.target])";
    let first = browser.eval(seen);
    look_as_the_left_camera(&mut browser);
    let at = place(&mut browser, WALLS[0]);
    browser.mouse("mousePressed", at);
    browser.mouse("mouseMoved", [at[0] + 40.0, at[1] - 25.0]);
    browser.mouse("mouseReleased", [at[0] + 40.0, at[1] - 25.0]);
    let [yaw, pitch] = ["eye.yaw", "eye.pitch"].map(|angle| browser.eval(angle).as_f64().unwrap());
    assert!(
        (yaw - 40.0 * 0.006).abs() < 1e-9 && (pitch + 25.0 * 0.006).abs() < 1e-9,
        "{yaw} {pitch}"
    );
    // The points are drawn where they are said to be now.
    let moved = place(&mut browser, WALLS[0]);
    assert!((moved[0] - at[0]).abs() > 5.0, "{moved:?}");
    assert_eq!(colours(&mut browser, &folder, WALLS), [RED, GREEN]);

    browser.eval("document.querySelector('#cloud').focus()");
    for key in ["ArrowLeft", "ArrowUp", "+", "-"] {
        let before = browser.eval(seen);
        browser.press(key);
        assert_ne!(browser.eval(seen), before, "{key}");
    }
    browser.press("0");
    browser.wait_for(&format!("{seen} === {first}"));
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn without_webgl_a_message_stands_where_the_points_would() {
    let folder = folder();
    folder.run(&format!("{VIEW} {CAMERA}")).done();
    let page = std::fs::read_to_string(folder.path("view.html")).unwrap();
    let without = "<script>{ const all = HTMLCanvasElement.prototype.getContext; \
                   HTMLCanvasElement.prototype.getContext = function (kind, ...more) { return kind \
                   === 'webgl2' ? null : all.call(this, kind, ...more); }; }</script></head>";
    std::fs::write(folder.path("without.html"), page.replace("</head>", without)).unwrap();
    let Some(mut browser) = Browser::start() else { return };
    browser.open(&folder.path("without.html"));
    browser.wait_for("!document.querySelector('main').hasAttribute('aria-busy')");
    let message = text(&mut browser, "#message");
    assert!(message.contains("This browser has no WebGL 2"), "{message}");
    let hidden = "['message', 'cloud'].map(id => document.getElementById(id).hidden)";
    assert_eq!(browser.eval(hidden), json!([false, true]));
    // The pictures still tell their numbers.
    browser.eval("document.querySelector('#left').focus()");
    browser.press("ArrowRight");
    assert!(text(&mut browser, "#pixel").contains("column 33, row 24"));
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn it_can_be_read_on_a_phone_and_in_the_dark() {
    let folder = folder();
    let Some(mut browser) = shown(&folder, CAMERA) else { return };
    let mut grounds = Vec::new();
    for (width, scheme) in [(1200, "light"), (360, "light"), (360, "dark"), (1200, "dark")] {
        browser.screen(width, 740, scheme);
        let overflow = "(e => e.scrollWidth - e.clientWidth)(document.documentElement)";
        for colouring in ["Disparity", "Reason", "Error"] {
            choose(&mut browser, colouring);
            assert_eq!(browser.eval(overflow), 0, "{width} {colouring}");
        }
        let drawn = "(c => [c.width > 0 && c.clientWidth === c.width, c.clientHeight === \
                     c.height])(document.querySelector('#cloud'))";
        assert_eq!(browser.eval(drawn), json!([true, true]), "{width}");
        grounds.push(browser.eval("getComputedStyle(document.body).backgroundColor"));
        if let Some(folder) = std::env::var_os("HAZCAM_TEST_SCREENSHOTS") {
            let folder = PathBuf::from(folder);
            std::fs::create_dir_all(&folder).unwrap();
            browser.screenshot(&folder.join(format!("view-{width}-{scheme}.png")));
        }
    }
    assert_eq!(grounds[0], grounds[1]);
    assert_ne!(grounds[1], grounds[2]);
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}
