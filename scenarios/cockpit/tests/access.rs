//! Who gets in, and who steers.

use serde_json::{Value, json};
use tungstenite::Message;

use crate::browser::{ask, frame_with, hear};
use crate::session;

#[test]
fn only_our_own_page_with_the_token_gets_in() {
    let page = session("nominal", None);
    let (host, path) = (format!("Host: {}\r\n", page.host), format!("/?token={}", page.pilot));
    let status = |path: &str, headers: &str| page.get(path, headers).lines().next().unwrap_or_default().to_owned();
    let (well, forbidden) = ("HTTP/1.1 200 OK", "HTTP/1.1 403 Forbidden");
    assert_eq!(status(&path, &host), well);
    assert_eq!(status(&format!("/?token={}", page.viewer), &host), well);
    assert_eq!(status(&path, &format!("Host: localhost:{}\r\n", page.host.rsplit(':').next().unwrap())), well);
    // Another name for the same address, as in DNS rebinding; no name; two names.
    assert_eq!(status(&path, "Host: evil.example\r\n"), forbidden);
    assert_eq!(status(&path, &format!("{host}Host: evil.example\r\n")), forbidden);
    assert_ne!(status(&path, ""), well);
    // Another site's page; a request from our own page; a wrong token.
    assert_eq!(status(&path, &format!("{host}Origin: http://evil.example\r\n")), forbidden);
    assert_eq!(status("/main.js", &format!("{host}Origin: null\r\n")), forbidden);
    assert_eq!(status(&path, &format!("{host}Origin: http://{}\r\n", page.host)), well);
    assert_eq!(status("/", &host), forbidden);
    assert_eq!(status("/?token=", &host), forbidden);
    assert_eq!(status(&format!("{path}0"), &host), forbidden);
    let answer = page.get(&path, &host);
    let policy = answer.lines().find(|line| line.starts_with("content-security-policy: ")).unwrap();
    assert!(policy.contains("script-src 'self';") && policy.contains("default-src 'none'"), "{policy}");

    let origin = format!("http://{}", page.host);
    assert!(page.try_socket(&page.viewer, Some(&origin)).is_ok());
    for (token, origin) in [
        ("", Some(origin.as_str())),
        ("0123456789abcdef0123456789abcdef", Some(origin.as_str())),
        (&page.pilot, None),
        (&page.pilot, Some("http://evil.example")),
        (&page.pilot, Some("null")),
    ] {
        assert!(matches!(page.try_socket(token, origin), Err(tungstenite::Error::Http(_))), "{token} {origin:?}");
    }
}

#[test]
fn one_pilot_steers_and_invalid_requests_are_refused() {
    let page = session("nominal", Some(3));
    let mut pilot = page.socket(&page.pilot);
    assert_eq!(hear(&mut pilot, "greeting")["seed"], 3);
    assert_eq!(hear(&mut pilot, "pilot"), true);
    let mut second = page.socket(&page.pilot);
    assert_eq!(hear(&mut second, "pilot"), false);
    let mut viewer = page.socket(&page.viewer);
    assert_eq!(hear(&mut viewer, "pilot"), false);
    for onlooker in [&mut second, &mut viewer] {
        onlooker.send(Message::text(r#"{"do":"pause"}"#)).unwrap();
        assert_eq!(hear(onlooker, "refused"), "another client is controlling this run");
    }
    for (request, reason) in [
        ("", "EOF"),
        ("[]", "do"),
        (r#"{"do":"fly"}"#, "unknown variant `fly`"),
        (r#"{"do":"act","fault":{"kind":"fly"}}"#, "cannot be `fly`"),
        (r#"{"do":"act","fault":{"kind":"battery_level","level_pct":180}}"#, "between 0 and 100"),
        (r#"{"do":"act","fault":{"kind":"kidnap","to":[900,900,0]}}"#, ""),
        (r#"{"do":"act","fault":{"kind":"wrong_map","map":"maps/house_shifted.yaml"}}"#, " run"),
    ] {
        pilot.send(Message::text(request)).unwrap();
        let answer = frame_with(&mut pilot, &["refused", "answer"]);
        let refused = answer.get("refused").or_else(|| answer["answer"].get("refused")).unwrap_or(&Value::Null);
        assert!(refused.as_str().is_some_and(|words| words.contains(reason)), "{request}: {answer}");
    }
    // A message that is too long ends the connection, but not the run: the next pilot steers.
    let _ = pilot.send(Message::text("x".repeat(20_000)));
    while pilot.read().is_ok() {}
    assert_eq!(hear(&mut second, "pilot"), true);
    assert_eq!(ask(&mut second, &json!({ "do": "pause" })), Value::Null);
}

#[test]
fn a_request_that_is_not_text_ends_the_connection_with_the_reason() {
    let page = session("pick", None);
    let mut pilot = page.socket(&page.pilot);
    pilot.send(Message::binary(vec![1, 2, 3])).unwrap();
    let reason = loop {
        if let Message::Close(reason) = pilot.read().unwrap() {
            break reason.unwrap();
        }
    };
    assert_eq!((u16::from(reason.code), reason.reason.as_str()), (1003, "requests are text"));
}
