//! A stream of server-sent events, read by hand.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use serde_json::Value;

/// An open stream, after its header.
pub struct EventStream {
    reader: BufReader<TcpStream>,
}

/// An event of a stream.
#[derive(Clone, Debug, PartialEq)]
pub struct SentEvent {
    pub seq: i64,
    pub kind: String,
    pub data: Value,
}

impl EventStream {
    /// Opens the stream at a path such as `/jobs/ID/events`.
    pub fn open(address: SocketAddr, path: &str, last_event_id: Option<i64>) -> Self {
        let mut socket = TcpStream::connect(address).expect("connects");
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let last = last_event_id.map_or(String::new(), |id| format!("last-event-id: {id}\r\n"));
        let request =
            format!("GET {path} HTTP/1.1\r\nhost: localhost\r\naccept: text/event-stream\r\n{last}\r\n");
        socket.write_all(request.as_bytes()).expect("writes");
        let mut reader = BufReader::new(socket);
        let mut line = String::new();
        reader.read_line(&mut line).expect("reads");
        assert!(line.contains(" 200 "), "{line}");
        while line.trim() != "" {
            line.clear();
            reader.read_line(&mut line).expect("reads");
        }
        Self { reader }
    }

    /// The next event; `None` when the stream has ended.
    fn next(&mut self) -> Option<SentEvent> {
        let (mut seq, mut kind, mut data) = (None, None, None);
        loop {
            let mut line = String::new();
            if self.reader.read_line(&mut line).expect("reads") == 0 {
                return None;
            }
            if let Some(value) = line.strip_prefix("id: ") {
                seq = value.trim().parse().ok();
            } else if let Some(value) = line.strip_prefix("event: ") {
                kind = Some(value.trim().to_owned());
            } else if let Some(value) = line.strip_prefix("data: ") {
                data = serde_json::from_str(value).ok();
            } else if line.trim().is_empty()
                && let (Some(seq), Some(kind), Some(data)) = (seq, kind.take(), data.take())
            {
                return Some(SentEvent { seq, kind, data });
            }
        }
    }

    /// The next events, so many, or as many as come before the stream ends.
    pub async fn until(self, count: usize) -> Vec<SentEvent> {
        self.read(count).await.0
    }

    /// The next events and the stream, which goes on.
    pub async fn read(self, count: usize) -> (Vec<SentEvent>, Self) {
        let read = tokio::task::spawn_blocking(move || {
            let mut stream = self;
            let mut seen = Vec::new();
            while seen.len() < count {
                match stream.next() {
                    Some(event) => seen.push(event),
                    None => break,
                }
            }
            (seen, stream)
        });
        read.await.unwrap()
    }
}
