//! Where in a listing stands what a broken rule is about.

use crate::program::Program;
use crate::verify::Violation;
use srp_archdesc::diagnostic::Span;
use srp_archdesc::entity::Entity;

/// The line of a listing that a rule is broken in: an instruction, a block or a function of `program`, which was
/// read from it. The start of the listing where it is none of these.
pub fn place(text: &str, program: &Program, broken: &Violation) -> Span {
    let mut lines = written(text);
    let Some(func) = broken.func else {
        return Span::point(0);
    };
    let mut functions = lines.by_ref().filter(|(_, line)| is_entity(line, "fn"));
    let Some(function) = functions.nth(func.index()) else {
        return Span::point(0);
    };
    let Some(block) = broken.block else {
        return span(function);
    };
    let inside = lines.take_while(|(_, line)| !line.starts_with('}'));
    let mut inside = inside
        .skip_while(|(_, line)| !is_entity(line, "bb"))
        .peekable();
    for _ in 0..block.index() {
        inside.next();
        while inside.next_if(|(_, line)| !is_entity(line, "bb")).is_some() {}
    }
    let Some(label) = inside.next() else {
        return span(function);
    };
    let insts = (program.funcs.get(func)).and_then(|f| f.blocks.get(block));
    let number = insts.and_then(|b| b.insts.iter().position(|&i| Some(i) == broken.inst));
    let inst = number.and_then(|number| inside.nth(number));
    span(inst.unwrap_or(label))
}

/// The lines that say something, with where they start.
fn written(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut start = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let at = start + (line.len() - line.trim_start().len());
        start += line.len();
        let line = line.split(';').next().unwrap_or_default().trim();
        (!line.is_empty() && !line.starts_with("//")).then_some((at, line))
    })
}

fn span((at, line): (usize, &str)) -> Span {
    Span::new(at as u32, (at + line.len()) as u32)
}

/// True if a line begins with an entity of this name, such as `bb1`.
fn is_entity(line: &str, name: &str) -> bool {
    let number = line.strip_prefix(name);
    number.is_some_and(|n| n.starts_with(|c: char| c.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Block, Func};

    #[test]
    fn rules_are_broken_in_lines() {
        let text = "// A comment.\nfn0 f() {\nbb0:\n  ret\n}\n\nfn1 g() { ; f.c:1:1\nbb0:\n  jump bb1\nbb1:\n  v0 = \
                    const 0x1\n  v1 = const 0x2 ; f.c:2:2\n  ret\n}\n";
        let text = &format!("file0 \"f.c\"\n{text}");
        let program = crate::text::read(text).expect("it is a listing");
        let at = |func, block: Option<usize>, number: Option<usize>| {
            let (func, block) = (Func::new(func), block.map(Block::new));
            let insts = |b: Block| &program.funcs[func].blocks[b].insts;
            let inst = number.and_then(|n| Some(insts(block?)[n]));
            let broken = Violation {
                func: Some(func),
                block,
                inst,
                message: String::new(),
            };
            let span = place(text, &program, &broken);
            &text[span.start as usize..span.end as usize]
        };
        assert_eq!(at(0, None, None), "fn0 f() {");
        assert_eq!(at(1, None, None), "fn1 g() {");
        assert_eq!(at(1, Some(0), None), "bb0:");
        assert_eq!(at(1, Some(1), None), "bb1:");
        assert_eq!(at(1, Some(1), Some(0)), "v0 = const 0x1");
        assert_eq!(at(1, Some(1), Some(1)), "v1 = const 0x2");
        assert_eq!(at(7, None, None), "");
    }
}
