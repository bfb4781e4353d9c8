//! Matrices, which a look hasn't: each is its rows, and what is computed with it becomes nodes that give a row.
//!
//! Vectors are rows and stand to the left of the matrix, as in MaterialX. Sums and choices go through textures of numbers, row by
//! row, as [`leaf`](super::leaf) has it.

use std::rc::Rc;

use scene::look;
use texgen::{OutputType, ParameterType};

use crate::document::ElementId;
use crate::types::Type;
use crate::value::Value;

use super::Converter;
use super::graph::Scope;

/// Rows and columns of the matrices of a type of MaterialX.
pub(super) fn size_of(ty: &str) -> Option<usize> {
    match ty {
        "matrix33" => Some(3),
        "matrix44" => Some(4),
        _ => None,
    }
}

/// What a row is.
pub(super) fn row_type(size: usize) -> Type {
    match size {
        3 => Type::Vector3,
        _ => Type::Vector4,
    }
}

/// A matrix as it is written: its numbers row by row.
pub(super) fn written(size: usize, text: &str) -> Option<Value> {
    let parts = text.split([',', ' ', '\t', '\n', '\r']);
    let numbers: Result<Vec<f32>, _> = (parts.filter(|part| !part.is_empty()))
        .map(str::parse)
        .collect();
    let numbers = numbers.ok()?;
    let is_whole = numbers.len() == size * size && numbers.iter().all(|x| x.is_finite());
    is_whole.then(|| matrix(size, |row, column| numbers[row * size + column]))
}

fn matrix(size: usize, number: impl Fn(usize, usize) -> f32) -> Value {
    let row = |row: usize| {
        let number = |column: usize| {
            if column < size {
                number(row, column)
            } else {
                0.0
            }
        };
        Value::Numbers(row_type(size), std::array::from_fn(number))
    };
    Value::Matrix((0..size).map(row).collect())
}

fn identity(size: usize) -> Value {
    matrix(size, |row, column| f32::from(row == column))
}

