//! Talks and listens to a process: messages to whoever waits for them, everything else into a capped log.
//!
//! The pipes are drained to the end whatever comes, so that an engine that floods its output is
//! slowed by nothing but itself, and costs a fixed amount of memory.

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use super::protocol::{FromEngine, LINE_LIMIT, Line, parse_line};

/// How much of an engine's own talk is kept of each stream, in bytes.
const LOG_LIMIT: usize = 16 * 1024;
/// How long to wait for what comes at once unless something keeps it from coming: a busy machine
/// may let whoever listens to a pipe wait for a while.
pub(crate) const PATIENCE: Duration = Duration::from_secs(2);

/// Something that came over standard output.
#[derive(Debug, PartialEq)]
pub(crate) enum Heard {
    /// A message.
    Message(FromEngine),
    /// A message that cannot be understood; the text says why.
    Broken(String),
    /// A line that is talk, with a message at its end and this before it: either somebody logs messages, or printed
    /// something without a newline, and waits now.
    Behind(String),
    /// Standard output was closed.
    Closed,
}

/// Where a process said something.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Output,
    Error,
}

/// The last of what a process said besides messages, on each of its streams: in which order they came together is
/// chance, since most programs keep their output back and their errors not.
#[derive(Debug, Clone, Default)]
pub(crate) struct Log(Arc<Mutex<[VecDeque<u8>; 2]>>);

impl Log {
    fn push(&self, stream: Stream, bytes: &[u8]) {
        let mut logs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let log = &mut logs[stream as usize];
        log.extend(bytes);
        let excess = log.len().saturating_sub(LOG_LIMIT);
        log.drain(..excess);
    }

    /// What was said on one stream, its beginning cut off where it was too long.
    fn text_of(&self, stream: Stream) -> String {
        let mut logs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(logs[stream as usize].make_contiguous()).into_owned()
    }

    /// What was said, the errors last.
    pub fn text(&self) -> String {
        let [mut output, error] =
            [Stream::Output, Stream::Error].map(|stream| self.text_of(stream));
        if !output.is_empty() && !error.is_empty() && !output.ends_with('\n') {
            output.push('\n');
        }
        output + &error
    }

    /// For one-line messages the last line of the errors that is not blank, or else of the output.
    pub fn last_line(&self) -> Option<String> {
        [Stream::Error, Stream::Output].into_iter().find_map(|stream| {
            let text = self.text_of(stream);
            text.lines().rev().map(str::trim).find(|line| !line.is_empty()).map(str::to_owned)
        })
    }
}

/// Starts to listen to standard output, which may hold messages.
pub(crate) fn listen(output: impl Read + Send + 'static, log: Log) -> Receiver<Heard> {
    // Few places: an engine that floods its output with messages waits for us, not we for memory.
    let (sender, receiver) = sync_channel(16);
    thread::spawn(move || hear_messages(BufReader::new(output), &log, &sender));
    receiver
}

/// Starts to listen to a stream that only fills the log. The receiver learns of its end by being
/// disconnected.
pub(crate) fn listen_to_log(
    output: impl Read + Send + 'static,
    stream: Stream,
    log: Log,
) -> Receiver<()> {
    let (sender, receiver) = sync_channel(0);
    thread::spawn(move || {
        let _sender = sender;
        let mut output = output;
        let mut buffer = [0; 4096];
        while let Ok(count @ 1..) = output.read(&mut buffer) {
            log.push(stream, &buffer[..count]);
        }
    });
    receiver
}

/// Starts to tell standard input whatever is sent: an engine that does not read keeps nobody waiting who has limits to
/// watch. It is closed when the sender goes; what was not read until the process ends is lost. The flag is set where
/// nobody can read any more.
pub(crate) fn tell(mut input: impl Write + Send + 'static) -> (Sender<String>, Arc<AtomicBool>) {
    let (sender, receiver) = channel::<String>();
    let deaf = Arc::new(AtomicBool::new(false));
    let is_deaf = deaf.clone();
    thread::spawn(move || {
        for line in receiver {
            if input.write_all(line.as_bytes()).and_then(|()| input.flush()).is_err() {
                is_deaf.store(true, Ordering::Relaxed);
                break;
            }
        }
    });
    (sender, deaf)
}

fn hear_messages(mut output: impl BufRead, log: &Log, sender: &SyncSender<Heard>) {
    let mut line = Vec::new();
    let mut goes_on = false;
    loop {
        line.clear();
        let count = output.by_ref().take(LINE_LIMIT as u64).read_until(b'\n', &mut line);
        let heard = match count {
            Ok(0) | Err(_) => {
                let _ = sender.send(Heard::Closed);
                return;
            }
            Ok(count) => {
                // A line longer than a message may be is no message, and its further pieces are chatter. If it was to be
                // one, nothing else may come.
                let begins = !goes_on;
                goes_on = !line.ends_with(b"\n");
                let too_long = goes_on && count == LINE_LIMIT;
                let text = std::str::from_utf8(&line).ok().filter(|_| begins && !too_long);
                match text.map_or(Line::Chatter, parse_line) {
                    Line::Chatter if begins && too_long && line.starts_with(b"{\"hazcam\"") => {
                        Heard::Broken(format!(
                            "a message has at most {LINE_LIMIT} bytes, and this one has more"
                        ))
                    }
                    Line::Chatter
                        if begins && text.is_none() && line.starts_with(b"{\"hazcam\"") =>
                    {
                        Heard::Broken("a message is text in UTF-8, and this one is not".into())
                    }
                    Line::Chatter
                        if begins
                            && !too_long
                            && let Some(before) = before_message(&line) =>
                    {
                        log.push(Stream::Output, &line);
                        Heard::Behind(shortened(&before))
                    }
                    Line::Message(message) => Heard::Message(message),
                    Line::Broken(why) => Heard::Broken(why),
                    Line::Chatter => {
                        log.push(Stream::Output, &line);
                        continue;
                    }
                }
            }
        };
        if sender.send(heard).is_err() {
            // Nobody waits for messages any more; the rest is drained so that the process can end.
            let _ = std::io::copy(&mut output, &mut std::io::sink());
            return;
        }
    }
}

