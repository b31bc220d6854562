//! `--serve-groot`: Groot2 can connect to a run.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Instant;

use campaigns::Error;
use clap::Args;
use groot::{PORT, Server, Value};
use recording::{EntryValue, Header, RunView, logged_transitions};

use crate::output::note;

/// Where clients of Groot2's protocol are answered.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ServeGrootArgs {
    /// Lets Groot2, and others with the same protocol, see the tree while the run goes on, in real time: at a port of
    /// this computer, or at ADDRESS:PORT, `0.0.0.0:1667`, also from others [default port: 1667]
    #[arg(long, value_name = "[ADDRESS:]PORT", num_args = 0..=1, default_missing_value = "", value_parser = address)]
    serve_groot: Option<SocketAddr>,
}

/// An address, or a port of the loopback.
fn address(text: &str) -> Result<SocketAddr, String> {
    let here = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
    match text {
        "" => Ok(here(PORT)),
        text => text.parse().or_else(|_| text.parse().map(here)).map_err(|_| {
            "neither a port nor an address with a port; if it is the name of a scenario, write it before the option"
                .to_owned()
        }),
    }
}

impl ServeGrootArgs {
    /// Whether the tree is to be served.
    pub(crate) fn is_given(&self) -> bool {
        self.serve_groot.is_some()
    }

    /// Opens the server, and notes its address.
    pub(crate) fn open(&self) -> Result<Option<Arc<Server>>, Error> {
        let Some(address) = self.serve_groot else { return Ok(None) };
        let server = Server::open(address).map_err(|error| {
            let message = format!("cannot serve Groot2 at {address} and the port after it: {error}");
            Error::refused(message, "choose another port with `--serve-groot PORT`")
        })?;
        let address = server.address();
        let clients = if address.ip().is_loopback() {
            "programs on this computer"
        } else {
            "every program that reaches this address: there is no authentication"
        };
        note(&format!(
            "Groot2 can connect to {address}; its protocol shows the tree, the statuses of its nodes and its \
             blackboards to {clients}. The run cannot be changed with it"
        ));
        Ok(Some(Arc::new(server)))
    }
}

/// Refuses a run whose tree cannot be served.
pub(crate) fn check(header: &Header) -> Result<(), scenarios::Error> {
    let problem = match &header.tree_xml {
        None if header.tree.is_empty() => "there is none in this scenario".to_owned(),
        None => "with `tree = \"nodes\"` in `[execution]`, the statuses of its nodes are not reported".to_owned(),
        Some(_) if u16::try_from(header.tree.len()).is_err() => {
            format!("it has {} nodes, and the protocol has numbers for {}", header.tree.len(), u16::MAX)
        }
        Some(_) => return Ok(()),
    };
    let help = "leave `--serve-groot` out, or choose another scenario";
    Err(scenarios::Error::refused(format!("Groot2 cannot see the tree: {problem}"), help))
}

/// The audience of a run that reports it to the server, from its start on.
pub(crate) fn audience(server: Arc<Server>) -> impl FnMut(&RunView) + Send + 'static {
    let mut has_begun = false;
    move |view| {
        let header = view.header();
        if !std::mem::replace(&mut has_begun, true) {
            let (xml, nodes) = (header.tree_xml.as_deref(), u16::try_from(header.tree.len()));
            server.show(xml.unwrap_or_default(), nodes.unwrap_or(u16::MAX), header.blackboards.iter().cloned());
        }
        server.advance(i64::try_from(view.time().as_micros()).unwrap_or(i64::MAX), logged_transitions(view));
        let details = view.step().details.as_deref();
        for (board, key, value) in details.map_or(&[][..], |details| &details.entries) {
            server.write(&header.blackboards[*board], key, value.as_ref().map(as_json));
        }
    }
}

fn as_json(value: &EntryValue) -> Value {
    match value {
        EntryValue::Whole(number) => (*number).into(),
        EntryValue::Real(number) => (*number).into(),
        EntryValue::Text(text) | EntryValue::Other(text) => text.as_str().into(),
        EntryValue::List(items) => Value::Array(items.iter().map(|item| item.as_str().into()).collect()),
    }
}

/// Lets a run go on no faster than in real time.
#[expect(clippy::disallowed_methods, reason = "people watch in real time")]
pub(crate) fn real_time() -> impl FnMut(&RunView) {
    let began = Instant::now();
    move |view| {
        // Partners that take part set the pace.
        if !view.header().has_partners() {
            std::thread::sleep((began + view.time()).saturating_duration_since(Instant::now()));
        }
    }
}