impl Converter<'_> {
    /// What a node gives that takes or makes matrices; `None` for all other nodes.
    pub(super) fn matrix_node(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
    ) -> Option<Option<Value>> {
        let element = self.document.element(id);
        let own = size_of(element.attribute("type").unwrap_or(""));
        let name = self.look_name(scope, id);
        let value = match (&*element.kind, own) {
            ("creatematrix", Some(size)) => self.created(scope, id, size),
            ("constant", Some(size)) => match self.input(scope, id, "value") {
                Some(value @ Value::Matrix(_)) => value,
                _ => matrix(size, |_, _| 0.0),
            },
            ("transpose", Some(size)) => {
                let rows = self.rows(scope, id, "in", size)?;
                self.transposed(&name, &rows)
            }
            ("invertmatrix", Some(size)) => {
                let rows = self.rows(scope, id, "in", size)?;
                self.inverse(&name, &rows)
            }
            ("multiply" | "divide", Some(size)) => {
                let left = self.rows(scope, id, "in1", size)?;
                let mut right = self.rows(scope, id, "in2", size)?;
                if element.kind == "divide" {
                    let Value::Matrix(rows) = self.inverse(&name, &right) else {
                        return None;
                    };
                    right = rows;
                }
                let row = |row: &Value| self.transformed(&name, row, &right);
                Value::Matrix(left.iter().map(row).collect())
            }
            ("transformmatrix", None) => self.transform(scope, id)?,
            ("determinant", None) => {
                let size = self.size_of_input(id, "in")?;
                let rows = self.rows(scope, id, "in", size)?;
                self.of_rows(&name, "mx_determinant", &rows, Vec::new(), Type::Float)
            }
            ("extract", _) => {
                let size = self.size_of_input(id, "in")?;
                let rows = self.rows(scope, id, "in", size)?;
                let index = self.input(scope, id, "index");
                let index = index.and_then(|index| index.known()).unwrap_or_default();
                rows[(index[0].max(0.0) as usize).min(size - 1)].clone()
            }
            _ => return None,
        };
        Some(Some(value))
    }

    /// The size of the matrix that an input is declared to be.
    fn size_of_input(&self, id: ElementId, name: &str) -> Option<usize> {
        let input = self.document.input(id, name)?;
        size_of(self.document.element(input).attribute("type")?)
    }

    /// The rows of an input; those of the identity where it has nothing.
    fn rows(
        &mut self,
        scope: &Rc<Scope>,
        id: ElementId,
        name: &str,
        size: usize,
    ) -> Option<Vec<Value>> {
        match self.input(scope, id, name).unwrap_or(identity(size)) {
            Value::Matrix(rows) if rows.len() == size => Some(rows),
            _ => None,
        }
    }

    fn created(&mut self, scope: &Rc<Scope>, id: ElementId, size: usize) -> Value {
        let Value::Matrix(mut rows) = identity(size) else {
            return identity(size);
        };
        let name = self.look_name(scope, id);
        for (i, row) in rows.iter_mut().enumerate() {
            let Some(given) = self.input(scope, id, &format!("in{}", i + 1)) else {
                continue;
            };
            let count = given.ty().components();
            let mut parts: Vec<Value> = (0..count).map(|i| given.component(i)).collect();
            if size == 4 && count == 3 {
                parts.push(Value::number(f32::from(i == 3)));
            }
            *row = self.joined(&name, row_type(size), &parts);
        }
        Value::Matrix(rows)
    }

    fn transposed(&mut self, name: &str, rows: &[Value]) -> Value {
        let column = |column: usize| {
            let parts: Vec<Value> = rows.iter().map(|row| row.component(column)).collect();
            self.joined(name, row_type(rows.len()), &parts)
        };
        Value::Matrix((0..rows.len()).map(column).collect())
    }

    fn inverse(&mut self, name: &str, rows: &[Value]) -> Value {
        let size = rows.len();
        let row = |row: usize| {
            let which = vec![("row".to_owned(), look::Value::Integer(row as i64))];
            self.of_rows(name, "mx_invertmatrix", rows, which, row_type(size))
        };
        Value::Matrix((0..size).map(row).collect())
    }

    /// A vector by a matrix. One that is shorter than a row is a point: what is missing is 1.
    fn transform(&mut self, scope: &Rc<Scope>, id: ElementId) -> Option<Value> {
        let vector = self.given(scope, id, "in");
        let Some(size) = self.size_of_input(id, "mat") else {
            return Some(vector);
        };
        let rows = self.rows(scope, id, "mat", size)?;
        let name = self.look_name(scope, id);
        let (ty, count) = (vector.ty(), vector.ty().components());
        let mut parts: Vec<Value> = (0..count).map(|i| vector.component(i)).collect();
        parts.resize(size, Value::number(1.0));
        let row = self.joined(&name, row_type(size), &parts);
        let moved = self.transformed(&name, &row, &rows);
        Some(moved.pick(ty, &(0..count).collect::<Vec<_>>()))
    }

    /// A row by a matrix.
    fn transformed(&mut self, name: &str, row: &Value, rows: &[Value]) -> Value {
        let given = vec![("in".to_owned(), row_argument(rows.len(), row))];
        let ty = row_type(rows.len());
        self.of_rows(name, "mx_transformmatrix", rows, given, ty)
    }

    /// What a texture gives that takes the rows of a matrix.
    fn of_rows(
        &mut self,
        name: &str,
        texture: &str,
        rows: &[Value],
        mut arguments: Vec<(String, look::Value)>,
        ty: Type,
    ) -> Value {
        let size = rows.len();
        let named = rows.iter().enumerate();
        arguments.extend(named.map(|(i, row)| (format!("row{}", i + 1), row_argument(size, row))));
        let output = match ty {
            Type::Float => OutputType::F32,
            Type::Vector3 => OutputType::Vec3,
            _ => OutputType::Vec4,
        };
        let texture = format!("{texture}_{size}");
        Value::Link(self.add(name, &texture, arguments, ty, output))
    }
}

/// A row as an argument of a texture.
fn row_argument(size: usize, row: &Value) -> look::Value {
    let ty = match size {
        3 => ParameterType::Vec3,
        _ => ParameterType::Vec4,
    };
    match row {
        Value::Link(link) => look::Value::Text(link.text(ty, false)),
        Value::Numbers(_, numbers) => look::Value::numbers(&numbers[..size]),
        Value::Text(_) | Value::File { .. } | Value::Matrix(_) => look::Value::number(0.0),
    }
}
