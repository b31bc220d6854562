//! The documents of an editor, and the answers to its requests.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;

use checks::findings::Findings;
use diagnostics::normal;
use editor::{Documents, FileContext, TextLines, Unit};
use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::{
    CompletionOptions, Diagnostic, DidChangeTextDocumentParams, DidChangeWorkspaceFoldersParams,
    DidCloseTextDocumentParams, DidOpenTextDocumentParams, InitializeParams, LogMessageParams, MessageType, OneOf,
    PositionEncodingKind, PublishDiagnosticsParams, RenameOptions, ResourceOperationKind, ServerCapabilities,
    TextDocumentContentChangeEvent, TextDocumentSyncCapability, TextDocumentSyncKind, TextDocumentSyncOptions, Uri,
    WorkDoneProgressOptions, WorkspaceFoldersServerCapabilities, WorkspaceServerCapabilities,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::checker::{self, Job};
use crate::guard::guarded;
use crate::incoming::{CheckResult, Incoming, parsed};
use crate::questions::{Abilities, Questions};
use crate::{address, wire};

/// An open document.
struct Opened {
    /// Its address, as the editor writes it.
    address: Uri,
    version: i32,
}

/// What the editor shows for a file.
struct Published {
    version: Option<i32>,
    diagnostics: Vec<Diagnostic>,
}

/// One editor.
pub(crate) struct Server {
    unit: Unit,
    documents: Documents,
    /// By path.
    opened: BTreeMap<PathBuf, Opened>,
    /// By path; files without findings are left out, unless they are open.
    published: BTreeMap<PathBuf, Published>,
    /// The number of edits so far.
    edits: u64,
    /// What belongs to each open document.
    contexts: BTreeMap<PathBuf, FileContext>,
    /// The files of each scenario near an open document.
    scenarios: Vec<BTreeSet<PathBuf>>,
    /// What is shown.
    findings: Findings,
    abilities: Abilities,
    /// Whether the editor can watch files.
    watches: bool,
    checker: Sender<Job>,
    send: Box<dyn Fn(Message)>,
}

impl Server {
    /// A server for the editor that `params` describe. Its messages go to `send`, and the results of checks to
    /// `results`.
    pub(crate) fn new(params: &InitializeParams, send: impl Fn(Message) + 'static, results: Sender<Incoming>) -> Self {
        let general = params.capabilities.general.as_ref();
        let units = general.and_then(|general| general.position_encodings.as_ref());
        let is_utf8 = units.is_some_and(|units| units.contains(&PositionEncodingKind::UTF8));
        #[expect(deprecated, reason = "editors without folders still name the root")]
        let root = params.root_uri.iter();
        let folders = params.workspace_folders.iter().flatten().map(|folder| &folder.uri);
        let folders = folders.chain(root).filter_map(address::path).map(|path| normal(&path)).collect();
        let workspace = params.capabilities.workspace.as_ref();
        let edits = workspace.and_then(|workspace| workspace.workspace_edit.as_ref());
        let operations = edits.and_then(|edits| edits.resource_operations.as_ref());
        let orders_changes = edits.and_then(|edits| edits.document_changes).unwrap_or_default();
        let renames_files = operations.is_some_and(|known| known.contains(&ResourceOperationKind::Rename));
        let abilities = Abilities { orders_changes, renames_files: orders_changes && renames_files };
        Self {
            unit: if is_utf8 { Unit::Utf8 } else { Unit::Utf16 },
            documents: Documents { folders, ..Documents::default() },
            opened: BTreeMap::new(),
            published: BTreeMap::new(),
            edits: 0,
            contexts: BTreeMap::new(),
            scenarios: Vec::new(),
            findings: Findings::new(),
            abilities,
            watches: workspace
                .and_then(|workspace| workspace.did_change_watched_files.as_ref()?.dynamic_registration)
                .unwrap_or_default(),
            checker: checker::start(results),
            send: Box::new(send),
        }
    }

    /// What it does for an editor.
    pub(crate) fn capabilities(&self) -> ServerCapabilities {
        let sync = TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::INCREMENTAL),
            save: Some(true.into()),
            ..TextDocumentSyncOptions::default()
        };
        let folders =
            WorkspaceFoldersServerCapabilities { supported: Some(true), change_notifications: Some(OneOf::Left(true)) };
        ServerCapabilities {
            position_encoding: Some(match self.unit {
                Unit::Utf8 => PositionEncodingKind::UTF8,
                Unit::Utf16 => PositionEncodingKind::UTF16,
            }),
            text_document_sync: Some(TextDocumentSyncCapability::Options(sync)),
            completion_provider: Some(CompletionOptions {
                trigger_characters: Some(["<", "(", ",", ".", "\"", "[", " "].map(str::to_owned).to_vec()),
                ..CompletionOptions::default()
            }),
            hover_provider: Some(true.into()),
            definition_provider: Some(OneOf::Left(true)),
            references_provider: Some(OneOf::Left(true)),
            document_symbol_provider: Some(OneOf::Left(true)),
            rename_provider: Some(OneOf::Right(RenameOptions {
                prepare_provider: Some(true),
                work_done_progress_options: WorkDoneProgressOptions::default(),
            })),
            code_action_provider: Some(true.into()),
            document_formatting_provider: Some(OneOf::Left(true)),
            workspace: Some(WorkspaceServerCapabilities { workspace_folders: Some(folders), file_operations: None }),
            ..ServerCapabilities::default()
        }
    }

    pub(crate) fn reply(&self, response: Response) {
        (self.send)(response.into());
    }

    /// Answers a request.
    pub(crate) fn request(&self, request: Request) {
        let Request { id, method, params } = request;
        let answer = guarded(|| self.answer(&method, params));
        let answer = answer.unwrap_or_else(|defect| Err((ErrorCode::InternalError, defect)));
        self.reply(match answer {
            Ok(result) => Response::new_ok(id, result),
            Err((code, message)) => Response::new_err(id, code as i32, message),
        });
    }

    fn answer(&self, method: &str, params: Value) -> Result<Value, Refusal> {
        let asked = Questions {
            unit: self.unit,
            abilities: self.abilities,
            documents: &self.documents,
            contexts: &self.contexts,
            scenarios: &self.scenarios,
            findings: &self.findings,
            address: &|path| self.address(path),
        };
        match method {
            "textDocument/completion" => understood(params, |params| Ok(json!(asked.completion(&params)))),
            "textDocument/hover" => understood(params, |params| Ok(json!(asked.hover(&params)))),
            "textDocument/definition" => understood(params, |params| Ok(json!(asked.definition(&params)))),
            "textDocument/references" => understood(params, |params| Ok(json!(asked.references(&params)))),
            "textDocument/documentSymbol" => understood(params, |params| Ok(json!(asked.symbols(&params)))),
            "textDocument/prepareRename" => understood(params, |params| Ok(json!(asked.prepare_rename(&params)))),
            "textDocument/rename" => understood(params, |params| {
                asked.rename(&params).map(|edit| json!(edit)).map_err(|why| (ErrorCode::RequestFailed, why))
            }),
            "textDocument/codeAction" => understood(params, |params| Ok(json!(asked.actions(&params)))),
            "textDocument/formatting" => understood(params, |params| {
                asked.formatting(&params).map(|edits| json!(edits)).map_err(|why| (ErrorCode::RequestFailed, why))
            }),
            _ => Err((ErrorCode::MethodNotFound, format!("steward does not answer `{method}`"))),
        }
    }

    /// Follows what happens in the editor.
    pub(crate) fn notification(&mut self, said: Notification) {
        let understood = match said.method.as_str() {
            "textDocument/didOpen" => parsed(said.params).map(|params| self.open(params)),
            "textDocument/didChange" => parsed(said.params).map(|params| self.change(params)),
            "textDocument/didClose" => parsed(said.params).map(|params| self.close(&params)),
            "workspace/didChangeWorkspaceFolders" => parsed(said.params).map(|params| self.change_folders(&params)),
            // Other files of a scenario may have changed, too.
            "textDocument/didSave" | "workspace/didChangeWatchedFiles" => Some(()),
            _ => return,
        };
        match understood {
            Some(()) => self.check(),
            None => self.log(format!("`{}` does not have the parameters of the protocol", said.method)),
        }
    }

    /// Asks the editor to say when files change outside of it.
    pub(crate) fn watch_files(&self) {
        if self.watches {
            let files = json!({ "watchers": [{ "globPattern": "**/*.{toml,xml,scxml,scope,jani,yaml,yml,ini,pgm,png,bmp,msg,srv,action}" }] });
            let wish = json!({ "id": "files", "method": "workspace/didChangeWatchedFiles", "registerOptions": files });
            let wishes = json!({ "registrations": [wish] });
            (self.send)(Request::new("files".to_owned().into(), "client/registerCapability".to_owned(), wishes).into());
        }
    }

    fn open(&mut self, params: DidOpenTextDocumentParams) {
        let document = params.text_document;
        let Some(path) = address::path(&document.uri) else { return };
        let path = normal(&path);
        self.documents.put(path.clone(), &document.text);
        self.opened.insert(path, Opened { address: document.uri, version: document.version });
    }

    fn change(&mut self, params: DidChangeTextDocumentParams) {
        let Some(path) = address::path(&params.text_document.uri).map(|path| normal(&path)) else { return };
        let unit = self.unit;
        let (Some(text), Some(opened)) = (self.documents.whole(&path), self.opened.get_mut(&path)) else {
            return self.log(format!("{} was changed, but is not open", path.display()));
        };
        let changed = params.content_changes.iter().fold(text, |text, change| edited(text, change, unit));
        self.documents.put(path, &changed);
        opened.version = params.text_document.version;
    }

    fn close(&mut self, params: &DidCloseTextDocumentParams) {
        let Some(path) = address::path(&params.text_document.uri).map(|path| normal(&path)) else { return };
        self.documents.open.remove(&path);
        self.documents.marked.remove(&path);
        self.opened.remove(&path);
    }

    fn change_folders(&mut self, params: &DidChangeWorkspaceFoldersParams) {
        let path = |folder: &lsp_types::WorkspaceFolder| address::path(&folder.uri).map(|path| normal(&path));
        let removed: Vec<PathBuf> = params.event.removed.iter().filter_map(path).collect();
        self.documents.folders.retain(|folder| !removed.contains(folder));
        self.documents.folders.extend(params.event.added.iter().filter_map(path));
    }

    /// Has the documents checked as they are now.
    fn check(&mut self) {
        self.edits += 1;
        // The thread ends only with the server.
        let _ = self.checker.send((self.edits, self.documents.clone()));
    }

    /// Shows the findings of a check, unless there has been an edit since. A file that has none any more is cleared.
    pub(crate) fn publish(&mut self, checked: CheckResult) {
        if checked.edit != self.edits {
            return;
        }
        let found = match checked.found {
            Ok(checked) => {
                self.contexts = checked.contexts;
                self.scenarios = checked.scenarios;
                checked.findings
            }
            Err(message) => return self.log(message),
        };
        let mut shown: BTreeMap<PathBuf, Published> = BTreeMap::new();
        let gone = self.published.keys().map(|path| (path, None));
        let open = self.opened.keys().map(|path| (path, None));
        for (path, in_text) in gone.chain(open).chain(found.iter().map(|(path, found)| (path, Some(found)))) {
            let Some(address) = self.address(path) else { continue };
            let diagnostics = in_text.map(|found| {
                let lines = self.documents.lines(path, &found.text);
                wire::diagnostics(found, &lines, &address, self.unit)
            });
            let diagnostics = diagnostics.unwrap_or_default();
            let version = self.opened.get(path).map(|opened| opened.version);
            shown.insert(path.clone(), Published { version, diagnostics });
        }
        for (path, Published { version, diagnostics }) in &shown {
            let before = self.published.get(path);
            if before.is_some_and(|before| before.version == *version && before.diagnostics == *diagnostics) {
                continue;
            }
            if let Some(uri) = self.address(path) {
                let params = PublishDiagnosticsParams { uri, diagnostics: diagnostics.clone(), version: *version };
                self.notify("textDocument/publishDiagnostics", &params);
            }
        }
        shown.retain(|path, published| !published.diagnostics.is_empty() || self.opened.contains_key(path));
        self.published = shown;
        self.findings = found;
    }

    /// The address of a file, as the editor writes it.
    fn address(&self, path: &Path) -> Option<Uri> {
        self.opened.get(path).map(|opened| opened.address.clone()).or_else(|| address::of(path))
    }

    fn notify(&self, method: &str, params: &impl Serialize) {
        (self.send)(Notification::new(method.to_owned(), json!(params)).into());
    }

    fn log(&self, message: String) {
        self.notify("window/logMessage", &LogMessageParams { typ: MessageType::ERROR, message });
    }
}

/// Why a request is not answered.
type Refusal = (ErrorCode, String);

/// The answer to a request with these parameters.
fn understood<T: DeserializeOwned>(
    params: Value,
    answer: impl FnOnce(T) -> Result<Value, Refusal>,
) -> Result<Value, Refusal> {
    serde_json::from_value(params).map_err(|error| (ErrorCode::InvalidParams, error.to_string())).and_then(answer)
}

/// The text after a change.
fn edited(mut text: String, change: &TextDocumentContentChangeEvent, unit: Unit) -> String {
    let Some(range) = change.range else { return change.text.clone() };
    let lines = TextLines::of(&text);
    let [start, end] = [range.start, range.end].map(|place| lines.byte(wire::of_position(place), unit));
    text.replace_range(start..end.max(start), &change.text);
    text
}
