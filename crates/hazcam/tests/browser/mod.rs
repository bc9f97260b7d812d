//! A headless Chromium, driven over its DevTools protocol as far as the tests of pages need it.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

use crate::skip::skip;

/// Names under which Chromium is known.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A process that ends when it is dropped.
struct Running(Child);

/// A browser with one page. It ends when it is dropped.
pub struct Browser {
    _running: Running,
    socket: WebSocket<MaybeTlsStream<std::net::TcpStream>>,
    session: Option<String>,
    last_id: u64,
    /// Errors and warnings on the page's console, exceptions, and whatever it tried to load.
    complaints: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts it; `None`, after one line on stderr, where there is none.
    pub fn start() -> Option<Self> {
        let Some(program) = find() else {
            skip(&format!("there is no Chromium: none of {} is on PATH", NAMES.join(", ")));
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        let mut command = Command::new(program);
        command.arg("--headless").arg("--remote-debugging-port=0");
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        // What it keeps beside that would stay when it is killed.
        command.env("TMPDIR", profile.path());
        // It opens only what these tests wrote, and its own sandbox refuses to run as root.
        command.args(["--no-sandbox", "--no-first-run", "--disable-sync"]);
        // WebGL on the processor: what a machine's graphics would draw is nobody's to know.
        command.args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]);
        command.args(["--disable-background-networking", "--disable-component-update"]);
        let child =
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let running = Running(child.unwrap());
        let port = profile.path().join("DevToolsActivePort");
        let started = Instant::now();
        let port = loop {
            let told = std::fs::read_to_string(&port).unwrap_or_default();
            if let [port, path] = told.lines().collect::<Vec<_>>()[..] {
                break format!("ws://127.0.0.1:{port}{path}");
            }
            assert!(started.elapsed() < Duration::from_secs(60), "Chromium does not start");
            std::thread::sleep(Duration::from_millis(20));
        };
        let (socket, _) = tungstenite::connect(port).unwrap();
        let complaints = Vec::new();
        let mut browser = Self {
            _running: running,
            socket,
            session: None,
            last_id: 0,
            complaints,
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let attached = browser.call(
            "Target.attachToTarget",
            json!({ "targetId": target["targetId"], "flatten": true }),
        );
        browser.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Opens a file and waits until it is loaded.
    pub fn open(&mut self, file: &Path) {
        self.call("Page.navigate", json!({ "url": format!("file://{}", file.display()) }));
        self.wait_for("document.readyState + location.protocol === 'completefile:'");
    }

    /// Waits until an expression on the page is true.
    pub fn wait_for(&mut self, expression: &str) {
        let started = Instant::now();
        while self.eval(expression) != true {
            assert!(started.elapsed() < Duration::from_secs(60), "never true: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The value of an expression on the page, once it has drawn what came before.
    pub fn eval(&mut self, expression: &str) -> Value {
        let wrapped = format!(
            "new Promise(done => requestAnimationFrame(() => setTimeout(() => done({expression}))))"
        );
        let parameters =
            json!({ "expression": wrapped, "awaitPromise": true, "returnByValue": true });
        let answer = self.call("Runtime.evaluate", parameters);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Clicks the middle of the first element that fits the selector, as a mouse does.
    pub fn click(&mut self, selector: &str) {
        let place = self.eval(&format!(
            "(e => (e.scrollIntoView({{ block: 'center' }}), (r => [r.x + r.width / 2, r.y + \
             r.height / 2])(e.getBoundingClientRect())))(document.querySelector({selector:?}))"
        ));
        let place = [0, 1].map(|at| place[at].as_f64().unwrap());
        for kind in ["mousePressed", "mouseReleased"] {
            self.mouse(kind, place);
        }
    }

    /// What the mouse does at a place: `mousePressed`, `mouseMoved`, `mouseReleased`.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        self.call(
            "Input.dispatchMouseEvent",
            json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": 1 }),
        );
    }

    /// Presses a key.
    pub fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "code": key }));
        }
    }

    /// Shows the page on a screen of this size, in these colours ("light", "dark").
    pub fn screen(&mut self, width: u32, height: u32, colours: &str) {
        self.call(
            "Emulation.setDeviceMetricsOverride",
            json!({ "width": width, "height": height, "deviceScaleFactor": 1,
                    "mobile": width < 600 }),
        );
        let feature = json!([{ "name": "prefers-color-scheme", "value": colours }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": feature }));
    }

    /// Writes what the screen shows to a PNG file.
    pub fn screenshot(&mut self, file: &Path) {
        use base64::Engine;
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes = base64::prelude::BASE64_STANDARD.decode(answer["data"].as_str().unwrap());
        std::fs::write(file, bytes.unwrap()).unwrap();
    }

    /// What the page complained about so far.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }

    /// Calls a method of the browser, or of the page once there is one.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last_id += 1;
        let mut message = json!({ "id": self.last_id, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let heard: Value = serde_json::from_str(&text).unwrap();
            if heard["id"] == self.last_id {
                assert!(heard.get("error").is_none(), "{method}: {heard}");
                return heard["result"].clone();
            }
            self.hear(&heard);
        }
    }

    fn hear(&mut self, event: &Value) {
        let parameters = &event["params"];
        let complains = match event["method"].as_str().unwrap_or_default() {
            "Runtime.exceptionThrown" => true,
            "Runtime.consoleAPICalled" => {
                ["error", "warning", "assert"].contains(&parameters["type"].as_str().unwrap())
            }
            "Log.entryAdded" => {
                ["error", "warning"].contains(&parameters["entry"]["level"].as_str().unwrap())
            }
            "Network.requestWillBeSent" => {
                let url = parameters["request"]["url"].as_str().unwrap();
                !url.starts_with("file://") && !url.starts_with("data:")
            }
            _ => false,
        };
        if complains {
            self.complaints.push(parameters.to_string());
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let places = NAMES.iter().flat_map(|name| folders.iter().map(move |f| f.join(name)));
    places.into_iter().find(|place| place.is_file())
}
