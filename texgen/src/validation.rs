//! What naga's validator says, with the types and the operands that it means: its own messages show numbers of its tables.

use std::error::Error;
use std::ops::Range;

use naga::common::DiagnosticDisplay;
use naga::front::Typifier;
use naga::proc::{ResolveContext, TypeResolution};
use naga::valid::{CallError, ExpressionError, FunctionError, ValidationError};
use naga::{
    BinaryOperator, Expression, Function, Handle, Module, ScalarKind, TypeInner, UnaryOperator,
    WithSpan,
};

use crate::problem::{Conversion, Problem};

/// The error in terms of the text.
pub(crate) fn problem(error: &WithSpan<ValidationError>, module: &Module) -> Problem {
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
    // The narrowest place is the one to look at.
    labels.sort_by_key(|(span, _)| span.len());
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
        let places = Places { module, function };
        places.explain(source, &mut problem);
    }
    problem
}

/// The function that an error lies in.
struct Places<'a> {
    module: &'a Module,
    function: &'a Function,
}

impl Places<'_> {
    fn explain(&self, error: &FunctionError, problem: &mut Problem) {
        match error {
            FunctionError::Expression { handle, source } => {
                self.expression(*handle, source, problem);
            }
            FunctionError::InvalidReturnType {
                expression: Some(value),
                expected_ty: Some(declared),
            } => {
                let declared = DiagnosticDisplay((*declared, self.module.to_ctx()));
                problem.message = match self.type_of(*value) {
                    Some(ty) => {
                        format!(
                            "the returned value is `{ty}`, but the function declares `{declared}`"
                        )
                    }
                    None => {
                        format!("the returned value is not `{declared}`, as the function declares")
                    }
                };
            }
            FunctionError::InvalidReturnType {
                expression: Some(_),
                expected_ty: None,
            } => {
                problem.message = "a value is returned, but the function declares none".into();
                problem
                    .notes
                    .push("write `-> TYPE` behind its parameters".into());
            }
            FunctionError::InvalidStoreTypes { pointer, value } => {
                if let (Some(to), Some(from)) = (self.pointee(*pointer), self.type_of(*value)) {
                    problem.message = format!("a `{from}` can't be assigned to a `{to}`");
                    self.offer_conversion(*value, &from, &to, problem);
                    self.look_at(*value, problem);
                }
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
                let required = DiagnosticDisplay((*required, self.module.to_ctx())).to_string();
                let name = self.module.functions[*function].name.as_deref();
                let name = name.unwrap_or("the function");
                let number = index + 1;
                if let Some(ty) = self.type_of(*seen_expression) {
                    problem.message =
                        format!("argument {number} of `{name}` is to be `{required}`, not `{ty}`");
                    self.offer_conversion(*seen_expression, &ty, &required, problem);
                } else {
                    problem.message =
                        format!("argument {number} of `{name}` is to be `{required}`");
                }
                self.look_at(*seen_expression, problem);
            }
            FunctionError::InvalidIfType(condition) => {
                if let Some(ty) = self.type_of(*condition) {
                    problem.message = format!("the `if` condition is `{ty}`, not `bool`");
                }
                self.look_at(*condition, problem);
            }
            FunctionError::InvalidSwitchType(value) => {
                if let Some(ty) = self.type_of(*value) {
                    problem.message =
                        format!("the value of `switch` is `{ty}`, not `i32` or `u32`");
                }
                self.look_at(*value, problem);
            }
            _ => {}
        }
    }

    fn expression(
        &self,
        whole: Handle<Expression>,
        error: &ExpressionError,
        problem: &mut Problem,
    ) {
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
                self.look_at(whole, problem);
                for (operand, ty) in [(*lhs_expr, &left), (*rhs_expr, &right)] {
                    if let Some(span) = self.span(operand) {
                        problem.labels.push((span, ty.clone()));
                    }
                }
                let of_int = |handle| {
                    let inner = self.inner(handle);
                    inner.is_some_and(|inner| inner.scalar_kind() != Some(ScalarKind::Float))
                };
                match (of_int(*lhs_expr), of_int(*rhs_expr)) {
                    (true, false) => self.offer_conversion(*lhs_expr, &left, &right, problem),
                    _ => self.offer_conversion(*rhs_expr, &right, &left, problem),
                }
            }
            ExpressionError::InvalidUnaryOperandType(op, operand) => {
                if let Some(ty) = self.type_of(*operand) {
                    problem.message = format!("`{}` can't take `{ty}`", unary_operator(*op));
                }
                self.look_at(whole, problem);
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
                self.look_at(*index, problem);
            }
            ExpressionError::NegativeIndex(_) => {
                problem.message = "an index can't be negative".into();
            }
            ExpressionError::InvalidBaseType(base) => {
                if let Some(ty) = self.type_of(*base) {
                    problem.message = format!("`{ty}` has no elements or members");
                }
            }
            ExpressionError::MissingCapabilities(_) => {
                problem.message = "this is not available in textures: not every GPU has it".into();
            }
            _ => {}
        }
    }

    /// The first label is at this expression, where it has a place.
    fn look_at(&self, expression: Handle<Expression>, problem: &mut Problem) {
        if let Some(span) = self.span(expression) {
            problem
                .labels
                .retain(|(_, text)| !text.starts_with("naga::"));
            problem.labels.insert(0, (span, String::new()));
        }
    }

    /// If `operand` becomes `to` by writing so, that is the remedy.
    fn offer_conversion(
        &self,
        operand: Handle<Expression>,
        from: &str,
        to: &str,
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
            operand: self.span(operand),
            name: match self.function.expressions[operand] {
                Expression::FunctionArgument(index) => {
                    self.function.arguments[index as usize].name.clone()
                }
                _ => None,
            },
            to,
        }));
    }

    /// Where it stands; of what is declared elsewhere naga knows that place only.
    fn span(&self, expression: Handle<Expression>) -> Option<Range<usize>> {
        let is_declared = matches!(
            self.function.expressions[expression],
            Expression::FunctionArgument(_)
                | Expression::LocalVariable(_)
                | Expression::GlobalVariable(_)
                | Expression::Constant(_)
        );
        if is_declared {
            return None;
        }
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

    /// The type of what a pointer points to.
    fn pointee(&self, pointer: Handle<Expression>) -> Option<String> {
        let inner = self.inner(pointer)?;
        let resolution = match inner {
            TypeInner::Pointer { base, .. } => TypeResolution::Handle(base),
            TypeInner::ValuePointer {
                size: None, scalar, ..
            } => TypeResolution::Value(TypeInner::Scalar(scalar)),
            TypeInner::ValuePointer {
                size: Some(size),
                scalar,
                ..
            } => TypeResolution::Value(TypeInner::Vector { size, scalar }),
            _ => return None,
        };
        Some(DiagnosticDisplay((&resolution, self.module.to_ctx())).to_string())
    }
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
