//! Markdown in blocks: headings, paragraphs, items of lists, tables, and what stands in fences.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Heading,
    Paragraph,
    Item,
    Table,
    /// What a program prints: a fence of the language `text`.
    Output,
    /// Commands: a fence of another language than Rust, or indented lines.
    Script,
    /// A fence of Rust.
    Program,
}

#[derive(Debug)]
pub struct Block {
    /// Counted from 1.
    pub line: usize,
    pub kind: Kind,
    /// Without the fence; lines of it as they stand.
    pub text: String,
}

impl Block {
    /// The text in one line, by which sentences are found however they are broken.
    pub fn flat(&self) -> String {
        self.text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// What a reader may type: code between backticks, which may go over a line's end, or whole lines.
    pub fn commands(&self) -> Vec<String> {
        match self.kind {
            Kind::Script => self.text.lines().map(without_comment).collect(),
            Kind::Output | Kind::Program => Vec::new(),
            _ => code_spans(&self.flat()).map(str::to_owned).collect(),
        }
    }
}

/// Parts of a text between backticks.
pub fn code_spans(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

fn without_comment(line: &str) -> String {
    line.split(" #").next().unwrap_or(line).trim().to_owned()
}

/// Where a block begins, and of which kind it is.
struct Open {
    block: Block,
    in_fence: bool,
}

pub fn blocks(markdown: &str) -> Vec<Block> {
    let (mut done, mut open) = (Vec::new(), None::<Open>);
    for (index, line) in markdown.lines().enumerate() {
        let trimmed = line.trim();
        if let Some(Open { block, in_fence }) = &mut open {
            let is_fence = trimmed.starts_with("```");
            let goes_on = match in_fence {
                true => !is_fence,
                false => !is_fence && follows(block.kind, line),
            };
            if goes_on {
                block.text += line;
                block.text.push('\n');
                continue;
            }
            let was_fence = *in_fence;
            done.extend(open.take().map(|open| open.block));
            if was_fence {
                continue;
            }
        }
        open = (!trimmed.is_empty()).then(|| opened(index + 1, line));
    }
    done.extend(open.map(|open| open.block));
    done
}

fn opened(number: usize, line: &str) -> Open {
    let fence = line.trim().strip_prefix("```");
    let kind = match fence {
        Some("text") => Kind::Output,
        Some("" | "rust") => Kind::Program,
        Some(_) => Kind::Script,
        None => kind_of(line),
    };
    let text = match fence {
        Some(_) => String::new(),
        None => line.to_owned() + "\n",
    };
    let block = Block {
        line: number,
        kind,
        text,
    };
    Open {
        block,
        in_fence: fence.is_some(),
    }
}

fn kind_of(line: &str) -> Kind {
    match line.trim_start() {
        _ if line.starts_with("    ") => Kind::Script,
        text if text.starts_with('#') => Kind::Heading,
        text if text.starts_with('|') => Kind::Table,
        text if begins_item(text) => Kind::Item,
        _ => Kind::Paragraph,
    }
}

fn begins_item(text: &str) -> bool {
    let number = text.trim_start_matches(|character: char| character.is_ascii_digit());
    text.starts_with("- ") || (number.len() < text.len() && number.starts_with(". "))
}

/// Whether a line belongs to the block above it.
fn follows(kind: Kind, line: &str) -> bool {
    let text = line.trim_start();
    !text.is_empty()
        && match kind {
            Kind::Table => text.starts_with('|'),
            Kind::Script => line.starts_with("    "),
            Kind::Paragraph | Kind::Item => {
                !text.starts_with('|') && !text.starts_with('#') && !begins_item(text)
            }
            Kind::Heading | Kind::Output | Kind::Program => false,
        }
}
