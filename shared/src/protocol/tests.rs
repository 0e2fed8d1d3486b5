//! The codec byte by byte, and every example of `PROTOCOL.md`.

use super::{
    ClientMessage, Command, DecodeError, Decoder, ErrorCode, MAX_LINE_BYTES, Message, Request,
    ServerMessage, encode,
};

const PAGE: &str = include_str!("PROTOCOL.md");

/// The example lines of the fences with this label.
fn examples(label: &str) -> Vec<&'static str> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in PAGE.lines() {
        if line.starts_with("```") {
            inside = line == format!("```json {label}");
        } else if inside {
            lines.push(line);
        }
    }
    lines
}

fn assert_examples_round_trip<M: Message + PartialEq + std::fmt::Debug>(
    label: &str,
    types: &[&str],
) {
    let lines = examples(label);
    for line in &lines {
        let message = M::from_line(line).unwrap_or_else(|error| panic!("{line}\n{error}"));
        assert_eq!(encode(&message), format!("{line}\n"));
    }
    for kind in types {
        let key = format!("\"type\":\"{kind}\"");
        assert!(
            lines.iter().any(|line| line.contains(&key)),
            "no example of {kind}"
        );
    }
}

fn decode_all<M: Message>(decoder: &mut Decoder<M>, bytes: &[u8]) -> Vec<Result<M, DecodeError>> {
    decoder.push(bytes);
    std::iter::from_fn(|| decoder.next_message()).collect()
}

fn ping(id: u64) -> ClientMessage {
    Request {
        id,
        command: Command::Ping,
    }
    .into()
}

#[test]
fn every_client_example_is_read_and_written_back_identically() {
    assert_examples_round_trip::<ClientMessage>(
        "client",
        &[&["hello"][..], &Command::TYPES].concat(),
    );
}

#[test]
fn every_server_example_is_read_and_written_back_identically() {
    assert_examples_round_trip::<ServerMessage>("server", &ServerMessage::TYPES);
}

#[test]
fn every_error_code_stands_in_the_page() {
    for code in [
        ErrorCode::TooLong,
        ErrorCode::Malformed,
        ErrorCode::UnknownType,
        ErrorCode::Invalid,
        ErrorCode::Version,
        ErrorCode::Hello,
        ErrorCode::ControllerTaken,
        ErrorCode::NotController,
        ErrorCode::Full,
        ErrorCode::NotPresented,
        ErrorCode::Token,
    ] {
        let word = serde_json::to_string(&code).unwrap();
        assert!(
            PAGE.contains(&format!("| `{}` |", word.trim_matches('"'))),
            "{word}"
        );
    }
}

#[test]
fn a_code_of_a_later_version_is_read_as_other() {
    let line = r#"{"type":"error","code":"on_fire","message":"run"}"#;
    let expected = ServerMessage::Error {
        id: None,
        code: ErrorCode::Other,
        message: "run".into(),
    };
    assert_eq!(ServerMessage::from_line(line), Ok(expected));
}

#[test]
fn messages_come_out_whatever_the_pieces_they_arrive_in() {
    let stream: String = (0..5).map(|id| encode(&ping(id))).collect();
    for piece in 1..=stream.len() {
        let mut decoder = Decoder::<ClientMessage>::new();
        let got: Vec<_> = stream
            .as_bytes()
            .chunks(piece)
            .flat_map(|bytes| decode_all(&mut decoder, bytes))
            .collect();
        assert_eq!(
            got,
            (0..5).map(|id| Ok(ping(id))).collect::<Vec<_>>(),
            "pieces of {piece}"
        );
    }
}

#[test]
fn unknown_fields_empty_lines_and_carriage_returns_do_no_harm() {
    let mut decoder = Decoder::new();
    let got = decode_all(
        &mut decoder,
        b"\n  \r\n{\"id\":3,\"colour\":[1],\"type\":\"ping\"}\r\n",
    );
    assert_eq!(got, [Ok(ping(3))]);
}

#[test]
fn a_line_of_the_largest_length_is_read_and_one_byte_more_is_refused() {
    for (extra, good) in [(0, true), (1, false)] {
        let line = encode(&ping(1));
        let padding = " ".repeat(MAX_LINE_BYTES + 1 - line.len() + extra);
        let mut decoder = Decoder::new();
        let got = decode_all(&mut decoder, format!("{padding}{line}").as_bytes());
        let expected = if good {
            Ok(ping(1))
        } else {
            Err(DecodeError::TooLong)
        };
        assert_eq!(got, [expected]);
    }
}

#[test]
fn an_endless_line_is_reported_once_takes_no_memory_and_the_next_line_is_read() {
    let mut decoder = Decoder::new();
    let mut got = Vec::new();
    for _ in 0..100 {
        got.extend(decode_all(&mut decoder, &[b'x'; 10_000]));
        assert!(decoder.pending_bytes() <= MAX_LINE_BYTES);
    }
    got.extend(decode_all(&mut decoder, b"\n"));
    got.extend(decode_all(&mut decoder, encode(&ping(2)).as_bytes()));
    assert_eq!(got, [Err(DecodeError::TooLong), Ok(ping(2))]);
}

#[test]
fn garbage_is_an_error_with_a_code_and_the_next_line_is_read() {
    let deep = "[".repeat(60_000);
    let cases: [(&[u8], ErrorCode, Option<u64>); 9] = [
        (b"\xff\xfe", ErrorCode::Malformed, None),
        (b"GET / HTTP/1.1", ErrorCode::Malformed, None),
        (b"[1,2]", ErrorCode::Malformed, None),
        (br#"{"id":4}"#, ErrorCode::Malformed, None),
        (deep.as_bytes(), ErrorCode::Malformed, None),
        (
            br#"{"id":4,"type":"explode"}"#,
            ErrorCode::UnknownType,
            Some(4),
        ),
        (br#"{"id":4,"type":"show"}"#, ErrorCode::Invalid, Some(4)),
        (br#"{"type":"ping"}"#, ErrorCode::Invalid, None),
        (br#"{"id":-1,"type":"ping"}"#, ErrorCode::Invalid, None),
    ];
    for (bytes, code, id) in cases {
        let mut decoder = Decoder::<ClientMessage>::new();
        let text = String::from_utf8_lossy(&bytes[..bytes.len().min(40)]).into_owned();
        let got = decode_all(
            &mut decoder,
            &[bytes, b"\n", encode(&ping(5)).as_bytes()].concat(),
        );
        let [Err(error), Ok(next)] = got.as_slice() else {
            panic!("{text}: {got:?}")
        };
        assert_eq!((error.code(), error.id()), (code, id), "{text}");
        assert_eq!(next, &ping(5));
    }
}

#[test]
fn values_out_of_range_are_refused_with_the_reason() {
    let cases = [
        (
            r#"{"id":1,"type":"show","view":{"kind":"solid","colour":"red"}}"#,
            "#rrggbb",
        ),
        (r#"{"id":1,"type":"show","view":{"kind":"disco"}}"#, "disco"),
        (
            r##"{"id":1,"type":"show","view":{"kind":"grid","rows":16,"columns":15,"row_width_px":1,"column_width_px":1,"colours":["#000000"]}}"##,
            "16 lines",
        ),
        (r#"{"id":1,"type":"blank","on":"yes"}"#, "boolean"),
    ];
    for (line, reason) in cases {
        let error = ClientMessage::from_line(line).unwrap_err();
        assert_eq!((error.code(), error.id()), (ErrorCode::Invalid, Some(1)));
        assert!(error.to_string().contains(reason), "{error}");
    }
}
