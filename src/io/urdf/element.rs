use super::{Location, UrdfError};
use nalgebra::{SVector, Unit};
use roxmltree::{Document, Node};
use std::path::Path;

/// Largest length of an attribute in a message (characters).
const EXCERPT_LENGTH: usize = 60;

/// Parsed text of a URDF file.
pub(super) struct Source<'a> {
    path: Option<&'a Path>,
    document: &'a Document<'a>,
    /// Offset of each line in the text (bytes).
    line_starts: Vec<usize>,
}

/// Element of a URDF file.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
    source: &'a Source<'a>,
}

impl<'a> Source<'a> {
    pub fn new(path: Option<&'a Path>, document: &'a Document<'a>) -> Self {
        let text = document.input_text();
        let after_feeds = text.match_indices('\n').map(|(offset, _)| offset + 1);
        Self {
            path,
            document,
            line_starts: [0].into_iter().chain(after_feeds).collect(),
        }
    }

    pub fn root(&'a self) -> Element<'a> {
        Element {
            node: self.document.root_element(),
            source: self,
        }
    }

    /// Line number of an offset, counted from 1.
    fn line(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|&start| start <= offset)
    }
}

impl<'a> Element<'a> {
    /// Name of the element.
    pub fn tag(self) -> &'a str {
        self.node.tag_name().name()
    }

    /// Whether the element has a namespace whose address contains this word.
    pub fn is_of_namespace(self, word: &str) -> bool {
        let namespace = self.node.tag_name().namespace();
        namespace.is_some_and(|address| address.contains(word))
    }

    pub fn line(self) -> usize {
        self.source.line(self.node.range().start)
    }

    pub fn location(self) -> Location {
        Location {
            path: self.source.path.map(Path::to_owned),
            line: self.line(),
            element: self.description(),
        }
    }

    /// Describes a link, a joint or the robot by its name. Describes another element by its tag and by the link, joint or robot around it.
    fn description(self) -> String {
        let named = |node: Node| {
            let tag = node.tag_name().name();
            match node.attribute("name") {
                Some(name) => format!("{tag} {:?}", excerpt(name)),
                None => format!("<{tag}>"),
            }
        };
        let owner = self.node.ancestors().find(|node| {
            let is_owner = |tag| node.has_tag_name(tag);
            ["link", "joint", "robot"].into_iter().any(is_owner)
        });
        match owner {
            None => format!("<{}>", self.tag()),
            Some(owner) if owner == self.node => named(owner),
            Some(owner) => format!("<{}> of {}", self.tag(), named(owner)),
        }
    }

    /// All elements directly inside this element.
    pub fn elements(self) -> impl Iterator<Item = Self> {
        let nodes = self.node.children().filter(Node::is_element);
        nodes.map(move |node| Self { node, ..self })
    }

    /// The elements with this tag directly inside this element.
    pub fn elements_named(self, tag: &'static str) -> impl Iterator<Item = Self> {
        self.elements().filter(move |element| element.tag() == tag)
    }

    /// Returns the only element with this tag directly inside this element, or `None` if no element has this tag.
    ///
    /// # Errors
    /// If more than one element has this tag.
    pub fn child(self, tag: &'static str) -> Result<Option<Self>, UrdfError> {
        let mut elements = self.elements_named(tag);
        let first = elements.next();
        match elements.next() {
            None => Ok(first),
            Some(second) => Err(UrdfError::RepeatedElement {
                at: second.location(),
            }),
        }
    }

    /// Returns the element of [`Self::child`], which must exist. `expected` is the tag in angle brackets.
    ///
    /// # Errors
    /// If no element or more than one element has this tag.
    pub fn required_child(
        self,
        tag: &'static str,
        expected: &'static str,
    ) -> Result<Self, UrdfError> {
        self.child(tag)?
            .ok_or_else(|| self.missing_element(expected))
    }

    pub fn missing_element(self, expected: &'static str) -> UrdfError {
        UrdfError::MissingElement {
            at: self.location(),
            expected,
        }
    }

    pub fn attribute(self, attribute: &'static str) -> Option<&'a str> {
        self.node.attribute(attribute)
    }

    pub fn required_attribute(self, attribute: &'static str) -> Result<&'a str, UrdfError> {
        let found = self.attribute(attribute);
        found.ok_or_else(|| self.missing_attribute(attribute))
    }

    fn missing_attribute(self, attribute: &'static str) -> UrdfError {
        UrdfError::MissingAttribute {
            at: self.location(),
            attribute,
        }
    }

    /// Returns the text of an attribute, which must not be empty.
    pub fn name_in(self, attribute: &'static str) -> Result<&'a str, UrdfError> {
        match self.required_attribute(attribute)? {
            "" => Err(UrdfError::EmptyName {
                at: self.location(),
                attribute,
            }),
            name => Ok(name),
        }
    }

    /// Returns the whitespace-separated finite numbers of an attribute, or `None` without the attribute.
    pub fn numbers<const N: usize>(
        self,
        attribute: &'static str,
    ) -> Result<Option<[f64; N]>, UrdfError> {
        let Some(text) = self.attribute(attribute) else {
            return Ok(None);
        };
        let numbers = parsed(text).filter(|numbers| numbers.iter().all(|x: &f64| x.is_finite()));
        let expected = match N {
            1 => "one finite number",
            3 => "three finite numbers",
            _ => "four finite numbers",
        };
        let error = || self.not_a_number(attribute, text, expected);
        numbers.ok_or_else(error).map(Some)
    }

    pub fn required_numbers<const N: usize>(
        self,
        attribute: &'static str,
    ) -> Result<[f64; N], UrdfError> {
        let numbers = self.numbers(attribute)?;
        numbers.ok_or_else(|| self.missing_attribute(attribute))
    }

    /// Returns the finite number of an attribute, or `None` without the attribute.
    pub fn number(self, attribute: &'static str) -> Result<Option<f64>, UrdfError> {
        Ok(self.numbers(attribute)?.map(|[number]| number))
    }

    pub fn required_number(self, attribute: &'static str) -> Result<f64, UrdfError> {
        self.required_numbers(attribute).map(|[number]| number)
    }

    /// Returns the number of an attribute, which may be infinite, or `None` without the attribute.
    pub fn bound(self, attribute: &'static str) -> Result<Option<f64>, UrdfError> {
        let Some(text) = self.attribute(attribute) else {
            return Ok(None);
        };
        match parsed(text) {
            Some([number]) if !number.is_nan() => Ok(Some(number)),
            _ => Err(self.not_a_number(attribute, text, "one number")),
        }
    }

    fn not_a_number(
        self,
        attribute: &'static str,
        text: &str,
        expected: &'static str,
    ) -> UrdfError {
        UrdfError::NotANumber {
            at: self.location(),
            attribute,
            found: excerpt(text),
            expected,
        }
    }

    /// Returns a number of an attribute if it is at least zero.
    pub fn at_least_zero(self, attribute: &'static str, number: f64) -> Result<f64, UrdfError> {
        if number >= 0.0 {
            return Ok(number);
        }
        Err(self.out_of_range(attribute, number, "at least zero"))
    }

    /// Returns the numbers of an attribute if they are positive.
    pub fn positive<const N: usize>(self, attribute: &'static str) -> Result<[f64; N], UrdfError> {
        let numbers = self.required_numbers(attribute)?;
        match numbers.iter().find(|&&number| number <= 0.0) {
            None => Ok(numbers),
            Some(&number) => Err(self.out_of_range(attribute, number, "positive numbers")),
        }
    }

    pub fn out_of_range(
        self,
        attribute: &'static str,
        found: f64,
        expected: &'static str,
    ) -> UrdfError {
        UrdfError::OutOfRange {
            at: self.location(),
            attribute,
            found,
            expected,
        }
    }

    /// Returns the direction of the vector of an attribute.
    ///
    /// The vector is divided by its largest entry first, so that its norm neither overflows nor underflows.
    pub fn direction<const N: usize>(
        self,
        attribute: &'static str,
        numbers: [f64; N],
    ) -> Result<Unit<SVector<f64, N>>, UrdfError> {
        let vector = SVector::from(numbers);
        let largest = vector.amax();
        if largest > 0.0 {
            return Ok(Unit::new_normalize(vector / largest));
        }
        Err(UrdfError::ZeroDirection {
            at: self.location(),
            attribute,
        })
    }
}

/// Parses whitespace-separated numbers. Returns `None` if the text does not have N numbers.
fn parsed<const N: usize>(text: &str) -> Option<[f64; N]> {
    let mut words = text.split_ascii_whitespace();
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok()?;
    }
    words.next().is_none().then_some(numbers)
}

/// First characters of a text.
pub(super) fn excerpt(text: &str) -> String {
    text.chars().take(EXCERPT_LENGTH).collect()
}
