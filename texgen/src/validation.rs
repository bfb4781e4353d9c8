//! What naga's validator says, with the types and the operands that it means: its own messages show numbers of its tables.

mod places;

use std::collections::HashSet;
use std::error::Error;
use std::ops::Range;

use naga::common::DiagnosticDisplay;
use naga::front::Typifier;
use naga::proc::{ResolveContext, TypeResolution};
use naga::valid::{
    CallError, ComposeError, ExpressionError, FunctionError, LiteralError, ValidationError,
    WidthError,
};
use naga::{
    BinaryOperator, Expression, Function, Handle, Module, ScalarKind, Span, Statement, SwitchCase,
    SwitchValue, TypeInner, UnaryOperator, WithSpan,
};

use places::{Side, argument, find, from_last_break, head, mention};

use crate::problem::{Conversion, FRACTION, Problem};

/// No more expressions than this are looked through for the one that a number belongs to.
const MOST_BETWEEN: usize = 256;

/// The error in terms of the text.
pub(crate) fn problem(error: &WithSpan<ValidationError>, module: &Module, text: &str) -> Problem {
    let mut chain = vec![error.as_inner().to_string()];
    let mut source = error.as_inner().source();
    while let Some(inner) = source {
        chain.push(inner.to_string());
        source = inner.source();
    }
    let message = chain.pop().unwrap_or_default();
    let mut labels: Vec<(Range<usize>, String)> = error
        .spans()
        .filter_map(|(span, label)| Some((span.to_range()?, label.clone())))
        .collect();
    // The narrowest place is the one to look at, but not where something is only declared.
    let declared = declarations(error.as_inner(), module);
    labels.sort_by_key(|(span, _)| (declared.contains(span), span.len()));
    let mut problem = Problem {
        message,
        labels,
        notes: Vec::new(),
        function: None,
        conversion: None,
    };
    if let ValidationError::Function {
        handle,
        name,
        source,
    } = error.as_inner()
    {
        problem.function = Some(name.clone());
        let function = &module.functions[*handle];
        let places = Places {
            module,
            function,
            text,
        };
        places.explain(source, &mut problem);
    }
    problem
}

/// The places of declarations that an error in a function may show: of types, and of the function's parameters.
fn declarations(error: &ValidationError, module: &Module) -> HashSet<Range<usize>> {
    let ValidationError::Function { handle, .. } = error else {
        return HashSet::new();
    };
    let expressions = &module.functions[*handle].expressions;
    let parameters = expressions
        .iter()
        .filter(|(_, expression)| matches!(expression, Expression::FunctionArgument(_)))
        .map(|(parameter, _)| expressions.get_span(parameter));
    let types = module.types.iter();
    let types = types.map(|(ty, _)| module.types.get_span(ty));
    types.chain(parameters).filter_map(Span::to_range).collect()
}

/// The function that an error lies in.
struct Places<'a> {
    module: &'a Module,
    function: &'a Function,
    text: &'a str,
}

