//! The XML Schema of machine files: it is `docs/machine.xsd` (`BLESS=1` writes that), it has what the reader knows and no
//! more, with a sentence each, and the machines that come along fit it. A misspelt attribute of them is one mistake.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use srp_archdesc::diagnostic::render_all;
use srp_archdesc::machines;
use srp_archdesc::parse;
use srp_archdesc::xml::schema;
use srp_archdesc::xml::tree::{self, Element, Limits};

const LIMITS: Limits = Limits {
    bytes: 1 << 24,
    depth: 64,
    attributes: 64,
};

fn root(xml: &str) -> Element<'_> {
    let document = tree::parse(xml, LIMITS);
    document.root.expect("it is XML")
}

/// The schema with its sentences as attributes: the reader of our own files takes no text between tags.
fn schema_of_attributes() -> String {
    let (open, close) = ("<xs:documentation>", "</xs:documentation>");
    let text = schema();
    let mut parts = text.split(open);
    let mut out = parts.next().expect("there is text").to_owned();
    for part in parts {
        let (said, rest) = part.split_once(close).expect("it is closed");
        let said = said.replace('"', "&quot;");
        out += &format!("<xs:documentation said=\"{said}\"/>{rest}");
    }
    out
}

fn value<'e>(element: &'e Element<'_>, name: &str) -> Option<&'e str> {
    let mut all = element.attributes.iter();
    all.find(|a| a.name == name).map(|a| &*a.value)
}

fn named<'e, 'x>(element: &'e Element<'x>, kind: &str, name: &str) -> Option<&'e Element<'x>> {
    let mut children = element.children.iter().filter(|child| child.name == kind);
    children.find(|child| value(child, "name") == Some(name))
}

fn path(file: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file)
}

#[test]
fn the_schema_is_that_of_the_documentation() {
    let found = schema();
    let path = path("docs/machine.xsd");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(&path, &found).expect("the golden can be written");
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == golden,
        "docs/machine.xsd differs; BLESS=1 takes it up"
    );
}

/// The elements in a type of elements, by name, and its attributes.
struct Type<'e, 'x> {
    elements: BTreeMap<&'e str, &'e Element<'x>>,
    attributes: BTreeMap<&'e str, &'e Element<'x>>,
}

impl<'e, 'x> Type<'e, 'x> {
    fn of(schema: &'e Element<'x>, name: &str) -> Type<'e, 'x> {
        let found = named(schema, "xs:complexType", name).expect("the type is there");
        let all = |of: &'e Element<'x>, kind: &'static str| -> BTreeMap<&'e str, &'e Element<'x>> {
            let children = of.children.iter().filter(move |child| child.name == kind);
            children
                .map(|child| (value(child, "name").expect("a name"), child))
                .collect()
        };
        let choice = found
            .children
            .iter()
            .find(|child| child.name == "xs:choice");
        Type {
            elements: choice.map(|c| all(c, "xs:element")).unwrap_or_default(),
            attributes: all(found, "xs:attribute"),
        }
    }
}

/// The names that the reader says an element has: it says so of one that is nothing like any.
fn known_to_reader(path: &[&str]) -> BTreeSet<String> {
    let mut xml = String::new();
    for name in path {
        xml += &format!("<{name}>");
    }
    let (last, outer) = xml.split_at(xml.rfind('<').expect("a tag"));
    let mut xml = format!(
        "{last}{} qqqqqqqqqqqqqqqqqqqq=\"\">",
        outer.trim_end_matches('>')
    );
    for name in path.iter().rev() {
        xml += &format!("</{name}>");
    }
    let errors = parse("reader.xml", &xml).expect_err("it has no such attribute");
    let error = errors
        .iter()
        .find(|e| e.code == "A0202")
        .expect("the attribute is unknown");
    let names = error
        .help
        .iter()
        .find_map(|help| help.strip_prefix("it has "));
    let names = names.expect("what it has").split(", ");
    names.map(str::to_owned).collect()
}

