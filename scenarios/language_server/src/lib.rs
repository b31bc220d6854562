//! A language server: the checks of files, and what an editor can show of them, over the Language Server Protocol.
//!
//! The editor sends messages over stdin and gets answers over stdout. One thread answers, in the order of the messages;
//! another one checks the open documents after each edit, and drops a check that a further edit has made obsolete.
//!
//! # Inside
//! `server` answers messages: what it was asked about a file in `questions`, from what the `checker` has found. `wire`
//! and `address` translate places and names of files, `guard` keeps a panic from ending the server.

mod address;
mod checker;
mod guard;
mod incoming;
mod questions;
mod server;
mod wire;

use std::collections::VecDeque;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use lsp_server::{Connection, ErrorCode, Message, Notification, ProtocolError, Request, RequestId, Response};
use lsp_types::{InitializeParams, InitializeResult, NumberOrString, ServerInfo};
use serde_json::{Value, json};

use incoming::{Incoming, parsed};
use server::Server;

/// Serves an editor until it exits. If it breaks off while it introduces itself, `broken_off` gets the reason at once:
/// the program ends only after the editor has closed the connection.
pub fn serve(broken_off: impl FnOnce(ProtocolError)) -> ExitCode {
    let (connection, threads) = Connection::stdio();
    let code = begin(&connection).unwrap_or_else(|error| {
        broken_off(error);
        ExitCode::FAILURE
    });
    // The writer ends once nothing can send to it.
    drop(connection);
    let _ = threads.join();
    code
}

fn begin(connection: &Connection) -> Result<ExitCode, ProtocolError> {
    let (id, params) = connection.initialize_start()?;
    let params: InitializeParams = match serde_json::from_value(params) {
        Ok(params) => params,
        Err(error) => {
            let refused = Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string());
            let _ = connection.sender.send(refused.into());
            return Ok(ExitCode::FAILURE);
        }
    };
    let (sender, inputs) = channel();
    let editor = connection.sender.clone();
    // After the editor has exited, messages to it are discarded.
    let send = move |message| drop(editor.send(message));
    let mut server = Server::new(&params, send, sender.clone());
    let info = ServerInfo { name: "steward".to_owned(), version: Some(env!("CARGO_PKG_VERSION").to_owned()) };
    let result = InitializeResult { capabilities: server.capabilities(), server_info: Some(info) };
    connection.initialize_finish(id, json!(result))?;
    server.watch_files();
    let messages = connection.receiver.clone();
    thread::spawn(move || {
        let sent = messages.iter().map(Incoming::Message).chain([Incoming::End]);
        let _ = sent.map(|input| sender.send(input)).find(Result::is_err);
    });
    Ok(answer(&mut server, &inputs))
}

/// Answers until the editor exits. Of the messages that have already come, a cancelled request is not answered.
fn answer(server: &mut Server, inputs: &Receiver<Incoming>) -> ExitCode {
    let mut waiting = VecDeque::new();
    let mut is_shut_down = false;
    loop {
        if waiting.is_empty() {
            waiting.extend(inputs.recv());
        }
        waiting.extend(inputs.try_iter());
        for id in waiting.iter().filter_map(cancelled).collect::<Vec<_>>() {
            let is_it =
                |input: &Incoming| matches!(input, Incoming::Message(Message::Request(request)) if request.id == id);
            if let Some(place) = waiting.iter().position(is_it) {
                waiting.remove(place);
                let message = "the editor has cancelled the request";
                server.reply(Response::new_err(id, ErrorCode::RequestCanceled as i32, message.to_owned()));
            }
        }
        match waiting.pop_front() {
            Some(Incoming::Message(Message::Request(request))) if request.method == "shutdown" => {
                is_shut_down = true;
                server.reply(Response::new_ok(request.id, Value::Null));
            }
            Some(Incoming::Message(Message::Request(Request { id, .. }))) if is_shut_down => {
                let message = "the server has been shut down".to_owned();
                server.reply(Response::new_err(id, ErrorCode::InvalidRequest as i32, message));
            }
            Some(Incoming::Message(Message::Request(request))) => server.request(request),
            Some(Incoming::Message(Message::Notification(said))) if said.method == "exit" => {
                return if is_shut_down { ExitCode::SUCCESS } else { ExitCode::FAILURE };
            }
            Some(Incoming::Message(Message::Notification(said))) => server.notification(said),
            // It only says that files are watched, or not.
            Some(Incoming::Message(Message::Response(_))) => {}
            Some(Incoming::Checked(checked)) => server.publish(checked),
            Some(Incoming::End) | None => return ExitCode::FAILURE,
        }
    }
}

/// The request that this message cancels.
fn cancelled(input: &Incoming) -> Option<RequestId> {
    let Incoming::Message(Message::Notification(Notification { method, params })) = input else { return None };
    if method != "$/cancelRequest" {
        return None;
    }
    Some(match parsed(params.get("id")?.clone())? {
        NumberOrString::Number(number) => number.into(),
        NumberOrString::String(text) => text.into(),
    })
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;

    #[test]
    fn what_is_cancelled_before_its_turn_is_refused_and_all_else_answered() {
        let (sender, inputs) = channel();
        let request = |id: RequestId, method: &str| Message::from(Request::new(id, method.to_owned(), json!({})));
        let notify = |method: &str, params| Message::from(Notification::new(method.to_owned(), params));
        let messages = [
            request(1.into(), "steward/unknown"),
            request(2.into(), "textDocument/hover"),
            request("a".to_owned().into(), "textDocument/hover"),
            // An ID is a number or a text, and one that no request has is ignored.
            notify("$/cancelRequest", json!({ "id": 2 })),
            notify("$/cancelRequest", json!({ "id": "a" })),
            notify("$/cancelRequest", json!({ "id": "1" })),
            notify("$/cancelRequest", json!({})),
            request(3.into(), "shutdown"),
            notify("exit", json!(null)),
        ];
        messages.into_iter().for_each(|message| sender.send(Incoming::Message(message)).expect("it listens"));
        let sent = Rc::new(RefCell::new(Vec::new()));
        let send = {
            let sent = sent.clone();
            move |message| sent.borrow_mut().push(message)
        };
        let mut server = Server::new(&InitializeParams::default(), send, sender);
        assert_eq!(format!("{:?}", answer(&mut server, &inputs)), format!("{:?}", ExitCode::SUCCESS));
        let replies = sent.take().into_iter().filter_map(|message| match message {
            Message::Response(response) => Some((response.id.to_string(), response.error.map(|error| error.code))),
            _ => None,
        });
        let cancelled = Some(ErrorCode::RequestCanceled as i32);
        let expected =
            [("2", cancelled), ("\"a\"", cancelled), ("1", Some(ErrorCode::MethodNotFound as i32)), ("3", None)];
        assert_eq!(replies.collect::<Vec<_>>(), expected.map(|(id, code)| (id.to_owned(), code)));
    }
}