impl Places<'_> {
    fn explain(&self, error: &FunctionError, problem: &mut Problem) {
        match error {
            FunctionError::Expression { handle, source } => {
                self.expression(*handle, source, problem);
            }
            FunctionError::InvalidReturnType {
                expression: Some(value),
                expected_ty,
            } => {
                match expected_ty {
                    Some(declared) => {
                        problem.message = self.wrong_return(*value, &self.name_of(*declared));
                    }
                    None => {
                        problem.message =
                            "a value is returned, but the function declares none".into();
                        let note = "write `-> TYPE` behind its parameters";
                        problem.notes.push(note.into());
                    }
                }
                let statement = self.statement(
                    |one| matches!(one, Statement::Return { value: Some(given) } if given == value),
                );
                self.look_at_use(*value, statement, problem);
            }
            FunctionError::InvalidStoreTypes { pointer, value } => {
                let statement = self.statement(|one| {
                    matches!(one, Statement::Store { pointer: to, value: given } if to == pointer && given == value)
                });
                if let (Some(to), Some(from)) = (self.pointee(*pointer), self.type_of(*value)) {
                    problem.message = format!("a `{from}` can't be assigned to a `{to}`");
                    self.offer_conversion(*value, &from, &to, statement.as_ref(), problem);
                }
                self.look_at_use(*value, statement, problem);
            }
            FunctionError::InvalidCall {
                function,
                error:
                    CallError::ArgumentType {
                        index,
                        required,
                        seen_expression,
                    },
            } => {
                let required = self.name_of(*required);
                let callee = &self.module.functions[*function];
                let name = callee.name.as_deref().unwrap_or("the function");
                let number = index + 1;
                let call = self.statement(|one| {
                    matches!(one, Statement::Call { function: called, arguments, .. } if called == function && arguments.get(*index) == Some(seen_expression))
                });
                let place = call
                    .as_ref()
                    .and_then(|call| argument(self.text, call, *index, callee.arguments.len()));
                let place = place.or(call);
                if let Some(ty) = self.type_of(*seen_expression) {
                    problem.message =
                        format!("argument {number} of `{name}` is to be `{required}`, not `{ty}`");
                    let value = *seen_expression;
                    self.offer_conversion(value, &ty, &required, place.as_ref(), problem);
                } else {
                    problem.message =
                        format!("argument {number} of `{name}` is to be `{required}`");
                }
                self.look_at_use(*seen_expression, place, problem);
            }
            FunctionError::InvalidIfType(condition) => {
                if let Some(ty) = self.type_of(*condition) {
                    problem.message = format!("the `if` condition is `{ty}`, not `bool`");
                }
                let of_if = self.statement(
                    |one| matches!(one, Statement::If { condition: given, .. } if given == condition),
                );
                let of_loop = || {
                    let found = self.statement(|one| {
                        matches!(one, Statement::Loop { break_if: Some(given), .. } if given == condition)
                    });
                    found.map(|span| from_last_break(self.text, span))
                };
                self.look_at_use(*condition, of_if.or_else(of_loop), problem);
            }
            FunctionError::InvalidSwitchType(value) => {
                if let Some(ty) = self.type_of(*value) {
                    problem.message =
                        format!("the value of `switch` is `{ty}`, not `i32` or `u32`");
                }
                let statement = self.statement(
                    |one| matches!(one, Statement::Switch { selector, .. } if selector == value),
                );
                self.look_at_use(*value, statement, problem);
            }
            FunctionError::ConflictingSwitchCase(value) => {
                let number = match value {
                    SwitchValue::I32(number) => number.to_string(),
                    SwitchValue::U32(number) => number.to_string(),
                    SwitchValue::Default => "default".to_owned(),
                };
                problem.message = format!("this `switch` has more than one `case` for `{number}`");
                // naga shows the second one, if anything is in it.
                if !problem.is_of_cases() {
                    let is_theirs = |case: &&SwitchCase| case.value == *value;
                    let statement = self.statement(|one| {
                        matches!(one, Statement::Switch { cases, .. } if cases.iter().filter(is_theirs).count() > 1)
                    });
                    let place = statement.map(|statement| head(self.text, &statement));
                    self.look_at(place, problem);
                }
            }
            FunctionError::InvalidArgumentType { index, .. }
            | FunctionError::InvalidArgumentPointerSpace { index, .. } => {
                let mut expressions = self.function.expressions.iter();
                let parameter = expressions.find(|(_, expression)| {
                    matches!(expression, Expression::FunctionArgument(one) if *one as usize == *index)
                });
                let place = parameter.and_then(|(handle, _)| self.own_span(handle));
                self.look_at(place, problem);
            }
            _ => {}
        }
    }

    fn wrong_return(&self, value: Handle<Expression>, declared: &str) -> String {
        match self.type_of(value) {
            Some(ty) => {
                format!("the returned value is `{ty}`, but the function declares `{declared}`")
            }
            None => format!("the returned value is not `{declared}`, as the function declares"),
        }
    }

    fn expression(
        &self,
        whole: Handle<Expression>,
        error: &ExpressionError,
        problem: &mut Problem,
    ) {
        let within = self.own_span(whole);
        match error {
            ExpressionError::InvalidBinaryOperandTypes {
                op,
                lhs_expr,
                rhs_expr,
                ..
            } => {
                let (Some(left), Some(right)) = (self.type_of(*lhs_expr), self.type_of(*rhs_expr))
                else {
                    return;
                };
                problem.message = format!(
                    "`{}` can't take `{left}` and `{right}`",
                    binary_operator(*op)
                );
                self.look_at(within.clone(), problem);
                let within = within.as_ref();
                for (operand, ty, side) in [
                    (*lhs_expr, &left, Side::First),
                    (*rhs_expr, &right, Side::Last),
                ] {
                    if let Some(span) = within.and_then(|within| self.place(operand, within, side))
                    {
                        problem.labels.push((span, ty.clone()));
                    }
                }
                let of_int = |handle| {
                    let inner = self.inner(handle);
                    inner.is_some_and(|inner| inner.scalar_kind() != Some(ScalarKind::Float))
                };
                match (of_int(*lhs_expr), of_int(*rhs_expr)) {
                    (true, false) => {
                        self.offer_conversion(*lhs_expr, &left, &right, within, problem);
                    }
                    _ => self.offer_conversion(*rhs_expr, &right, &left, within, problem),
                }
            }
            ExpressionError::InvalidUnaryOperandType(op, operand) => {
                if let Some(ty) = self.type_of(*operand) {
                    problem.message = format!("`{}` can't take `{ty}`", unary_operator(*op));
                }
                self.look_at(within, problem);
            }
            ExpressionError::IndexOutOfBounds(base, index) => {
                if let Some(ty) = self.type_of(*base) {
                    problem.message = format!("index {index} is beyond the end of `{ty}`");
                }
            }
            ExpressionError::InvalidIndexType(index) => {
                if let Some(ty) = self.type_of(*index) {
                    problem.message = format!("an index is `i32` or `u32`, not `{ty}`");
                }
                // It stands behind what it is an index of.
                let place = within.and_then(|within| self.place(*index, &within, Side::Last));
                self.look_at(place, problem);
            }
            ExpressionError::NegativeIndex(_) => {
                problem.message = "an index can't be negative".into();
            }
            ExpressionError::InvalidBaseType(base) => {
                if let Some(ty) = self.type_of(*base) {
                    problem.message = format!("`{ty}` has no elements or members");
                }
            }
            ExpressionError::Compose(ComposeError::ComponentType { index }) => {
                self.component(whole, *index as usize, problem);
            }
            ExpressionError::Literal(LiteralError::Width(WidthError::Abstract)) => {
                self.mixture(whole, problem);
            }
            ExpressionError::MissingCapabilities(_) => {
                problem.message = "this is not available in textures: not every GPU has it".into();
            }
            _ => {}
        }
    }

    /// A part that is given something of another type where a struct, an array, a matrix or a vector is made.
    fn component(&self, whole: Handle<Expression>, index: usize, problem: &mut Problem) {
        let Expression::Compose { ty, components } = &self.function.expressions[whole] else {
            return;
        };
        let Some(&given) = components.get(index) else {
            return;
        };
        let within = self.own_span(whole);
        if let Some(found) = self.type_of(given)
            && let Some((part, wanted)) = self.wanted(*ty, index, given)
        {
            problem.message = format!("{part} is to be `{wanted}`, not `{found}`");
            if shape(&found) == shape(&wanted) {
                self.offer_conversion(given, &found, &wanted, within.as_ref(), problem);
            }
        }
        let place = within
            .as_ref()
            .and_then(|within| argument(self.text, within, index, components.len()));
        self.look_at(place.or(within), problem);
    }

    /// What a part of a value is called, and the type that it is to have.
    fn wanted(
        &self,
        whole: Handle<naga::Type>,
        index: usize,
        given: Handle<Expression>,
    ) -> Option<(String, String)> {
        let number = index + 1;
        let name = self.name_of(whole);
        Some(match &self.module.types[whole].inner {
            TypeInner::Struct { members, .. } => {
                let member = members.get(index)?;
                let called = member.name.as_deref().unwrap_or_default();
                (format!("member `{called}`"), self.name_of(member.ty))
            }
            TypeInner::Array { base, .. } => {
                (format!("element {number} of `{name}`"), self.name_of(*base))
            }
            &TypeInner::Matrix { rows, scalar, .. } => (
                format!("column {number} of `{name}`"),
                self.name_of_inner(TypeInner::Vector { size: rows, scalar }),
            ),
            &TypeInner::Vector { scalar, .. } => {
                // It is made of numbers, and of smaller vectors.
                let wanted = match self.inner(given)? {
                    TypeInner::Vector { size, .. } => TypeInner::Vector { size, scalar },
                    _ => TypeInner::Scalar(scalar),
                };
                (
                    format!("argument {number} of `{name}`"),
                    self.name_of_inner(wanted),
                )
            }
            _ => return None,
        })
    }

    /// A number without a type of its own that stands beside something which it doesn't become like.
    fn mixture(&self, number: Handle<Expression>, problem: &mut Problem) {
        let Some((whole, op, [left, right])) = self.mixed_operands(number) else {
            return;
        };
        let (number, other, side) = match self.is_abstract(left) {
            true => (left, right, Side::Last),
            false => (right, left, Side::First),
        };
        let Some(ty) = self.type_of(other) else {
            return;
        };
        let is_whole = self.scalar_kind(number) == Some(ScalarKind::AbstractInt);
        let said = if is_whole { "a whole number" } else { FRACTION };
        let operator = binary_operator(op);
        problem.message = match side {
            Side::First => format!("`{operator}` can't take `{ty}` and {said}"),
            Side::Last => format!("`{operator}` can't take {said} and `{ty}`"),
        };
        let within = self.own_span(whole);
        self.look_at(within.clone(), problem);
        let within = within.as_ref();
        if let Some(span) = within.and_then(|within| self.place(other, within, side)) {
            problem.labels.push((span, ty.clone()));
        }
        if !is_whole {
            self.offer_conversion(other, &ty, "f32", within, problem);
        }
    }

    /// The innermost operator around a number without a type of its own that has such a number on one side only.
    fn mixed_operands(
        &self,
        number: Handle<Expression>,
    ) -> Option<(Handle<Expression>, BinaryOperator, [Handle<Expression>; 2])> {
        let (mut part, mut innermost) = (number, None);
        let expressions = self.function.expressions.iter();
        let behind = expressions.skip_while(|(handle, _)| *handle != number);
        for (handle, expression) in behind.take(MOST_BETWEEN) {
            match expression {
                Expression::Splat { value, .. } if *value == part => part = handle,
                Expression::Unary { expr, .. } if *expr == part => part = handle,
                Expression::Compose { components, .. } if components.contains(&part) => {
                    part = handle;
                }
                &Expression::Binary { op, left, right } => {
                    if innermost.is_none() && self.is_abstract(left) != self.is_abstract(right) {
                        innermost = Some((handle, op, [left, right]));
                    }
                    if left == part || right == part {
                        return innermost;
                    }
                }
                _ => {}
            }
        }
        None
    }

    /// Whether something is made of numbers without a type of their own.
    fn is_abstract(&self, expression: Handle<Expression>) -> bool {
        let kind = self.scalar_kind(expression);
        matches!(
            kind,
            Some(ScalarKind::AbstractFloat | ScalarKind::AbstractInt)
        )
    }

    fn scalar_kind(&self, expression: Handle<Expression>) -> Option<ScalarKind> {
        self.inner(expression)?.scalar_kind()
    }

    /// The first label is there, where the place is known.
    fn look_at(&self, place: Option<Range<usize>>, problem: &mut Problem) {
        if let Some(span) = place {
            problem
                .labels
                .retain(|(_, text)| !text.starts_with("naga::"));
            problem.labels.insert(0, (span, String::new()));
        }
    }

    /// The first label is where a statement, or a part of one, uses a value, the second one where that is declared if it is
    /// declared elsewhere.
    fn look_at_use(
        &self,
        value: Handle<Expression>,
        statement: Option<Range<usize>>,
        problem: &mut Problem,
    ) {
        let Some(statement) = statement else {
            let is_declared = !self.names(value).is_empty();
            let own = self.own_span(value).filter(|_| !is_declared);
            return self.look_at(own, problem);
        };
        let place = self.place(value, &statement, Side::First);
        let declared = self
            .declared(value)
            .filter(|span| !is_within(span, &statement));
        self.look_at(place.or(Some(head(self.text, &statement))), problem);
        if let Some(span) = declared {
            problem.labels.insert(1, (span, "declared here".into()));
        }
    }

    /// Where a value is used in a stretch of the text. Of what is declared elsewhere naga knows that place only.
    fn place(
        &self,
        value: Handle<Expression>,
        within: &Range<usize>,
        side: Side,
    ) -> Option<Range<usize>> {
        let own = self.own_span(value).filter(|span| is_within(span, within));
        own.or_else(|| {
            let mut names = self.names(value).into_iter();
            names.find_map(|name| mention(self.text, &head(self.text, within), name, side))
        })
    }

    /// What a value may be called: the parameter, variable or constant that it is, and what a `let` calls it.
    fn names(&self, value: Handle<Expression>) -> Vec<&str> {
        let name = match &self.function.expressions[value] {
            Expression::FunctionArgument(index) => {
                let argument = self.function.arguments.get(*index as usize);
                argument.and_then(|argument| argument.name.as_deref())
            }
            Expression::Constant(constant) => self.module.constants[*constant].name.as_deref(),
            Expression::Load { pointer } => match self.function.expressions[*pointer] {
                Expression::LocalVariable(variable) => {
                    self.function.local_variables[variable].name.as_deref()
                }
                _ => None,
            },
            _ => None,
        };
        // What is assigned to nothing has that name.
        let given = self.function.named_expressions.get(&value);
        let given = given.map(String::as_str).filter(|name| *name != "phony");
        let mut names: Vec<&str> = name.into_iter().chain(given).collect();
        // A number becomes a vector by itself.
        if let Expression::Splat { value, .. } = &self.function.expressions[value] {
            names.extend(self.names(*value));
        }
        names
    }

    /// Where what a value is called is declared.
    fn declared(&self, value: Handle<Expression>) -> Option<Range<usize>> {
        if let Expression::Load { pointer } = self.function.expressions[value]
            && let Expression::LocalVariable(variable) = self.function.expressions[pointer]
        {
            let span = self.function.local_variables.get_span(variable);
            return span.to_range();
        }
        self.own_span(value)
    }

    /// The first statement that is meant.
    fn statement(&self, is_meant: impl Fn(&Statement) -> bool) -> Option<Range<usize>> {
        find(&self.function.body, &is_meant).and_then(Span::to_range)
    }

    /// If an operand becomes `to` by writing so, that is the remedy; `within` is what has the operand.
    fn offer_conversion(
        &self,
        operand: Handle<Expression>,
        from: &str,
        to: &str,
        within: Option<&Range<usize>>,
        problem: &mut Problem,
    ) {
        let Some(inner) = self.inner(operand) else {
            return;
        };
        let (size, target) = match inner {
            TypeInner::Scalar(_) => (None, to),
            TypeInner::Vector { size, .. } => (Some(size), to),
            _ => return,
        };
        // Of vectors and numbers only what they are made of differs: `vec3<i32>` and `f32`.
        let scalar = target
            .strip_suffix('>')
            .and_then(|text| text.rsplit_once('<'))
            .map_or(target, |(_, scalar)| scalar);
        if !matches!(scalar, "f32" | "i32" | "u32") || from.contains(scalar) {
            return;
        }
        let to = match size {
            None => scalar.to_owned(),
            Some(size) => format!("vec{}{}", size as u8, &scalar[..1]),
        };
        problem.conversion = Some(Box::new(Conversion {
            operand: within.and_then(|within| self.place(operand, within, Side::Last)),
            name: self.names(operand).first().map(|&name| name.to_owned()),
            to,
        }));
    }

    /// Where an expression stands; of a parameter, where that is declared.
    fn own_span(&self, expression: Handle<Expression>) -> Option<Range<usize>> {
        self.function.expressions.get_span(expression).to_range()
    }

    fn resolution(&self, expression: Handle<Expression>) -> Option<TypeResolution> {
        let context = ResolveContext::with_locals(
            self.module,
            &self.function.local_variables,
            &self.function.arguments,
        );
        let mut typifier = Typifier::new();
        typifier
            .grow(expression, &self.function.expressions, &context)
            .ok()?;
        Some(typifier[expression].clone())
    }

    fn inner(&self, expression: Handle<Expression>) -> Option<TypeInner> {
        let resolution = self.resolution(expression)?;
        Some(resolution.inner_with(&self.module.types).clone())
    }

    /// As WGSL writes it.
    fn type_of(&self, expression: Handle<Expression>) -> Option<String> {
        let resolution = self.resolution(expression)?;
        Some(DiagnosticDisplay((&resolution, self.module.to_ctx())).to_string())
    }

    fn name_of(&self, ty: Handle<naga::Type>) -> String {
        DiagnosticDisplay((ty, self.module.to_ctx())).to_string()
    }

    fn name_of_inner(&self, inner: TypeInner) -> String {
        let resolution = TypeResolution::Value(inner);
        DiagnosticDisplay((&resolution, self.module.to_ctx())).to_string()
    }

    /// The type of what a pointer points to.
    fn pointee(&self, pointer: Handle<Expression>) -> Option<String> {
        Some(match self.inner(pointer)? {
            TypeInner::Pointer { base, .. } => self.name_of(base),
            TypeInner::ValuePointer {
                size: None, scalar, ..
            } => self.name_of_inner(TypeInner::Scalar(scalar)),
            TypeInner::ValuePointer {
                size: Some(size),
                scalar,
                ..
            } => self.name_of_inner(TypeInner::Vector { size, scalar }),
            _ => return None,
        })
    }
}

