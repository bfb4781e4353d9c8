//! A MaterialX document as it is written: elements with their attributes, each of which remembers its place. What they mean is
//! not known here.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use texgen::{Diagnostic, SourceFile};

/// Elements don't inherit from each other through more than these, which ends circles, too.
const MAX_BASES: usize = 64;

/// Number of an element in its [`Document`].
pub type ElementId = usize;

/// An element of the XML, with what stands in it.
#[derive(Debug, Clone)]
pub struct Element {
    /// Its tag: `nodegraph`, `input`, or for nodes their category, such as `multiply`.
    pub kind: String,
    /// The attributes in the order of the file.
    pub attributes: Vec<(String, String)>,
    /// Elements inside, in the order of the file.
    pub children: Vec<ElementId>,
    /// The one that it stands in; the root has none.
    pub parent: Option<ElementId>,
    /// Which of the document's files it is in.
    pub file: usize,
    /// Bytes of its start tag in that file.
    pub span: Range<usize>,
}

impl Element {
    /// An attribute; one that is empty counts as absent.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found
            .map(|(_, value)| value.trim())
            .filter(|value| !value.is_empty())
    }

    /// Its `name`, empty where it has none.
    pub fn name(&self) -> &str {
        self.attribute("name").unwrap_or("")
    }
}

/// A file and what it includes, as one tree.
#[derive(Debug, Clone)]
pub struct Document {
    /// The root is the first. An included file's root stands where it is included.
    pub(crate) elements: Vec<Element>,
    pub(crate) files: Vec<SourceFile>,
    pub(crate) paths: Vec<PathBuf>,
    /// What stands in each element; those of included files in the root.
    children: Vec<Vec<ElementId>>,
    /// Elements by where they stand and their names; in the root by those that other files call them by.
    by_name: HashMap<(ElementId, String), Vec<ElementId>>,
    /// Definitions by the categories that they define, as other files call them.
    definitions: HashMap<String, Vec<ElementId>>,
    /// Graphs and implementations by the names of the definitions that they implement, as other files call these.
    implementations: HashMap<String, Vec<ElementId>>,
    /// Its materials are those of a model of the same file, which says the rest of them.
    pub(crate) is_of_model: bool,
}

impl Document {
    /// The `materialx` element of the file itself.
    pub const ROOT: ElementId = 0;

    /// An element by its number.
    ///
    /// # Panics
    /// For numbers of other documents.
    pub fn element(&self, id: ElementId) -> &Element {
        &self.elements[id]
    }

    /// The files that it was read from, the first of which includes the others.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// The folder of the file that an element is in.
    pub fn folder(&self, id: ElementId) -> &Path {
        let path = &self.paths[self.element(id).file];
        path.parent().unwrap_or(Path::new(""))
    }

    /// A tree of elements, each of which knows what stands in it.
    pub(crate) fn new(elements: Vec<Element>, files: Vec<SourceFile>, paths: Vec<PathBuf>) -> Self {
        let mut document = Self {
            children: vec![Vec::new(); elements.len()],
            elements,
            files,
            paths,
            by_name: HashMap::new(),
            definitions: HashMap::new(),
            implementations: HashMap::new(),
            is_of_model: false,
        };
        for (id, element) in document.elements.iter().enumerate() {
            let Some(parent) = element.parent.filter(|_| element.kind != "materialx") else {
                continue;
            };
            let parent = match &*document.elements[parent].kind {
                "materialx" => Self::ROOT,
                _ => parent,
            };
            document.children[parent].push(id);
            let name = match parent {
                Self::ROOT => document.qualified(id, element.name()),
                _ => element.name().to_owned(),
            };
            let known = document.by_name.entry((parent, name));
            known.or_default().push(id);
            if let ("nodedef", Some(node)) = (&*element.kind, element.attribute("node")) {
                let name = document.qualified(id, node);
                document.definitions.entry(name).or_default().push(id);
            }
        }
        for (id, element) in document.elements.iter().enumerate() {
            if let Some(name) = element.attribute("nodedef")
                && matches!(&*element.kind, "nodegraph" | "implementation")
            {
                // A definition of its own file's namespace, or else one that is called so everywhere.
                let own = document.qualified(id, name);
                let is_own = document.by_name.contains_key(&(Self::ROOT, own.clone()));
                let name = if is_own { own } else { name.to_owned() };
                document.implementations.entry(name).or_default().push(id);
            }
        }
        document
    }

    /// The namespace of the file that an element stands in.
    pub fn space(&self, id: ElementId) -> Option<&str> {
        self.inherited(id, "namespace")
    }

    /// What other files call something that has this name where an element stands.
    fn qualified(&self, id: ElementId, name: &str) -> String {
        match self.space(id).map(|space| format!("{space}:")) {
            Some(space) if !name.starts_with(&space) => space + name,
            _ => name.to_owned(),
        }
    }

    /// Elements inside of one; those of included files count as the root's own.
    pub fn children(&self, id: ElementId) -> &[ElementId] {
        &self.children[id]
    }

    fn called(&self, parent: ElementId, name: String) -> &[ElementId] {
        let found = self.by_name.get(&(parent, name));
        found.map_or(&[], Vec::as_slice)
    }

