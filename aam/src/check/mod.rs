//! Checks of what a document says, beyond its grammar.

mod animation;
mod codes;
mod geometry;
mod materials;
mod physics;
mod rules;

pub use codes::{CODES, CodeInfo, code_info};
pub use rules::{CodePattern, Rules, UnknownCode, groups};

use crate::document::Object;
use crate::{Document, Finding, Places, Position};

/// Everything odd or wrong in a document, by part: materials, objects, animation, physics.
///
/// With the file's bytes and the places that [`crate::read`] gave, findings have a position.
pub fn check(document: &Document, source: Option<(&[u8], &Places)>) -> Vec<Finding> {
    let mut findings = Findings::default();
    materials::check(document, &mut findings);
    geometry::check(document, &mut findings);
    animation::check(document, &mut findings);
    physics::check(document, &mut findings);
    findings.locate(source)
}

/// Which part of the document a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Document,
    Material(usize),
    Object { frame: usize, index: usize },
    Body(usize),
}

/// The findings so far.
#[derive(Default)]
struct Findings(Vec<(Part, Finding)>);

impl Findings {
    fn add(&mut self, part: Part, subject: impl Into<String>, code: &'static str, message: impl Into<String>) {
        let finding = Finding {
            code,
            severity: rules::severity_of(code),
            position: None,
            subject: subject.into(),
            message: message.into(),
        };
        self.0.push((part, finding));
    }

    fn locate(self, source: Option<(&[u8], &Places)>) -> Vec<Finding> {
        let Some((bytes, places)) = source else {
            return self.0.into_iter().map(|(_, finding)| finding).collect();
        };
        let offset = |part: &Part| match *part {
            Part::Document => None,
            Part::Material(index) => places.materials.get(index).copied(),
            Part::Object { frame, index } => places.objects.get(frame).and_then(|objects| objects.get(index)).copied(),
            Part::Body(index) => places.bodies.get(index).copied(),
        };
        let mut findings: Vec<(Option<usize>, Finding)> =
            self.0.into_iter().map(|(part, finding)| (offset(&part), finding)).collect();
        findings.sort_by_key(|(offset, _)| *offset);
        let mut walk = Position::walk(bytes);
        findings
            .into_iter()
            .map(|(offset, finding)| Finding { position: offset.map(|offset| walk.at(offset)), ..finding })
            .collect()
    }
}

/// How findings name an object.
fn object_subject(object: &Object) -> String {
    format!("object {} {:?}", object.id, object.name)
}

/// "1 triangle", "2 triangles".
fn counted(count: usize, one: &str) -> String {
    if count == 1 { format!("1 {one}") } else { format!("{count} {one}s") }
}
