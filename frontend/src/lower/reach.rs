//! What a program uses, from the functions that other sources know.

use crate::typed::*;
use std::collections::BTreeSet;

/// What is used.
#[derive(Default)]
pub(super) struct Reached {
    pub(super) objects: BTreeSet<ObjectId>,
    pub(super) functions: BTreeSet<FunctionId>,
}

/// Everything that is reached from functions with external linkage, and objects with a name of
/// their own.
pub(super) fn of(checked: &Checked) -> Reached {
    let mut reached = Reached::default();
    let mut work: Vec<Address> = Vec::new();
    for (id, function) in checked.functions.iter() {
        if !function.internal && function.body.is_some() {
            work.push(Address::Function(id));
        }
    }
    for (id, object) in checked.objects.iter() {
        // Literals start with a dot.
        if object.defined && !object.name.starts_with('.') {
            work.push(Address::Object(id));
        }
    }
    while let Some(next) = work.pop() {
        match next {
            Address::Object(object) => {
                if reached.objects.insert(object) {
                    let image = &checked.objects[object].image;
                    work.extend(image.addresses.iter().map(|(_, address, _)| *address));
                }
            }
            Address::Function(function) => {
                let Some(body) = &checked.functions[function].body else {
                    continue;
                };
                if reached.functions.insert(function) {
                    uses(body, &mut work);
                }
            }
        }
    }
    reached
}

/// What a function names.
fn uses(body: &Body, work: &mut Vec<Address>) {
    for expr in body.exprs.values() {
        match &expr.kind {
            ExprKind::Function(function) | ExprKind::Call(Callee::Function(function), _) => {
                work.push(Address::Function(*function));
            }
            _ => {}
        }
    }
    for place in body.places.values() {
        if let PlaceKind::Object(object) = place.kind {
            work.push(Address::Object(object));
        }
    }
}
