//! An editor that shows what the server publishes, and nothing else.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::steward::binary;

/// An editor with a folder of its own.
pub(crate) struct Editor {
    server: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
    pub(crate) folder: TempDir,
    /// The text and version of each open document.
    documents: BTreeMap<String, (String, i32)>,
    /// What is shown for each file.
    shown: BTreeMap<String, Vec<Value>>,
    requests: i32,
    responses: VecDeque<Value>,
    capabilities: Value,
    /// Whether the server has asked to be told about changed files.
    pub(crate) is_watching: bool,
}

impl Editor {
    /// Starts the server for an empty folder.
    pub(crate) fn new() -> Self {
        Self::with(json!({}))
    }

    /// Starts the server for an editor with these capabilities.
    pub(crate) fn with(capabilities: Value) -> Self {
        let mut server = Command::new(binary());
        let server = server.arg("lsp").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut server = server.spawn().unwrap();
        let (input, output) = (server.stdin.take(), BufReader::new(server.stdout.take().unwrap()));
        let mut editor = Self {
            server,
            input,
            output,
            folder: tempfile::tempdir().unwrap(),
            documents: BTreeMap::new(),
            shown: BTreeMap::new(),
            requests: 0,
            responses: VecDeque::new(),
            capabilities: Value::Null,
            is_watching: false,
        };
        let folders = json!([{ "uri": editor.address(""), "name": "test" }]);
        let params = json!({ "processId": null, "capabilities": capabilities, "workspaceFolders": folders });
        editor.capabilities = editor.request("initialize", params)["capabilities"].take();
        editor.notify("initialized", json!({}));
        editor
    }

