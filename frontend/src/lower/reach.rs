//! Finds the objects and functions that a program uses, from the functions that other sources know.

use crate::operator::{self, Class, Plan, Support};
use crate::typed::*;
use std::collections::BTreeSet;

/// The objects and functions that are used.
#[derive(Default)]
pub(super) struct Reached {
    pub(super) objects: BTreeSet<ObjectId>,
    pub(super) functions: BTreeSet<FunctionId>,
}

/// Everything that is reached from functions with external linkage, objects with a name of their own, and
/// the functions of the library that are `wanted`.
pub(super) fn of(checked: &Checked, wanted: &BTreeSet<String>) -> Reached {
    let mut reached = Reached::default();
    let mut work: Vec<Address> = Vec::new();
    for (id, function) in checked.functions.iter() {
        let is_wanted = !function.optional || wanted.contains(&*function.name);
        if !function.internal && is_wanted && function.body.is_some() {
            work.push(Address::Function(id));
        }
    }
    for (id, object) in checked.objects.iter() {
        // Literals start with a dot.
        if object.defined && !object.optional && !object.name.starts_with('.') {
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
                    uses(checked, body, &mut work);
                }
            }
        }
    }
    reached
}

/// Pushes the addresses that a function names, and the library functions that it needs.
fn uses(checked: &Checked, body: &Body, work: &mut Vec<Address>) {
    let mut need = |support: Option<Support>| {
        let function = support.and_then(|support| checked.support.get(&support));
        work.extend(function.map(|&function| Address::Function(function)));
    };
    let class = |ty| Class::of(checked.types.get(ty));
    let binary = |op, ty| match operator::binary(op, class(ty)) {
        Some(Plan::Support(support)) => Some(support),
        _ => None,
    };
    let conversion =
        |from, to| operator::conversion_support(checked.types.get(from), checked.types.get(to));
    for expr in body.exprs.values() {
        match &expr.kind {
            ExprKind::Binary(op, ..) => need(binary(*op, expr.ty)),
            ExprKind::Compare(relation, l, _) if class(body.exprs[*l].ty) == Class::Double => {
                need(Some(operator::double_relation(*relation).0));
            }
            ExprKind::Convert(a) => need(conversion(body.exprs[*a].ty, expr.ty)),
            ExprKind::Update(Update {
                step: Step::Arithmetic(op, compute),
                ..
            }) => {
                need(binary(*op, *compute));
                need(conversion(expr.ty, *compute));
                need(conversion(*compute, expr.ty));
            }
            _ => {}
        }
    }
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
