//! Files to a [`Document`]: XML, and what it includes. Everything is bounded, and nothing outside of the file system is asked.

use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use roxmltree::{Node, ParsingOptions};
use scene::input::{self, Files};
use texgen::{Diagnostic, Diagnostics, SourceFile};

use crate::document::{Document, Element, ElementId};

/// Larger files aren't read.
const MAX_BYTES: u64 = 64 << 20;
/// More files aren't included.
const MAX_FILES: usize = 256;
/// More elements and attributes a file doesn't have.
const MAX_ELEMENTS: u32 = 2_000_000;
/// More prefixes of names that are declared nowhere aren't taken.
const MAX_PREFIXES: usize = 16;
/// What MaterialX comes with, of names that nobody else uses: its nodes are here without its files.
const LIBRARIES: [&str; 5] = ["stdlib", "pbrlib", "bxdf", "nprlib", "cmlib"];
/// Elements don't stand in each other deeper than this; those of MaterialX are at most five deep.
const MAX_DEPTH: usize = 64;
/// An element doesn't have more attributes: each is compared with all of the others.
const MAX_ATTRIBUTES: usize = 1000;

impl Document {
    /// Reads a file with all that it includes.
    ///
    /// # Errors
    /// A file can't be read, is no XML, is no MaterialX, or is too large; with the line where there is one.
    pub fn read(files: &dyn Files, path: &Path) -> Result<Self, Diagnostics> {
        let mut reader = Reader {
            files,
            elements: Vec::new(),
            sources: Vec::new(),
            paths: Vec::new(),
        };
        let text = read_text(files, path).map_err(Diagnostics::from)?;
        reader.file(path, &text, None)?;
        Ok(Self::new(reader.elements, reader.sources, reader.paths))
    }

    /// Reads a text that lies, or would lie, at `path`; what it includes is read from `files`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(files: &dyn Files, path: &Path, text: &str) -> Result<Self, Diagnostics> {
        let mut reader = Reader {
            files,
            elements: Vec::new(),
            sources: Vec::new(),
            paths: Vec::new(),
        };
        reader.file(path, text, None)?;
        Ok(Self::new(reader.elements, reader.sources, reader.paths))
    }
}

fn read_text(files: &dyn Files, path: &Path) -> Result<String, Diagnostic> {
    input::read_text(files, path, MAX_BYTES).map_err(|error| {
        let problem = Diagnostic::error(format!("cannot read {}: {error}", path.display()));
        match error.kind() {
            // It says itself what to do.
            ErrorKind::InvalidData => problem,
            _ => problem.with_note("check the path and the permissions"),
        }
    })
}

struct Reader<'f> {
    files: &'f dyn Files,
    elements: Vec<Element>,
    sources: Vec<SourceFile>,
    paths: Vec<PathBuf>,
}