    /// What `user` calls by a name inside of an element: in the root first what its own namespace has.
    fn meant(
        &self,
        parent: ElementId,
        user: ElementId,
        name: &str,
    ) -> impl Iterator<Item = ElementId> {
        let own: &[ElementId] = match parent {
            Self::ROOT => self.called(parent, self.qualified(user, name)),
            _ => &[],
        };
        own.iter()
            .chain(self.called(parent, name.to_owned()))
            .copied()
    }

    /// The element that `user` calls by that name inside of another one, or of the nearest that this inherits from.
    pub fn named(&self, parent: ElementId, user: ElementId, name: &str) -> Option<ElementId> {
        self.lineage(parent).find_map(|at| {
            let mut meant = self.meant(at, user, name);
            meant.find(|&child| !matches!(&*self.element(child).kind, "input" | "output"))
        })
    }

    /// The first child of a kind and name.
    pub fn child(&self, parent: ElementId, kind: &str, name: &str) -> Option<ElementId> {
        self.child_for(parent, parent, kind, name)
    }

    /// What stands outside of all graphs, of a kind, and that `user` calls by that name.
    pub fn outermost(&self, user: ElementId, kind: &str, name: &str) -> Option<ElementId> {
        self.child_for(Self::ROOT, user, kind, name)
    }

    fn child_for(
        &self,
        parent: ElementId,
        user: ElementId,
        kind: &str,
        name: &str,
    ) -> Option<ElementId> {
        let mut meant = self.meant(parent, user, name);
        meant.find(|&child| self.element(child).kind == kind)
    }

    /// Definitions of an element's category as a node: those of its own namespace, or else those that are called so everywhere.
    pub fn definitions(&self, id: ElementId) -> &[ElementId] {
        let category = &self.element(id).kind;
        let own = self.definitions.get(&self.qualified(id, category));
        let found = own.or_else(|| self.definitions.get(category));
        found.map_or(&[], Vec::as_slice)
    }

    /// An element and those that it inherits from, the nearest first: they have its kind and stand where it stands.
    pub fn lineage(&self, id: ElementId) -> impl Iterator<Item = ElementId> {
        let base = move |&at: &ElementId| {
            let element = self.element(at);
            let name = element.attribute("inherit")?;
            let parent = element.parent?;
            let parent = match &*self.element(parent).kind {
                "materialx" => Self::ROOT,
                _ => parent,
            };
            self.child_for(parent, at, &element.kind, name)
        };
        std::iter::successors(Some(id), base).take(MAX_BASES)
    }

    /// The graph that a definition is implemented by.
    pub fn implementation(&self, definition: ElementId) -> Option<ElementId> {
        let name = self.qualified(definition, self.element(definition).name());
        let known = self.implementations.get(&name)?;
        known.iter().copied().find_map(|at| {
            let element = self.element(at);
            match &*element.kind {
                "implementation" => {
                    self.outermost(at, "nodegraph", element.attribute("nodegraph")?)
                }
                _ => Some(at),
            }
        })
    }

    /// An `input` of an element (`parameter` in files before 1.37), or else of the nearest that it inherits from.
    pub fn input(&self, parent: ElementId, name: &str) -> Option<ElementId> {
        self.lineage(parent).find_map(|at| {
            let input = self.child(at, "input", name);
            input.or_else(|| self.child(at, "parameter", name))
        })
    }

    /// An `output` of a graph, or else of the nearest that it inherits from: that of a name, or the first.
    pub fn output(&self, graph: ElementId, name: Option<&str>) -> Option<ElementId> {
        self.lineage(graph).find_map(|at| match name {
            Some(name) => self.child(at, "output", name),
            None => {
                let mut inside = self.children(at).iter().copied();
                inside.find(|&child| self.element(child).kind == "output")
            }
        })
    }

    /// An attribute of an element, or of the nearest one that it stands in.
    pub fn inherited(&self, id: ElementId, name: &str) -> Option<&str> {
        let mut at = Some(id);
        while let Some(id) = at {
            let element = self.element(id);
            if let Some(value) = element.attribute(name) {
                return Some(value);
            }
            at = element.parent;
        }
        None
    }

    /// What goes before file names in an element: its own `fileprefix`, or that of the nearest one that it stands in. One that is
    /// empty counts: it takes away those further out.
    pub fn file_prefix(&self, id: ElementId) -> &str {
        let mut at = Some(id);
        while let Some(id) = at {
            let element = self.element(id);
            let mut attributes = element.attributes.iter();
            if let Some((_, prefix)) = attributes.find(|(key, _)| key == "fileprefix") {
                return prefix.trim();
            }
            at = element.parent;
        }
        ""
    }

    /// A warning about an element, which shows its line.
    pub fn warning(&self, id: ElementId, message: impl Into<String>) -> Diagnostic {
        self.at(id, Diagnostic::warning(message))
    }

    /// An error about an element, which shows its line.
    pub fn error(&self, id: ElementId, message: impl Into<String>) -> Diagnostic {
        self.at(id, Diagnostic::error(message))
    }

    fn at(&self, id: ElementId, diagnostic: Diagnostic) -> Diagnostic {
        let element = self.element(id);
        diagnostic.with_label(&self.files[element.file], element.span.clone(), "")
    }
}
