//! Links between nodes: what they give, where they fit, and that they go in no circle.

use std::collections::HashMap;

use super::{Edit, Graph, NodeId};
use crate::graph_error::GraphError;
use crate::interface::Parameter;
use crate::suggest::did_you_mean;
use crate::swizzle::Swizzle;
use crate::value::{OutputType, ParameterType};

/// A link to another node's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// The node it comes from.
    pub source: NodeId,
    /// What it takes of it: an output by name, components; the first output as a whole where there is none.
    pub swizzle: Option<Swizzle>,
}

impl From<NodeId> for Link {
    /// The first output as a whole.
    fn from(source: NodeId) -> Self {
        Self {
            source,
            swizzle: None,
        }
    }
}

impl Graph {
    /// Links a parameter to another node's output.
    ///
    /// # Errors
    /// Unknown parameter; a type that doesn't fit; a circle. The graph is unchanged then.
    pub fn set_link(
        &mut self,
        node: NodeId,
        parameter: &str,
        source: NodeId,
        swizzle: Option<Swizzle>,
    ) -> Result<Edit, GraphError> {
        let place = self.place(node, parameter)?;
        let declared = &self.texture(node).parameters()[place];
        let expected = declared.ty;
        let found = self.link_output(source, swizzle)?;
        if let Err(remedy) = link_fits(found, declared) {
            let name = self.name(source);
            let taken = swizzle.map_or_else(String::new, |swizzle| swizzle.to_string());
            return Err(GraphError::LinkType {
                node: self.name(node).to_owned(),
                parameter: parameter.to_owned(),
                expected,
                source_node: name.to_owned(),
                link: format!("{name}{taken}").into(),
                found,
                remedy: remedy.into(),
            });
        }
        let may_close = node == source || self.nodes[node.index()].was_read;
        if let Some(path) = may_close.then(|| self.path(source, node)).flatten() {
            let mut nodes: Vec<String> = path.iter().map(|&id| self.name(id).to_owned()).collect();
            nodes.insert(0, self.name(node).to_owned());
            return Err(GraphError::Cycle { nodes });
        }
        let link = Some(Link { source, swizzle });
        self.nodes[source.index()].was_read = true;
        let input = &mut self.nodes[node.index()].inputs[place];
        let program = std::mem::replace(&mut input.link, link) != link;
        Ok(Edit {
            words: Vec::new(),
            program,
        })
    }

    /// Takes a link away: the parameter has its constant again.
    ///
    /// # Errors
    /// Unknown parameter.
    pub fn clear_link(&mut self, node: NodeId, parameter: &str) -> Result<Edit, GraphError> {
        let place = self.place(node, parameter)?;
        let link = self.nodes[node.index()].inputs[place].link.take();
        Ok(Edit {
            words: Vec::new(),
            program: link.is_some(),
        })
    }

    /// What a link from `source` through `swizzle` gives.
    ///
    /// # Errors
    /// A swizzle that names components which the source doesn't have.
    pub fn link_output(
        &self,
        source: NodeId,
        swizzle: Option<Swizzle>,
    ) -> Result<OutputType, GraphError> {
        let Some(swizzle) = swizzle else {
            return Ok(self.output(source));
        };
        let output = match swizzle.output() {
            None => self.output(source),
            Some(_) => {
                let number = self.output_number(source, swizzle)?;
                self.texture(source).outputs()[number].ty
            }
        };
        if swizzle.components().is_empty() {
            return Ok(output);
        }
        let inside = swizzle
            .components()
            .iter()
            .all(|&component| usize::from(component) < output.components());
        inside
            .then(|| OutputType::from_components(swizzle.components().len()))
            .flatten()
            .ok_or_else(|| GraphError::LinkSwizzle {
                source_node: self.name(source).to_owned(),
                found: output,
                swizzle,
            })
    }

    /// The place of the output that a link takes among those of the source's texture.
    pub(crate) fn output_number(
        &self,
        source: NodeId,
        swizzle: Swizzle,
    ) -> Result<usize, GraphError> {
        let Some(name) = swizzle.output() else {
            return Ok(0);
        };
        let texture = self.texture(source);
        let names = || texture.outputs().iter().map(|output| output.name.as_str());
        let found = names().position(|known| known == name);
        found.ok_or_else(|| GraphError::UnknownOutput {
            source_node: self.name(source).to_owned(),
            name: name.to_owned(),
            suggestion: did_you_mean(name, names()).map(str::to_owned),
            remedy: match texture.outputs().is_empty() {
                true => format!(
                    "it gives {}, components of which are written like `.x` or `.rgb`",
                    texture.output()
                ),
                false => format!("it has {}", names().collect::<Vec<_>>().join(", ")),
            },
        })
    }

    /// The nodes from `from` to `to` along links, each reading the next one; both included.
    fn path(&self, from: NodeId, to: NodeId) -> Option<Vec<NodeId>> {
        let mut reader: HashMap<NodeId, Option<NodeId>> = HashMap::from([(from, None)]);
        let mut open = vec![from];
        while let Some(node) = open.pop() {
            if node == to {
                let mut path = vec![node];
                let mut at = node;
                while let Some(Some(before)) = reader.get(&at).copied() {
                    path.push(before);
                    at = before;
                }
                path.reverse();
                return Some(path);
            }
            for link in self.nodes[node.index()]
                .inputs
                .iter()
                .filter_map(|input| input.link)
            {
                if let std::collections::hash_map::Entry::Vacant(entry) = reader.entry(link.source)
                {
                    entry.insert(Some(node));
                    open.push(link.source);
                }
            }
        }
        None
    }
}

/// Whether a link that gives `found` can drive a parameter of type `expected`: the same type, a number for
/// everything, `vec3f` for `vec4f`; for a place any vector, whose missing components are 0. Else what to do.
fn link_fits(found: OutputType, parameter: &Parameter) -> Result<(), String> {
    let is_place = parameter.pixel_component().is_some();
    let wanted = match parameter.ty {
        ParameterType::F32 | ParameterType::I32 | ParameterType::U32 | ParameterType::Bool => 1,
        ParameterType::Vec2 => 2,
        ParameterType::Vec3 => 3,
        ParameterType::Vec4 => 4,
        _ => return Err("it can't be linked, give it a constant".into()),
    };
    match found.components() {
        1 => Ok(()),
        _ if is_place && wanted > 1 => Ok(()),
        3 if wanted == 4 => Ok(()),
        given if given == wanted => Ok(()),
        given if given > wanted => Err(format!("take a part of it, like `.{}`", &"xyz"[..wanted])),
        _ => Err("take one component of it, like `.x`, or link a texture that gives more".into()),
    }
}
