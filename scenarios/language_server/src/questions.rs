//! Answers to questions about places in documents.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use checks::Language;
use checks::findings::{Finding, Findings};
use diagnostics::normal;
use editor::proposal::{Proposal, ProposalKind};
use editor::{Documents, EditedFile, FileContext, Mention, NameIndex, NameKind, Project, TextLines, Unit};
use lsp_types as lsp;
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionParams, CompletionItem, CompletionItemKind, CompletionParams,
    CompletionTextEdit, DocumentChangeOperation, DocumentChanges, DocumentFormattingParams, DocumentSymbol,
    DocumentSymbolParams, Documentation, GotoDefinitionParams, Hover, HoverContents, HoverParams, Location,
    MarkupContent, MarkupKind, OneOf, OptionalVersionedTextDocumentIdentifier, ReferenceParams, RenameFile,
    RenameParams, ResourceOp, SymbolKind, TextDocumentEdit, TextDocumentPositionParams, TextEdit, Uri, WorkspaceEdit,
};

use crate::{address, wire};

/// What the editor can do with changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Abilities {
    /// It takes changes of several files in an order.
    pub(crate) orders_changes: bool,
    /// It renames files among them.
    pub(crate) renames_files: bool,
}

/// What the server knows when it is asked.
pub(crate) struct Questions<'s> {
    pub(crate) unit: Unit,
    pub(crate) abilities: Abilities,
    pub(crate) documents: &'s Documents,
    pub(crate) contexts: &'s BTreeMap<PathBuf, FileContext>,
    /// The files of each scenario near an open document.
    pub(crate) scenarios: &'s [BTreeSet<PathBuf>],
    /// What is shown.
    pub(crate) findings: &'s Findings,
    /// The address of a file, as the editor writes it.
    pub(crate) address: &'s dyn Fn(&Path) -> Option<Uri>,
}

/// A place in an open document.
struct Spot {
    path: PathBuf,
    text: Arc<str>,
    /// In bytes.
    at: usize,
}