/// What stands in a line before a message at its end, whatever it is.
fn before_message(line: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(line);
    let begin = text.rfind("{\"hazcam\"")?;
    matches!(parse_line(&text[begin..]), Line::Message(_)).then(|| text[..begin].to_owned())
}

/// The end of a text, for messages.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 60;
    let count = text.chars().count();
    match count > LONGEST {
        true => ['…'].into_iter().chain(text.chars().skip(count - LONGEST)).collect(),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_behind_something_else_is_told_apart() {
        let heard = |line: &'static str| -> Vec<Heard> {
            listen(line.as_bytes(), Log::default()).iter().collect()
        };
        let broken = b"\xff\xfe{\"hazcam\":\"done\",\"job\":1}\n".as_slice();
        let first = listen(broken, Log::default()).recv().unwrap();
        assert_eq!(first, Heard::Behind("\u{fffd}\u{fffd}".into()));
        for (line, before) in [
            ("progress 100%{\"hazcam\":\"done\",\"job\":1}\n", "progress 100%"),
            ("x {\"hazcam\" y{\"hazcam\":\"done\",\"job\":1}\n", "x {\"hazcam\" y"),
        ] {
            assert_eq!(heard(line), [Heard::Behind(before.into()), Heard::Closed]);
        }
        for line in ["sent {\"hazcam\": ..\n", "got {\"hazcam\":1} back\n"] {
            assert_eq!(heard(line), [Heard::Closed], "{line}");
        }
    }

    #[test]
    fn messages_and_chatter_go_their_ways() {
        let output = b"hello\n{\"hazcam\":\"done\",\"job\":1}\n\xff\xfe\nbye".as_slice();
        let log = Log::default();
        let heard: Vec<_> = listen(output, log.clone()).iter().collect();
        assert_eq!(
            heard,
            [Heard::Message(FromEngine::Done { job: 1, seconds: None }), Heard::Closed]
        );
        assert!(log.text().starts_with("hello\n") && log.text().ends_with("\nbye"));
        assert_eq!(log.last_line().as_deref(), Some("bye"));
        // Nobody waits for a message that came in another encoding.
        let output = b"{\"hazcam\":\"failed\",\"job\":1,\"message\":\"Gr\xf6sse\"}\n".as_slice();
        let heard: Vec<_> = listen(output, Log::default()).iter().collect();
        assert!(matches!(&heard[0], Heard::Broken(why) if why.contains("UTF-8")), "{heard:?}");
    }

    #[test]
    fn errors_are_heard_before_output_whatever_came_first() {
        let log = Log::default();
        let say = |stream, said: &'static [u8]| listen_to_log(said, stream, log.clone()).recv();
        say(Stream::Error, b"cannot open weights.bin").unwrap_err();
        say(Stream::Output, b"model loaded").unwrap_err();
        assert_eq!(log.text(), "model loaded\ncannot open weights.bin");
        assert_eq!(log.last_line().as_deref(), Some("cannot open weights.bin"));
    }

    #[test]
    fn no_piece_of_a_longer_line_is_a_message() {
        let message = "{\"hazcam\":\"done\",\"job\":1}";
        let behind = format!("{}{message}\n", ".".repeat(LINE_LIMIT));
        let before = format!("{message}{}.\n", " ".repeat(LINE_LIMIT - message.len()));
        let done = || Heard::Message(FromEngine::Done { job: 1, seconds: None });
        let heard = |line: String| -> Vec<Heard> {
            let output = std::io::Cursor::new(format!("{line}{message}\n"));
            listen(output, Log::default()).iter().collect()
        };
        assert_eq!(heard(behind), [done(), Heard::Closed]);
        // What was to be one is not waited for.
        let broken = "a message has at most 65536 bytes, and this one has more".to_owned();
        assert_eq!(heard(before), [Heard::Broken(broken), done(), Heard::Closed]);
    }

    #[test]
    fn a_flood_keeps_only_its_end() {
        let flood = b"{".repeat(LINE_LIMIT * 3).into_iter().chain(*b"\nend").collect::<Vec<_>>();
        let log = Log::default();
        let receiver = listen(std::io::Cursor::new(flood), log.clone());
        assert_eq!(receiver.recv().unwrap(), Heard::Closed);
        assert_eq!(log.text().len(), LOG_LIMIT);
        assert_eq!(log.last_line().as_deref(), Some("end"));
    }
}
