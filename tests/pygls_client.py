#!/usr/bin/env python3
"""Uses `steward lsp` from pygls' client, with lsprotocol's checks of every message: `pygls_client.py STEWARD` (pip
install pygls)."""
import asyncio, pathlib, subprocess, sys, tempfile

from lsprotocol import types
from pygls.lsp.client import BaseLanguageClient



class Editor(BaseLanguageClient):
    def __init__(self):
        super().__init__("steward-tests", "1")
        self.shown, self.news = {}, asyncio.Event()

        @self.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def publish(params):
            self.shown[params.uri] = params
            self.news.set()

    async def problems(self, uri, version):
        """What is shown for this version of a document."""
        while uri not in self.shown or self.shown[uri].version != version:
            self.news.clear()
            await asyncio.wait_for(self.news.wait(), 30)
        return [problem.message for problem in self.shown[uri].diagnostics]


async def session(steward, folder):
    subprocess.run([steward, "init", folder / "app"], check=True, stdout=subprocess.DEVNULL)
    path = folder / "app" / "battery_fault.toml"
    text = path.read_text() + "\n[noise.odometry]\n"
    uri = path.as_uri()
    editor = Editor()
    await editor.start_io(steward, "lsp")
    result = await editor.initialize_async(types.InitializeParams(
        capabilities=types.ClientCapabilities(), process_id=None,
        workspace_folders=[types.WorkspaceFolder(uri=folder.as_uri(), name="test")]))
    assert result.capabilities.position_encoding == types.PositionEncodingKind.Utf16
    editor.initialized(types.InitializedParams())
    document = types.TextDocumentItem(uri=uri, language_id="toml", version=1, text=text + "\nwrong = 1\n")
    editor.text_document_did_open(types.DidOpenTextDocumentParams(text_document=document))
    found = await editor.problems(uri, 1)
    assert any("wrong" in message for message in found), found
    editor.text_document_did_change(types.DidChangeTextDocumentParams(
        text_document=types.VersionedTextDocumentIdentifier(uri=uri, version=2),
        content_changes=[types.TextDocumentContentChangeWholeDocument(text=text)]))
    assert await editor.problems(uri, 2) == []
    here = types.TextDocumentIdentifier(uri=uri)
    place = types.Position(line=text.count("\n"), character=0)
    items = await editor.text_document_completion_async(types.CompletionParams(text_document=here, position=place))
    assert items, "no key of a table is proposed"
    key = types.Position(line=text.split("\n").index("[noise.odometry]"), character=3)
    hover = await editor.text_document_hover_async(types.HoverParams(text_document=here, position=key))
    assert "noise" in hover.contents.value, hover
    symbols = await editor.text_document_document_symbol_async(types.DocumentSymbolParams(text_document=here))
    assert "odometry" in [symbol.name for symbol in symbols], symbols
    await editor.shutdown_async(None)
    editor.exit(None)
    await asyncio.wait_for(editor._server.wait(), 10)
    print(f"pygls: problems of two versions, {len(items)} proposed keys, an explanation and {len(symbols)} symbols")


with tempfile.TemporaryDirectory() as folder:
    asyncio.run(session(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(folder)))