impl Questions<'_> {
    fn document(&self, address: &Uri) -> Option<(PathBuf, Arc<str>)> {
        let path = normal(&address::path(address)?);
        let text = Arc::clone(self.documents.open.get(&path)?);
        Some((path, text))
    }

    fn spot(&self, asked: &TextDocumentPositionParams) -> Option<Spot> {
        let (path, text) = self.document(&asked.text_document.uri)?;
        let at = self.documents.lines(&path, &text).byte(wire::of_position(asked.position), self.unit);
        Some(Spot { path, text, at })
    }

    fn context(&self, path: &Path) -> FileContext {
        self.contexts.get(path).cloned().unwrap_or_default()
    }

    fn range(&self, path: &Path, text: &str, bytes: &Range<usize>) -> lsp::Range {
        wire::range(&self.documents.lines(path, text), bytes, self.unit)
    }

    pub(crate) fn completion(&self, params: &CompletionParams) -> Option<Vec<CompletionItem>> {
        let spot = self.spot(&params.text_document_position)?;
        let (disk, context) = (self.documents.disk(), self.context(&spot.path));
        let subject = EditedFile { disk: &disk, file: &spot.path, context: &context };
        let lines = self.documents.lines(&spot.path, &spot.text);
        let item = |proposal: Proposal| {
            let range = wire::range(&lines, &proposal.replaces, self.unit);
            CompletionItem {
                label: proposal.name.clone(),
                kind: Some(match proposal.kind {
                    ProposalKind::Key => CompletionItemKind::PROPERTY,
                    ProposalKind::Table => CompletionItemKind::MODULE,
                    ProposalKind::Element => CompletionItemKind::CLASS,
                    ProposalKind::Value => CompletionItemKind::VALUE,
                    ProposalKind::Name => CompletionItemKind::REFERENCE,
                    ProposalKind::Keyword => CompletionItemKind::KEYWORD,
                    ProposalKind::File => CompletionItemKind::FILE,
                }),
                detail: Some(proposal.detail).filter(|detail| !detail.is_empty()),
                documentation: Some(proposal.about)
                    .filter(|about| !about.is_empty())
                    .map(|about| Documentation::MarkupContent(markdown(about))),
                filter_text: Some(proposal.name),
                text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text: proposal.insert })),
                ..CompletionItem::default()
            }
        };
        Some(subject.proposals(&spot.text, spot.at).into_iter().map(item).collect())
    }

    pub(crate) fn hover(&self, params: &HoverParams) -> Option<Hover> {
        let spot = self.spot(&params.text_document_position_params)?;
        let (disk, context) = (self.documents.disk(), self.context(&spot.path));
        let subject = EditedFile { disk: &disk, file: &spot.path, context: &context };
        let explained = subject.explanation(&spot.text, spot.at)?;
        let range = Some(self.range(&spot.path, &spot.text, &explained.range));
        Some(Hover { contents: HoverContents::Markup(markdown(explained.text)), range })
    }

    /// The edit that gives a document its layout; none if its kind has no layout, or if it has that already.
    pub(crate) fn formatting(&self, params: &DocumentFormattingParams) -> Result<Option<Vec<TextEdit>>, String> {
        let Some((path, text)) = self.document(&params.text_document.uri) else { return Ok(None) };
        let Some(language) = Language::of_name(&path) else { return Ok(None) };
        let new_text = language.layout(&path, &text).map_err(|error| error.reasons())?;
        let range = self.range(&path, &text, &(0..text.len()));
        Ok((new_text != *text).then(|| vec![TextEdit { range, new_text }]))
    }

    /// The name at a place, with all names in the files to which its file belongs, and in those of every scenario that
    /// reads one of its definitions.
    fn index(&self, Spot { path, at, .. }: &Spot) -> Option<(NameIndex, Mention)> {
        let mut files = self.context(path).files;
        files.insert(path.clone());
        let of = |files: &BTreeSet<PathBuf>| NameIndex::of(&self.documents.disk(), files.iter().map(PathBuf::as_path));
        let index = of(&files);
        let mention = index.at(path, *at)?.clone();
        let defined: Vec<&PathBuf> =
            index.same(&mention).filter(|same| same.is_definition).map(|same| &same.path).collect();
        let others = self.scenarios.iter().filter(|scenario| defined.iter().any(|path| scenario.contains(*path)));
        let before = files.len();
        files.extend(others.flatten().cloned());
        let index = if files.len() > before { of(&files) } else { index };
        Some((index, mention))
    }

    fn locations<'m>(&self, mentions: impl Iterator<Item = &'m Mention>, index: &NameIndex) -> Vec<Location> {
        let lines: BTreeMap<&Path, TextLines<'_>> =
            index.texts.iter().map(|(path, text)| (path.as_path(), self.documents.lines(path, text))).collect();
        let location = |mention: &Mention| {
            let range = wire::range(lines.get(mention.path.as_path())?, &(mention.start..mention.end), self.unit);
            Some(Location { uri: (self.address)(&mention.path)?, range })
        };
        mentions.filter_map(location).collect()
    }

    pub(crate) fn definition(&self, params: &GotoDefinitionParams) -> Option<Vec<Location>> {
        let spot = self.spot(&params.text_document_position_params)?;
        let (index, mention) = self.index(&spot)?;
        if mention.kind == NameKind::File {
            let uri = (self.address)(Path::new(&mention.name))?;
            return Some(vec![Location { uri, range: lsp::Range::default() }]);
        }
        Some(self.locations(index.same(&mention).filter(|same| same.is_definition), &index))
    }

    pub(crate) fn references(&self, params: &ReferenceParams) -> Option<Vec<Location>> {
        let spot = self.spot(&params.text_document_position)?;
        let (index, mention) = self.index(&spot)?;
        let wanted = index.same(&mention).filter(|same| params.context.include_declaration || !same.is_definition);
        Some(self.locations(wanted, &index))
    }

    pub(crate) fn symbols(&self, params: &DocumentSymbolParams) -> Option<Vec<DocumentSymbol>> {
        let (path, text) = self.document(&params.text_document.uri)?;
        let index = NameIndex::of(&self.documents.disk(), [path.as_path()]);
        let lines = self.documents.lines(&path, &text);
        let symbol = |mention: &Mention| {
            let range = wire::range(&lines, &(mention.start..mention.end), self.unit);
            let (what, kind) = match mention.kind {
                NameKind::Process => ("process", SymbolKind::OBJECT),
                NameKind::Tree => ("tree", SymbolKind::MODULE),
                NameKind::Property => ("property", SymbolKind::PROPERTY),
                NameKind::Place => ("place", SymbolKind::CONSTANT),
                NameKind::State => ("state", SymbolKind::ENUM_MEMBER),
                NameKind::Table => ("table", SymbolKind::NAMESPACE),
                NameKind::File => ("file", SymbolKind::FILE),
            };
            #[expect(deprecated, reason = "the field must be given")]
            DocumentSymbol {
                name: mention.name.clone(),
                detail: Some(what.to_owned()),
                kind,
                tags: None,
                deprecated: None,
                range,
                selection_range: range,
                children: None,
            }
        };
        Some(index.defined_in(&path).map(symbol).collect())
    }

    pub(crate) fn prepare_rename(&self, params: &TextDocumentPositionParams) -> Option<lsp::Range> {
        let spot = self.spot(params)?;
        let (_, mention) = self.index(&spot).filter(|(_, mention)| mention.kind != NameKind::File)?;
        Some(self.range(&spot.path, &spot.text, &(mention.start..mention.end)))
    }

    /// The edits as the editor takes them. Only one that takes changes in order also renames files.
    fn workspace_edit(&self, edits: Vec<TextDocumentEdit>, renamed: Vec<RenameFile>) -> WorkspaceEdit {
        if self.abilities.orders_changes {
            let edits = edits.into_iter().map(DocumentChangeOperation::Edit);
            let renamed = renamed.into_iter().map(|renamed| DocumentChangeOperation::Op(ResourceOp::Rename(renamed)));
            let changes = DocumentChanges::Operations(edits.chain(renamed).collect());
            return WorkspaceEdit { document_changes: Some(changes), ..WorkspaceEdit::default() };
        }
        let plain = |edit: TextDocumentEdit| {
            let edits = edit.edits.into_iter().map(|edit| match edit {
                OneOf::Left(edit) => edit,
                OneOf::Right(annotated) => annotated.text_edit,
            });
            (edit.text_document.uri, edits.collect())
        };
        WorkspaceEdit { changes: Some(edits.into_iter().map(plain).collect()), ..WorkspaceEdit::default() }
    }

    pub(crate) fn rename(&self, params: &RenameParams) -> Result<Option<WorkspaceEdit>, String> {
        let Some(spot) = self.spot(&params.text_document_position) else { return Ok(None) };
        // The check of the last edit may not have ended.
        let checked = Project::default().check(self.documents);
        let now = Questions { contexts: &checked.contexts, scenarios: &checked.scenarios, ..*self };
        let Some((index, mention)) = now.index(&spot) else { return Ok(None) };
        let renaming = editor::rename(self.documents, &index, &mention, &params.new_name)?;
        if let (Some((old, _)), false) = (renaming.files.first(), self.abilities.renames_files) {
            return Err(format!("{} would have another name, but the editor does not rename files", old.display()));
        }
        let edits = renaming.ranges.iter().filter_map(|(path, ranges)| {
            let (_, text) = index.texts.iter().find(|(known, _)| known == path)?;
            self.edits(path, text, ranges.iter().map(|range| (range.clone(), params.new_name.clone())))
        });
        let files = renaming.files.iter().filter_map(|(old, new)| {
            let (old_uri, new_uri) = ((self.address)(old)?, address::of(new)?);
            Some(RenameFile { old_uri, new_uri, options: None, annotation_id: None })
        });
        Ok(Some(self.workspace_edit(edits.collect(), files.collect())))
    }

    fn edits(
        &self,
        path: &Path,
        text: &str,
        edits: impl Iterator<Item = (Range<usize>, String)>,
    ) -> Option<TextDocumentEdit> {
        let lines = self.documents.lines(path, text);
        let edit = |(bytes, new_text): (Range<usize>, String)| {
            OneOf::Left(TextEdit { range: wire::range(&lines, &bytes, self.unit), new_text })
        };
        let text_document = OptionalVersionedTextDocumentIdentifier { uri: (self.address)(path)?, version: None };
        Some(TextDocumentEdit { text_document, edits: edits.map(edit).collect() })
    }

    pub(crate) fn actions(&self, params: &CodeActionParams) -> Option<Vec<CodeAction>> {
        let (path, text) = self.document(&params.text_document.uri)?;
        let lines = self.documents.lines(&path, &text);
        let [start, end] =
            [params.range.start, params.range.end].map(|at| lines.byte(wire::of_position(at), self.unit));
        let shown = self.findings.get(&path).filter(|found| found.text == text)?;
        let here = shown.findings.iter().filter(|finding| finding.range.start <= end && start <= finding.range.end);
        let action = |finding: &Finding| {
            let fix = editor::quick_fix(self.documents, &self.context(&path), &path, finding)?;
            let edits = self.edits(&path, &text, [(fix.range, fix.text)].into_iter())?;
            let address = (self.address)(&path)?;
            Some(CodeAction {
                title: fix.title,
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: Some(vec![wire::diagnostic(finding, &lines, &address, self.unit)]),
                edit: Some(self.workspace_edit(vec![edits], Vec::new())),
                is_preferred: Some(fix.is_certain),
                ..CodeAction::default()
            })
        };
        Some(here.filter_map(action).collect())
    }
}

fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}
