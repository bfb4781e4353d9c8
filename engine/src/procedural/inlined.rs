//! The inlined form of all programs, for comparison with renderers that paste textures into their kernels: the same
//! heads, but programs are numbers of functions in the kernel's text, which any edit changes.

use texgen::{GeneratedKernel, Link, emit_inlined, link_word};

use super::wiring::CompileError;
use super::{
    FLAG_BLEND, FLAG_CONSTANT_MASK, HEAD_AO, HEAD_BUMP_PROGRAM, HEAD_FLAGS, HEAD_LINKS, HEAD_MASK,
    HEAD_PROGRAM, HEAD_WORDS, NodeOutput, Output, Procedural,
};

/// Everything that the inlined form has in place of programs and kernel.
#[derive(Debug, Clone)]
pub struct Inlined {
    /// The heads alone; a program is the number of a function.
    pub heads: Vec<u32>,
    /// The kernel's text.
    pub kernel: GeneratedKernel,
}

impl Procedural {
    /// The inlined form of all programs.
    ///
    /// # Errors
    /// As an edit that makes a program which can't be.
    pub fn inlined(&self) -> Result<Inlined, CompileError> {
        let mut heads = self.programs()[..self.wiring.len() * HEAD_WORDS as usize].to_vec();
        // Number 0 means that there is no program.
        let mut programs: Vec<Vec<Link>> = vec![Vec::new()];
        for (wiring, head) in self
            .wiring
            .iter()
            .zip(heads.chunks_exact_mut(HEAD_WORDS as usize))
        {
            let roots = wiring.roots();
            let link = |source: &NodeOutput| {
                let place = roots.iter().position(|&root| root == source.root());
                link_word(place.unwrap_or(0) as u32, source.swizzle)
            };
            for output in Output::ALL {
                if let Some(source) = wiring.output(output) {
                    let word = match output {
                        Output::BUMP => link_word(0, source.swizzle),
                        _ => link(&source),
                    };
                    head[(HEAD_LINKS + output.number()) as usize] = word;
                }
            }
            if head[HEAD_FLAGS as usize] & (FLAG_BLEND | FLAG_CONSTANT_MASK) == FLAG_BLEND
                && let Some(mask) = wiring.mask()
            {
                head[HEAD_MASK as usize] = link(mask);
            }
            let bump: Vec<Link> = (wiring.output(Output::BUMP).iter())
                .map(NodeOutput::root)
                .collect();
            for (word, roots) in [(HEAD_PROGRAM, roots.clone()), (HEAD_BUMP_PROGRAM, bump)] {
                head[word as usize] = match roots.is_empty() {
                    true => 0,
                    false => {
                        programs.push(roots);
                        programs.len() as u32 - 1
                    }
                };
            }
            // The kernel traces its occlusion itself.
            head[HEAD_AO as usize] = 0;
        }
        let kernel = emit_inlined(&self.graph, &programs)?;
        Ok(Inlined { heads, kernel })
    }
}
