//! The server: the page, its files, and the socket that sends the run.

use std::io;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade};
use axum::extract::{Query, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderName, HeaderValue, ORIGIN, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{any, get};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use recording::{Record, Recording, RecordingError, RunView};
use runs::Session;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::sync::{Semaphore, broadcast, oneshot};

use crate::beside::Beside;
use crate::broadcast::Broadcast;
use crate::command::Command;
use crate::history::History;
use crate::open_recording::OpenRecording;
use crate::runner::{self, RunSource, Runner};
use crate::shown_run::ShownRun;
use crate::steered::Steered;
use crate::token::AccessToken;

/// The maximum number of connections; others wait.
const MOST_CONNECTIONS: usize = 100;
/// How often to look whether the page is to end.
const LOOK: Duration = Duration::from_millis(50);
/// A connection without a request for this long is closed.
const PATIENCE: Duration = Duration::from_secs(5);
/// The maximum number of browsers that see a run.
const MOST_VIEWERS: usize = 50;
/// The longest request of the page, in bytes.
const LONGEST_REQUEST: usize = 16 * 1024;

const FILES: [(&str, &str, &str); 20] = [
    ("/cockpit.css", "text/css", include_str!("../page/cockpit.css")),
    ("/main.js", "text/javascript", include_str!("../page/main.js")),
    ("/link.js", "text/javascript", include_str!("../page/link.js")),
    ("/floor.js", "text/javascript", include_str!("../page/floor.js")),
    ("/machines.js", "text/javascript", include_str!("../page/machines.js")),
    ("/parts.js", "text/javascript", include_str!("../page/parts.js")),
    ("/tree.js", "text/javascript", include_str!("../page/tree.js")),
    ("/gestures.js", "text/javascript", include_str!("../page/gestures.js")),
    ("/timeline.js", "text/javascript", reports::html::live::TIMELINE_SCRIPT),
    ("/legend.js", "text/javascript", include_str!("../page/legend.js")),
    ("/things.js", "text/javascript", include_str!("../page/things.js")),
    ("/details.js", "text/javascript", include_str!("../page/details.js")),
    ("/dock.js", "text/javascript", include_str!("../page/dock.js")),
    ("/hand.js", "text/javascript", include_str!("../page/hand.js")),
    ("/keys.js", "text/javascript", include_str!("../page/keys.js")),
    ("/transport.js", "text/javascript", include_str!("../page/transport.js")),
    ("/board.js", "text/javascript", include_str!("../page/board.js")),
    ("/beside.js", "text/javascript", include_str!("../page/beside.js")),
    ("/messages.js", "text/javascript", include_str!("../page/messages.js")),
    ("/dom.js", "text/javascript", include_str!("../page/dom.js")),
];
/// The page that shows runs.
const RUNS: &str = include_str!("../page/index.html");
/// The page that shows the progress of many runs.
const BOARD: &str = include_str!("../page/board.html");

/// What browsers may do with the page: run its own scripts, and show the page inside itself; nothing else. Drawings
/// contain their own styles.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      connect-src 'self'; base-uri 'none'; form-action 'none'; frame-src 'self'; \
                      frame-ancestors 'self'";

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system provides no address or no random numbers.
    #[error("cannot serve a page on port {port}: {source}")]
    Io {
        /// The port that was asked for; 0 for any.
        port: u16,
        /// The operating system's error.
        source: io::Error,
    },
    /// The session cannot be started.
    #[error(transparent)]
    Scenario(#[from] scenarios::Error),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// A run, and the server that shows it to browsers.
#[derive(Clone)]
pub struct Cockpit {
    listener: Arc<std::net::TcpListener>,
    shared: Arc<Shared>,
}

/// What all connections share.
struct Shared {
    /// The hosts that requests may name.
    hosts: [String; 2],
    pilot: AccessToken,
    viewer: AccessToken,
    page: &'static str,
    /// What is sent to the page.
    broadcast: Broadcast,
    /// What is sent about each run, if the page shows several side by side.
    sides: Vec<Broadcast>,
    requests: mpsc::Sender<runner::Request>,
    /// The connection that has the only permit is the pilot's.
    helm: Semaphore,
    viewers: AtomicUsize,
}

impl Cockpit {
    /// Starts a session, and listens on the loopback address at this port (0 for any free port). The session is made on
    /// the thread of the run, and made again if the pilot restarts it.
    ///
    /// # Errors
    /// If the port is not available, or the session cannot be started.
    pub fn open<F>(session: F, port: u16) -> Result<Self, Error>
    where
        F: Fn() -> Result<Session, scenarios::Error> + Send + 'static,
    {
        let broadcast = Broadcast::new();
        let failed = move |source| Error::Io { port, source };
        let begin = {
            let broadcast = broadcast.clone();
            move || {
                let steered = Steered::new(Box::new(session))?;
                let session = steered.session();
                let history = History::begin(session.view().clone()).map_err(failed)?;
                let shown = ShownRun::new(history, broadcast, None, Some(session.scenario()));
                Ok((RunSource::Session(Box::new(steered)), vec![shown], None))
            }
        };
        Self::start(broadcast, Vec::new(), begin, port)
    }

    /// Opens recordings, finished or growing, with this function, and listens as [`open`](Self::open) does. Several are
    /// shown side by side.
    ///
    /// # Errors
    /// If the port is not available, or a recording cannot be read.
    pub fn replay(
        recordings: &[PathBuf],
        open: impl Fn(&Path) -> Result<Recording, RecordingError> + Send + 'static,
        port: u16,
    ) -> Result<Self, Error> {
        let broadcast = Broadcast::new();
        let beside = if recordings.len() > 1 { recordings } else { &[] };
        let sides: Vec<Broadcast> = beside.iter().map(|_| Broadcast::new()).collect();
        let failed = move |source| Error::Io { port, source };
        let begin = {
            let (broadcast, broadcasts, recordings) = (broadcast.clone(), sides.clone(), recordings.to_vec());
            move || {
                let (mut opened, mut shown, mut names) = (Vec::new(), Vec::new(), Vec::new());
                for (index, path) in recordings.iter().enumerate() {
                    let (recording, start) = OpenRecording::open(path, &open)?;
                    let history = History::begin(start).map_err(failed)?;
                    // A single run is sent to the page itself. Of several, each has a page inside the page.
                    let broadcast = broadcasts.get(index).unwrap_or(&broadcast);
                    shown.push(ShownRun::new(history, broadcast.clone(), Some(&recording.name), None));
                    names.push(recording.name.clone());
                    opened.push(recording);
                }
                let around = (!broadcasts.is_empty()).then(|| {
                    let starts: Vec<&RunView> = shown.iter().map(ShownRun::newest).collect();
                    let ticks = starts.iter().any(|start| start.header().knows_ticks());
                    broadcast.greet(&json!({ "greeting": { "sides": recordings.len(), "ticks": ticks } }));
                    (broadcast, Beside::new(names, &starts))
                });
                Ok((RunSource::Recordings(opened), shown, around))
            }
        };
        Self::start(broadcast, sides, begin, port)
    }

    /// Shows the runs of a [feed](crate::Feed), of which the first has begun, and listens as [`open`](Self::open) does.
    ///
    /// # Errors
    /// If the port is not available.
    pub fn follow(records: mpsc::Receiver<Record>, port: u16) -> Result<Self, Error> {
        let broadcast = Broadcast::new();
        let failed = move |source| Error::Io { port, source };
        let begin = {
            let broadcast = broadcast.clone();
            move || {
                let followed = OpenRecording::of_feed(records);
                let (recording, start) = followed.ok_or_else(|| failed(io::ErrorKind::UnexpectedEof.into()))?;
                let history = History::begin(start).map_err(failed)?;
                let shown = ShownRun::new(history, broadcast, Some(&recording.name), None);
                Ok((RunSource::Recordings(vec![recording]), vec![shown], None))
            }
        };
        Self::start(broadcast, Vec::new(), begin, port)
    }

    /// A page that only shows what a broadcast sends.
    pub(crate) fn board(broadcast: Broadcast, port: u16) -> Result<Self, Error> {
        Self::listen(BOARD, broadcast, Vec::new(), port).map(|(cockpit, _)| cockpit)
    }

    fn start<F>(broadcast: Broadcast, sides: Vec<Broadcast>, begin: F, port: u16) -> Result<Self, Error>
    where
        F: FnOnce() -> Result<(RunSource, Vec<ShownRun>, Option<(Broadcast, Beside)>), Error> + Send + 'static,
    {
        let (cockpit, requests) = Self::listen(RUNS, broadcast, sides, port)?;
        let (made, is_made) = mpsc::channel();
        std::thread::spawn(move || {
            let (runner, made_well) = match begin() {
                Ok((source, sides, around)) => (Some(Runner::new(source, sides, around, requests)), Ok(())),
                Err(error) => (None, Err(error)),
            };
            let _ = made.send(made_well);
            runner.map(Runner::run)
        });
        is_made.recv().unwrap_or(Ok(()))?;
        Ok(cockpit)
    }

    fn listen(
        page: &'static str,
        broadcast: Broadcast,
        sides: Vec<Broadcast>,
        port: u16,
    ) -> Result<(Self, mpsc::Receiver<runner::Request>), Error> {
        let failed = |source| Error::Io { port, source };
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let port = listener.local_addr().map_err(failed)?.port();
        let (requests, received) = mpsc::channel();
        let shared = Shared {
            hosts: [format!("127.0.0.1:{port}"), format!("localhost:{port}")],
            pilot: AccessToken::new().map_err(failed)?,
            viewer: AccessToken::new().map_err(failed)?,
            page,
            broadcast,
            sides,
            requests,
            helm: Semaphore::new(1),
            viewers: AtomicUsize::new(0),
        };
        Ok((Self { listener: Arc::new(listener), shared: Arc::new(shared) }, received))
    }

    /// Whether a browser is connected.
    pub(crate) fn has_viewers(&self) -> bool {
        self.shared.viewers.load(Ordering::Acquire) > 0
    }

    /// The address of the page for the pilot.
    #[must_use]
    pub fn address(&self) -> String {
        format!("http://{}/?token={}", self.shared.hosts[0], self.shared.pilot.text())
    }

    /// The address of the page for viewers.
    #[must_use]
    pub fn address_for_viewers(&self) -> String {
        format!("http://{}/?token={}", self.shared.hosts[0], self.shared.viewer.text())
    }

    /// Serves the page forever.
    ///
    /// # Errors
    /// What keeps the server from working.
    pub fn serve(self) -> Result<(), Error> {
        runtime()?.block_on(self.accept())
    }

    /// The same until `interrupted` is set. A session then ends, and with it its programs; its partners leave.
    ///
    /// # Errors
    /// As for [`serve`](Self::serve).
    pub fn serve_until(self, interrupted: &AtomicBool) -> Result<(), Error> {
        let shared = Arc::clone(&self.shared);
        runtime()?.block_on(async {
            let is_over = async {
                while !interrupted.load(Ordering::Relaxed) {
                    tokio::time::sleep(LOOK).await;
                }
            };
            tokio::select! {
                served = self.accept() => served,
                () = is_over => {
                    shared.ask(Command::End).await;
                    Ok(())
                }
            }
        })
    }

    async fn accept(self) -> Result<(), Error> {
        let failed = |source| Error::Io { port: 0, source };
        let listener = self.listener.try_clone().and_then(TcpListener::from_std).map_err(failed)?;
        let free = Arc::new(Semaphore::new(MOST_CONNECTIONS));
        let service = TowerToHyperService::new(router(self.shared));
        let mut server = http1::Builder::new();
        server.timer(TokioTimer::new()).header_read_timeout(PATIENCE);
        loop {
            let permit = Arc::clone(&free).acquire_owned().await.expect("the semaphore is never closed");
            let Ok((stream, _)) = listener.accept().await else {
                // There are no file handles left, or the other side has already gone.
                tokio::time::sleep(Duration::from_millis(100)).await;
                continue;
            };
            // Otherwise a message would wait for 40 ms until the browser has acknowledged the one before.
            let _ = stream.set_nodelay(true);
            let connection = server.serve_connection(TokioIo::new(stream), service.clone()).with_upgrades();
            tokio::spawn(async move {
                // A broken connection needs no answer.
                let _ = connection.await;
                drop(permit);
            });
        }
    }
}

fn runtime() -> Result<tokio::runtime::Runtime, Error> {
    let made = tokio::runtime::Builder::new_current_thread().enable_all().build();
    made.map_err(|source| Error::Io { port: 0, source })
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = Router::new().route("/", get(page)).route("/socket", any(socket));
    router = router.route("/report.css", get(|| async { file("text/css", reports::html::live::style()) }));
    for (path, kind, text) in FILES {
        router = router.route(path, get(move || async move { file(kind, text) }));
    }
    let guard = middleware::from_fn_with_state(Arc::clone(&shared), guard);
    router.layer(guard).with_state(shared)
}

fn file(kind: &'static str, text: impl Into<Bytes>) -> Response {
    ([(CONTENT_TYPE, HeaderValue::from_static(kind))], text.into()).into_response()
}

/// Rejects requests that do not name the server's own address, and restricts what browsers may do with the answer.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let is_own = |host: &str| shared.hosts.iter().any(|own| own == host);
    let named = only(headers, &HOST).is_some_and(is_own);
    let origin = only(headers, &ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
    let mut response = if !named || headers.contains_key(ORIGIN) && !origin.is_some_and(is_own) {
        (StatusCode::FORBIDDEN, "The request is not for this server's own address.").into_response()
    } else {
        next.run(request).await
    };
    let rules = [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
    ];
    response.headers_mut().extend(rules.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response
}

/// The value of a header that occurs exactly once.
fn only<'h>(headers: &'h HeaderMap, name: &HeaderName) -> Option<&'h str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

#[derive(Deserialize)]
struct Access {
    #[serde(default)]
    token: String,
    /// The run to watch, if several are shown side by side.
    side: Option<usize>,
}

async fn page(State(shared): State<Arc<Shared>>, Query(access): Query<Access>) -> Response {
    match shared.knows(&access) {
        true => file("text/html; charset=utf-8", shared.page),
        false => (StatusCode::FORBIDDEN, "Open the address that `steward live` printed.").into_response(),
    }
}

async fn socket(
    State(shared): State<Arc<Shared>>,
    Query(access): Query<Access>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    if !shared.knows(&access) || !headers.contains_key(ORIGIN) {
        return StatusCode::FORBIDDEN.into_response();
    }
    let broadcast = match access.side {
        None => shared.broadcast.clone(),
        Some(side) => match shared.sides.get(side) {
            Some(broadcast) => broadcast.clone(),
            None => return StatusCode::NOT_FOUND.into_response(),
        },
    };
    let may_steer = shared.pilot.is(&access.token) && access.side.is_none();
    let upgrade = upgrade.max_message_size(LONGEST_REQUEST).max_frame_size(LONGEST_REQUEST);
    upgrade.on_upgrade(move |socket| async move {
        let viewers = shared.viewers.fetch_add(1, Ordering::AcqRel);
        if viewers < MOST_VIEWERS {
            // A broken connection needs no answer.
            let _ = attend(socket, &shared, &broadcast, may_steer).await;
        }
        shared.viewers.fetch_sub(1, Ordering::AcqRel);
    })
}

impl Shared {
    fn knows(&self, access: &Access) -> bool {
        self.pilot.is(&access.token) || self.viewer.is(&access.token)
    }

    /// The answer to a request; none if the run has stopped.
    async fn ask(&self, command: Command) -> Option<Value> {
        let (answer, answered) = oneshot::channel();
        let answer = Box::new(move |value| drop(answer.send(value)));
        self.requests.send(runner::Request { command, answer }).ok()?;
        Some(answered.await.unwrap_or_default())
    }
}

/// Sends everything to a browser, and takes the pilot's requests. A browser that may steer becomes the pilot once there
/// is no other pilot.
async fn attend(
    mut socket: WebSocket,
    shared: &Shared,
    broadcast: &Broadcast,
    may_steer: bool,
) -> Result<(), axum::Error> {
    let pilot = |is_pilot: bool| json!({ "pilot": is_pilot }).to_string();
    let mut helm = may_steer.then(|| shared.helm.try_acquire().ok()).flatten();
    let mut frames = broadcast.listen();
    let (greeting, present) = broadcast.present();
    for text in greeting.into_iter().chain([present, pilot(helm.is_some()).into()]) {
        send(&mut socket, &text).await?;
    }
    loop {
        tokio::select! {
            frame = frames.recv() => match frame {
                Ok(frame) if frame.is_empty() => return socket.send(Message::Close(None)).await,
                Ok(frame) => send(&mut socket, &frame).await?,
                // A slow browser gets the present state instead of what it has missed: others do not wait for it.
                Err(broadcast::error::RecvError::Lagged(_)) => {
                    frames = frames.resubscribe();
                    send(&mut socket, &broadcast.present().1).await?;
                }
                Err(broadcast::error::RecvError::Closed) => return Ok(()),
            },
            free = shared.helm.acquire(), if may_steer && helm.is_none() => {
                helm = free.ok();
                send(&mut socket, &pilot(helm.is_some())).await?;
            }
            request = socket.recv() => {
                if !take(&mut socket, shared, request.transpose()?, helm.is_some()).await? {
                    return Ok(());
                }
            }
        }
    }
}

/// Takes what a browser has sent, if anything. Returns whether the connection continues.
async fn take(
    socket: &mut WebSocket,
    shared: &Shared,
    received: Option<Message>,
    is_pilot: bool,
) -> Result<bool, axum::Error> {
    match received {
        Some(Message::Text(text)) => {
            let answer = match is_pilot {
                true => ask(shared, &text).await,
                false => json!({ "refused": "another client is controlling this run" }),
            };
            send(socket, &answer.to_string()).await?;
            Ok(true)
        }
        Some(Message::Ping(_) | Message::Pong(_)) => Ok(true),
        Some(Message::Binary(_)) => {
            let reason = CloseFrame { code: 1003, reason: "requests are text".into() };
            socket.send(Message::Close(Some(reason))).await?;
            Ok(false)
        }
        Some(Message::Close(_)) | None => Ok(false),
    }
}

async fn send(socket: &mut WebSocket, text: &str) -> Result<(), axum::Error> {
    socket.send(Message::Text(text.into())).await
}

/// The answer to a request.
async fn ask(shared: &Shared, text: &str) -> Value {
    let command = match Command::read(text) {
        Ok(command) => command,
        Err(reason) => return json!({ "refused": reason }),
    };
    match shared.ask(command).await {
        Some(answer) => json!({ "answer": answer }),
        None => json!({ "refused": "the run has stopped" }),
    }
}