#[test]
fn the_schema_has_what_the_reader_knows() {
    let text = schema_of_attributes();
    let schema = root(&text);
    let mut todo = vec![(vec!["machine"], "Machine")];
    let (mut paths, mut silent) = (0, Vec::new());
    while let Some((path, name)) = todo.pop() {
        paths += 1;
        let found = Type::of(&schema, name);
        let names = found.elements.keys().chain(found.attributes.keys());
        let names: BTreeSet<String> = names.map(|name| name.to_string()).collect();
        assert_eq!(names, known_to_reader(&path), "{path:?}");
        for (attribute, element) in &found.attributes {
            let annotation = &element.children[0].children[0];
            if value(annotation, "said").is_none_or(|said| said.len() < 8) {
                silent.push(format!("{path:?} {attribute}"));
            }
        }
        for (child, element) in &found.elements {
            let name = value(element, "type").expect("a type");
            todo.push(([&path[..], &[child]].concat(), name));
        }
    }
    assert!(paths > 30, "{paths} elements");
    assert!(silent.is_empty(), "FORMAT.md says nothing of {silent:#?}");
}

/// Holds an element against a type of the schema; returns all attributes that were met, by element.
fn fits<'x>(
    schema: &Element<'_>,
    element: &'x Element<'x>,
    name: &str,
    met: &mut Vec<(&'x Element<'x>, usize)>,
) {
    let found = Type::of(schema, name);
    for (i, attribute) in element.attributes.iter().enumerate() {
        let kind = found.attributes.get(attribute.name);
        let kind = kind.unwrap_or_else(|| panic!("{} {}", element.name, attribute.name));
        let text = &*attribute.value;
        let words: Vec<&str> = (kind.children.iter())
            .filter(|child| child.name == "xs:simpleType")
            .flat_map(|child| &child.children[0].children)
            .filter_map(|word| value(word, "value"))
            .collect();
        let fits = match value(kind, "type") {
            Some("flag") => matches!(text, "true" | "false"),
            Some("number") => text.parse::<u32>().is_ok() || text.starts_with("0x"),
            Some(_) => true,
            None => words.contains(&text),
        };
        assert!(
            fits,
            "{} {}=\"{text}\": {words:?}",
            element.name, attribute.name
        );
        met.push((element, i));
    }
    for child in &element.children {
        let kind = found.elements.get(child.name);
        let kind = kind.unwrap_or_else(|| panic!("{} in {}", child.name, element.name));
        fits(schema, child, value(kind, "type").expect("a type"), met);
    }
}

#[test]
fn machines_that_come_along_fit() {
    let text = schema_of_attributes();
    let schema = root(&text);
    for machine in machines::ALL {
        let arch = parse(machine.name, machine.xml).expect("a machine");
        for xml in [machine.xml.to_owned(), srp_archdesc::xml::write(&arch)] {
            let element = root(&xml);
            fits(&schema, &element, "Machine", &mut Vec::new());
        }
    }
    if Command::new("xmllint").arg("--version").output().is_err() {
        println!("skipped: there is no xmllint");
        return;
    }
    for machine in machines::ALL {
        let file = path(&format!("archdesc/machines/{}.xml", machine.name));
        let mut command = Command::new("xmllint");
        command
            .args(["--noout", "--schema"])
            .arg(path("docs/machine.xsd"));
        let output = command.arg(&file).output().expect("xmllint runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {said}", machine.name);
    }
}

/// Every attribute that the machines use, misspelt by a letter too much, is one mistake with advice.
#[test]
fn a_misspelt_attribute_is_one_mistake() {
    let text = schema_of_attributes();
    let schema = root(&text);
    let mut tried = BTreeSet::new();
    let mut wrong = Vec::new();
    for machine in machines::ALL {
        let arch = parse(machine.name, machine.xml).expect("a machine");
        for xml in [machine.xml.to_owned(), srp_archdesc::xml::write(&arch)] {
            let element = root(&xml);
            let mut met = Vec::new();
            fits(&schema, &element, "Machine", &mut met);
            for (element, i) in met {
                let attribute = &element.attributes[i];
                let name = attribute.name;
                if !tried.insert((element.name.to_owned(), name.to_owned())) {
                    continue;
                }
                let at = attribute.name_span;
                let (before, after) = (&xml[..at.start as usize], &xml[at.end as usize..]);
                // The last letter twice is nearer to the name than to any other.
                let last = name.chars().last().expect("a name has a letter");
                let misspelt = format!("{before}{name}{last}{after}");
                let errors = parse("misspelt.xml", &misspelt).expect_err("it is misspelt");
                let advice = format!("did you mean `{name}`?");
                if errors.len() != 1 || errors[0].help.as_ref() != Some(&advice) {
                    wrong.push(render_all(&errors, &misspelt, false));
                }
            }
        }
    }
    assert!(tried.len() > 80, "{} attributes", tried.len());
    let count = wrong.len();
    assert!(wrong.is_empty(), "{count} attributes: {}", wrong.join("\n"));
}