impl Reader<'_> {
    /// Adds a file, whose root stands in `parent`.
    fn file(
        &mut self,
        path: &Path,
        text: &str,
        parent: Option<ElementId>,
    ) -> Result<(), Diagnostics> {
        let source = SourceFile::new("materialx", path.display().to_string(), text);
        if let Some((at, excess)) = excess(text) {
            let (message, most) = match excess {
                Excess::Depth => (
                    "elements stand in each other too deep",
                    format!("at most {MAX_DEPTH} levels are read"),
                ),
                Excess::Attributes => (
                    "an element has too many attributes",
                    format!("at most {MAX_ATTRIBUTES} are read"),
                ),
            };
            return Err(Diagnostic::error(message)
                .with_label(&source, at..at + 1, "")
                .with_note(most)
                .into());
        }
        let declared;
        let (whole, at, xml) = match parse(text) {
            Err(roxmltree::Error::UnknownNamespace(..)) => {
                let at;
                (declared, at) = with_prefixes(text);
                (&*declared, at, parse(&declared))
            }
            xml => (text, text.len(), xml),
        };
        let length = whole.len() - text.len();
        let added = Added { at, length };
        let xml = xml.map_err(|error| {
            let place = error.pos();
            let at = SourceFile::new("materialx", String::new(), whole)
                .offset(place.row as usize, place.col as usize)
                .map_or(text.len(), |at| added.original(at));
            Diagnostic::error(format!("not valid XML: {error}")).with_label(&source, at..at, "")
        })?;
        let root = xml.root_element();
        let number = self.sources.len();
        self.sources.push(source.clone());
        self.paths.push(path.to_owned());
        if root.tag_name().name() != "materialx" {
            let name = root.tag_name().name();
            let message = format!("this is no MaterialX: its outermost element is <{name}>");
            return Err(Diagnostic::error(message)
                .with_label(&source, added.start_tag(whole, &root), "")
                .with_note("a document begins with <materialx version=\"1.39\">")
                .into());
        }
        self.element(whole, &added, &root, number, parent)
    }

    /// Adds an element with all that is in it.
    fn element(
        &mut self,
        text: &str,
        added: &Added,
        node: &Node<'_, '_>,
        file: usize,
        parent: Option<ElementId>,
    ) -> Result<(), Diagnostics> {
        let mut open = vec![(*node, parent)];
        while let Some((node, parent)) = open.pop() {
            let span = added.start_tag(text, &node);
            if node.tag_name().name() == "include"
                && let (Some(href), Some(parent)) = (node.attribute("href"), parent)
            {
                self.include(href, file, span, parent)?;
                continue;
            }
            let id = self.elements.len();
            // Those of other programs, such as `ui:name`, mustn't take the place of the plain ones.
            let plain = node.attributes().filter(|a| a.namespace().is_none());
            let attributes = plain.map(|a| (a.name().to_owned(), a.value().to_owned()));
            self.elements.push(Element {
                kind: kind(&node),
                attributes: attributes.collect(),
                children: Vec::new(),
                parent,
                file,
                span,
            });
            if let Some(parent) = parent {
                self.elements[parent].children.push(id);
            }
            let inside: Vec<_> = node.children().filter(Node::is_element).collect();
            open.extend(inside.into_iter().rev().map(|child| (child, Some(id))));
        }
        Ok(())
    }

    fn include(
        &mut self,
        href: &str,
        file: usize,
        span: std::ops::Range<usize>,
        parent: ElementId,
    ) -> Result<(), Diagnostics> {
        let source = self.sources[file].clone();
        let problem = |message: String, note: &str| {
            let problem = Diagnostic::error(message).with_label(&source, span.clone(), "");
            Diagnostics::from(problem.with_note(note))
        };
        let folder = self.paths[file].parent();
        let path = plain(&folder.unwrap_or(Path::new("")).join(href));
        // What has been read already is there, also where files include each other.
        if self.paths.iter().any(|known| plain(known) == path) {
            return Ok(());
        }
        if self.sources.len() >= MAX_FILES {
            return Err(problem(
                format!("more than {MAX_FILES} files are included"),
                "put what is needed into fewer files",
            ));
        }
        if is_library(href) && !self.files.has(&path) {
            return Ok(());
        }
        let named = match path.as_os_str().is_empty() {
            true => Path::new(href),
            false => &path,
        };
        let text = input::read_text(self.files, &path, MAX_BYTES).map_err(|error| {
            let remedy = match error.kind() {
                ErrorKind::NotFound => "names of included files are relative to the file itself",
                ErrorKind::InvalidData => "what is included is MaterialX, too",
                _ => "check the permissions",
            };
            problem(format!("cannot read {}: {error}", named.display()), remedy)
        })?;
        self.file(&path, &text, Some(parent))
    }
}