    pub(crate) fn capabilities(&self) -> &Value {
        &self.capabilities
    }

    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.folder.path().join(file)
    }

    pub(crate) fn address(&self, file: &str) -> String {
        format!("file://{}", self.path(file).display())
    }

    /// Writes a file without opening it.
    pub(crate) fn write(&self, file: &str, text: &str) {
        let path = self.path(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// Opens a document, which need not exist as a file.
    pub(crate) fn open(&mut self, file: &str, text: &str) {
        let address = self.address(file);
        self.documents.insert(file.to_owned(), (text.to_owned(), 1));
        let document = json!({ "uri": address, "languageId": "steward", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub(crate) fn close(&mut self, file: &str) {
        self.documents.remove(file);
        self.notify("textDocument/didClose", json!({ "textDocument": { "uri": self.address(file) } }));
    }

    pub(crate) fn text(&self, file: &str) -> &str {
        &self.documents[file].0
    }

    /// Replaces a range of bytes of a document.
    pub(crate) fn edit(&mut self, file: &str, range: std::ops::Range<usize>, with: &str) {
        let (address, (text, version)) = (self.address(file), self.documents.get_mut(file).unwrap());
        let change = json!({
            "range": { "start": position(text, range.start), "end": position(text, range.end) }, "text": with
        });
        text.replace_range(range, with);
        *version += 1;
        let document = json!({ "uri": address, "version": *version });
        self.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
    }

    /// Replaces the first occurrence of a text in a document.
    pub(crate) fn replace(&mut self, file: &str, from: &str, to: &str) {
        let at = self.text(file).find(from).unwrap_or_else(|| panic!("no {from} in {}", self.text(file)));
        self.edit(file, at..at + from.len(), to);
    }

    /// What is shown for a file once the last edit has been checked: for each problem its line from 1, and its message.
    pub(crate) fn problems(&mut self, file: &str) -> Vec<String> {
        let line = |problem: &Value| problem["range"]["start"]["line"].as_u64().unwrap() + 1;
        let shown = self.diagnostics(file);
        shown.iter().map(|problem| format!("{}: {}", line(problem), problem["message"].as_str().unwrap())).collect()
    }

    /// What is shown for a file once the last edit has been checked.
    pub(crate) fn diagnostics(&mut self, file: &str) -> Vec<Value> {
        self.settle();
        self.shown.get(file).cloned().unwrap_or_default()
    }

    /// The files for which something is shown.
    pub(crate) fn with_problems(&mut self) -> Vec<String> {
        self.settle();
        self.shown.iter().filter(|(_, problems)| !problems.is_empty()).map(|(file, _)| file.clone()).collect()
    }

    /// Waits until the last edit has been checked: a document that nothing reads is opened, and
    /// shown last, because files are shown in alphabetical order.
    fn settle(&mut self) {
        let version = self.requests;
        self.requests += 1;
        let file = format!("~settled/{version}.txt");
        let document = json!({ "uri": self.address(&file), "languageId": "txt", "version": version, "text": "" });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
        while !self.shown.contains_key(&file) {
            self.receive();
        }
        self.shown.remove(&file);
        self.notify("textDocument/didClose", json!({ "textDocument": { "uri": self.address(&file) } }));
    }

    /// Asks about a place in a document: the end of the first occurrence of a text in it.
    pub(crate) fn ask_after(&mut self, method: &str, file: &str, after: &str) -> Value {
        let text = self.text(file);
        let at = text.find(after).unwrap_or_else(|| panic!("no {after} in {text}")) + after.len();
        let params = json!({ "textDocument": { "uri": self.address(file) }, "position": position(text, at) });
        self.request(method, params)
    }

    /// The result of a request.
    pub(crate) fn request(&mut self, method: &str, params: Value) -> Value {
        let mut response = self.response(method, params);
        assert!(response.get("error").is_none(), "{method}: {response}");
        response["result"].take()
    }

    /// The response to a request.
    pub(crate) fn response(&mut self, method: &str, params: Value) -> Value {
        self.requests += 1;
        let id = self.requests;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            if let Some(place) = self.responses.iter().position(|response| response["id"] == id) {
                return self.responses.remove(place).unwrap();
            }
            self.receive();
        }
    }

    pub(crate) fn notify(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    pub(crate) fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let input = self.input.as_mut().unwrap();
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        input.flush().unwrap();
    }

    /// Receives one message.
    fn receive(&mut self) {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(self.output.read_line(&mut line).unwrap() > 0, "the server has ended");
            match line.trim().split_once(": ") {
                Some(("Content-Length", written)) => length = written.parse().unwrap(),
                Some(_) => {}
                None => break,
            }
        }
        let mut bytes = vec![0; length];
        self.output.read_exact(&mut bytes).unwrap();
        let mut message: Value = serde_json::from_slice(&bytes).unwrap();
        match message["method"].as_str() {
            Some("textDocument/publishDiagnostics") => {
                let address = message["params"]["uri"].as_str().unwrap();
                let file = address.strip_prefix(&self.address("")).unwrap_or(address).to_owned();
                let Value::Array(problems) = message["params"]["diagnostics"].take() else { panic!("{message}") };
                self.shown.insert(file, problems);
            }
            Some("client/registerCapability") => {
                let answer = json!({ "jsonrpc": "2.0", "id": message["id"], "result": null });
                self.send(&answer);
                self.is_watching = true;
            }
            Some(_) => panic!("{message}"),
            None => self.responses.push_back(message),
        }
    }

    /// Ends the server as the protocol says.
    pub(crate) fn quit(mut self) -> Option<i32> {
        self.request("shutdown", Value::Null);
        self.notify("exit", Value::Null);
        self.input = None;
        self.server.wait().unwrap().code()
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        self.input = None;
        let _ = self.server.wait();
    }
}

/// The position of a byte, in UTF-16.
pub(crate) fn position(text: &str, byte: usize) -> Value {
    let before = &text[..byte];
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let units: usize = before[start..].chars().map(char::len_utf16).sum();
    json!({ "line": before.matches('\n').count(), "character": units })
}

/// The files of a small application.
pub(crate) fn application(editor: &Editor) -> &Path {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let copy = |from: &str, to: &str| editor.write(to, &fs::read_to_string(root.join(from)).unwrap());
    copy("skills/examples/AnnounceArrival.scxml", "skills/AnnounceArrival.scxml");
    copy("skills/examples/Speaker.scxml", "parts/Speaker.scxml");
    copy("skills/examples/speaker.toml", "parts/speaker.toml");
    editor.write("tree.xml", TREE);
    editor.write("said.scope", SCOPE);
    editor.write("hospital.toml", SCENARIO);
    editor.folder.path()
}

pub(crate) const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Tour">
  <BehaviorTree ID="Tour">
    <SequenceWithMemory>
      <GoToDestination/>
      <AnnounceArrival/>
    </SequenceWithMemory>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="GoToDestination"/>
    <Action ID="AnnounceArrival"/>
  </TreeNodesModel>
</root>
"#;

pub(crate) const SCOPE: &str = "property said := always not (Speaker, AnnounceArrival, m[1] = <error>)\n";

pub(crate) const SCENARIO: &str = r#"base = "nominal"
tree = "tree.xml"
skills = "skills"
properties = ["said.scope"]
components.Speaker = { machine = "parts/Speaker.scxml", interface = "parts/speaker.toml" }
expect = {}

[battery]
initial_pct = 80
"#;