/// What is in front of the type that a vector is made of, as WGSL writes it; nothing of a number.
fn shape(ty: &str) -> &str {
    ty.split_once('<').map_or("", |(shape, _)| shape)
}

fn is_within(inner: &Range<usize>, outer: &Range<usize>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

fn binary_operator(op: BinaryOperator) -> &'static str {
    match op {
        BinaryOperator::Add => "+",
        BinaryOperator::Subtract => "-",
        BinaryOperator::Multiply => "*",
        BinaryOperator::Divide => "/",
        BinaryOperator::Modulo => "%",
        BinaryOperator::Equal => "==",
        BinaryOperator::NotEqual => "!=",
        BinaryOperator::Less => "<",
        BinaryOperator::LessEqual => "<=",
        BinaryOperator::Greater => ">",
        BinaryOperator::GreaterEqual => ">=",
        BinaryOperator::And => "&",
        BinaryOperator::ExclusiveOr => "^",
        BinaryOperator::InclusiveOr => "|",
        BinaryOperator::LogicalAnd => "&&",
        BinaryOperator::LogicalOr => "||",
        BinaryOperator::ShiftLeft => "<<",
        BinaryOperator::ShiftRight => ">>",
    }
}

fn unary_operator(op: UnaryOperator) -> &'static str {
    match op {
        UnaryOperator::Negate => "-",
        UnaryOperator::LogicalNot => "!",
        UnaryOperator::BitwiseNot => "~",
    }
}