/// A path without `.` and, where a folder stands before it, `..`.
fn plain(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(out.components().next_back(), Some(Component::Normal(_))) =>
            {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

/// Whether a file is one of those that MaterialX comes with.
fn is_library(href: &str) -> bool {
    let mut folders = href.split(['/', '\\']).rev().skip(1);
    folders.any(|folder| folder == "libraries" || LIBRARIES.contains(&folder))
}

/// What has been added to a text so that it is valid XML.
struct Added {
    at: usize,
    length: usize,
}

impl Added {
    /// The place in the text as it is written.
    fn original(&self, at: usize) -> usize {
        match at <= self.at {
            true => at,
            false => at.saturating_sub(self.length).max(self.at),
        }
    }

    /// Bytes of an element's start tag, in the text as it is written.
    fn start_tag(&self, text: &str, node: &Node<'_, '_>) -> std::ops::Range<usize> {
        let range = node.range();
        let whole = &text[range.clone()];
        let end = whole.find('>').map_or(whole.len(), |end| end + 1);
        self.original(range.start)..self.original(range.start + end)
    }
}

fn parse(text: &str) -> Result<roxmltree::Document<'_>, roxmltree::Error> {
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: MAX_ELEMENTS,
        ..ParsingOptions::default()
    };
    roxmltree::Document::parse_with_options(text, options)
}

/// A text with the prefixes of its names declared, and where: MaterialX's namespaces are none of XML's, and many files don't say
/// what `xi:` is.
fn with_prefixes(text: &str) -> (String, usize) {
    let mut whole = text.to_owned();
    let Some(at) = end_of_roots_name(text) else {
        return (whole, text.len());
    };
    for _ in 0..MAX_PREFIXES {
        let Err(roxmltree::Error::UnknownNamespace(prefix, _)) = parse(&whole) else {
            break;
        };
        whole.insert_str(at, &format!(" xmlns:{prefix}=\"{prefix}\""));
    }
    (whole, at)
}

/// Where the name of the outermost element ends. What comments say doesn't count.
fn end_of_roots_name(text: &str) -> Option<usize> {
    const ROOT: &str = "<materialx";
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        if rest.starts_with(ROOT) {
            return Some(at + ROOT.len());
        }
        at += match rest.starts_with("<!--") {
            true => rest.find("-->")? + 3,
            false => 1,
        };
    }
}

/// The name of an element, with the prefix of MaterialX's namespace where it has one.
fn kind(node: &Node<'_, '_>) -> String {
    let name = node.tag_name().name();
    let prefix = |node: &Node<'_, '_>| {
        let space = node.tag_name().namespace()?;
        node.lookup_prefix(space).map(str::to_owned)
    };
    match prefix(node) {
        Some(given) if prefix(&node.document().root_element()).as_ref() != Some(&given) => {
            format!("{given}:{name}")
        }
        _ => name.to_owned(),
    }
}

/// Where a tag ends, which begins a text: values of attributes may contain `>`.
fn end_of_tag(text: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at + 1),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

/// Attributes of a tag, each of which has its own `=`.
fn attributes_of(tag: &str) -> usize {
    let mut quote = None;
    let mut count = 0;
    for byte in tag.bytes() {
        match (quote, byte) {
            (None, b'=') => count += 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    count
}

/// What a text has more of than any MaterialX, and what would take long.
enum Excess {
    Depth,
    Attributes,
}

/// Where elements first stand deeper in each other than they may, or one has more attributes. A rough count of tags: what it gets
/// wrong is no valid XML.
fn excess(text: &str) -> Option<(usize, Excess)> {
    let mut depth = 0usize;
    let mut at = 0;
    while let Some(next) = text[at..].find('<') {
        let start = at + next;
        let rest = &text[start..];
        let end = match rest.starts_with("<!--") {
            true => rest.find("-->").map(|end| end + 3),
            false if rest.starts_with("<![CDATA[") => rest.find("]]>").map(|end| end + 3),
            false => end_of_tag(rest),
        };
        let Some(end) = end else { break };
        let tag = &rest[..end];
        if tag.starts_with("</") {
            depth = depth.saturating_sub(1);
        } else if !tag.starts_with("<!") && !tag.starts_with("<?") && !tag.ends_with("/>") {
            depth += 1;
        }
        if depth > MAX_DEPTH {
            return Some((start, Excess::Depth));
        }
        if !tag.starts_with("<!") && attributes_of(tag) > MAX_ATTRIBUTES {
            return Some((start, Excess::Attributes));
        }
        at = start + end;
    }
    None
}
