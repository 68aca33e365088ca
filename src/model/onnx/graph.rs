//! A graph that grows node by node.

use super::proto::{
    AttributeProto, DOUBLE, DimensionProto, FLOAT, GraphProto, INT, INT64, INTS, NodeProto,
    TensorProto, TensorShapeProto, TensorTypeProto, TypeProto, ValueInfoProto,
};
use std::collections::BTreeMap;

/// A graph under construction; values in it go by their names.
#[derive(Default)]
pub struct Graph {
    graph: GraphProto,
    /// How many nodes of each operator there are, for their names.
    numbers: BTreeMap<String, usize>,
    /// Names of constants by their content, so that each is there once.
    constants: BTreeMap<Vec<u8>, String>,
    /// What names of nodes and constants begin with.
    prefix: String,
}

/// The length of an axis.
pub enum Length {
    /// Known now.
    Fixed(usize),
    /// Known when the graph is run, by the name that it has in all shapes.
    Named(&'static str),
}

impl Graph {
    /// An empty graph.
    pub fn new(name: &str, doc: String) -> Self {
        Self {
            graph: GraphProto {
                name: name.into(),
                doc_string: doc,
                ..GraphProto::default()
            },
            ..Self::default()
        }
    }

    /// From here on names of nodes and constants begin so.
    pub fn begin(&mut self, prefix: &str) {
        self.prefix = prefix.into();
    }

    /// What goes in.
    pub fn input(&mut self, name: &str, shape: &[Length], doc: String) {
        self.graph.input.push(value_info(name, FLOAT, shape, doc));
    }

    /// What comes out: a value under the name that it has inside.
    pub fn output(&mut self, name: &str, is_double: bool, shape: &[Length], doc: String) {
        let number = if is_double { DOUBLE } else { FLOAT };
        self.graph.output.push(value_info(name, number, shape, doc));
    }

    /// A node of one output, which it returns the name of.
    pub fn node(&mut self, op: &str, inputs: &[&str], attributes: &[(&str, i64)]) -> String {
        let attributes = attributes.iter().map(|&(name, i)| AttributeProto {
            name: name.into(),
            i: Some(i),
            ints: Vec::new(),
            r#type: INT,
        });
        let attributes = attributes.collect();
        let name = self.next(op);
        self.push(op, inputs, vec![name.clone()], attributes);
        name
    }

    /// The same, with a list of numbers for an attribute.
    pub fn node_of_list(&mut self, op: &str, inputs: &[&str], list: (&str, &[i64])) -> String {
        let attribute = AttributeProto {
            name: list.0.into(),
            i: None,
            ints: list.1.to_vec(),
            r#type: INTS,
        };
        let name = self.next(op);
        self.push(op, inputs, vec![name.clone()], vec![attribute]);
        name
    }

    /// The `k` values along the last axis, ascending: all of them, where there are as many.
    pub fn sorted(&mut self, input: &str, k: usize) -> String {
        let count = self.int64(&[k as i64], &[1]);
        let name = self.next("TopK");
        let places = format!("{name}.places");
        let attribute = |name: &str, i: i64| AttributeProto {
            name: name.into(),
            i: Some(i),
            ints: Vec::new(),
            r#type: INT,
        };
        let attributes = vec![
            attribute("axis", -1),
            attribute("largest", 0),
            attribute("sorted", 1),
        ];
        self.push(
            "TopK",
            &[input, &count],
            vec![name.clone(), places],
            attributes,
        );
        name
    }

    /// A value under another name, for what comes out.
    pub fn named(&mut self, input: &str, name: &str) {
        self.push("Identity", &[input], vec![name.into()], Vec::new());
    }

    /// An array that stands in the file under its own name.
    pub fn array(&mut self, name: &str, values: impl IntoIterator<Item = f32>, shape: &[usize]) {
        let bytes = values.into_iter().flat_map(f32::to_le_bytes).collect();
        self.initialise(name.into(), FLOAT, shape, bytes);
    }

    /// The same in double precision.
    pub fn array_f64(
        &mut self,
        name: &str,
        values: impl IntoIterator<Item = f64>,
        shape: &[usize],
    ) {
        let bytes = values.into_iter().flat_map(f64::to_le_bytes).collect();
        self.initialise(name.into(), DOUBLE, shape, bytes);
    }

    /// A number without axes.
    pub fn scalar(&mut self, value: f32) -> String {
        self.constant(FLOAT, &[], value.to_le_bytes().to_vec())
    }

    /// Some numbers.
    pub fn floats(&mut self, values: &[f32]) -> String {
        let bytes = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.constant(FLOAT, &[values.len()], bytes)
    }

    /// Some whole numbers.
    pub fn int64(&mut self, values: &[i64], shape: &[usize]) -> String {
        let bytes = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        self.constant(INT64, shape, bytes)
    }

    /// Elements of an axis by their numbers.
    pub fn gather(&mut self, input: &str, at: &[usize], axis: i64) -> String {
        let at: Vec<i64> = at.iter().map(|&at| at as i64).collect();
        let at = self.int64(&at, &[at.len()]);
        self.node("Gather", &[input, &at], &[("axis", axis)])
    }

    /// The same numbers in another shape; −1: as long as needed.
    pub fn reshape(&mut self, input: &str, shape: &[i64]) -> String {
        let shape = self.int64(shape, &[shape.len()]);
        self.node("Reshape", &[input, &shape], &[])
    }

    /// The whole.
    pub fn finish(self) -> GraphProto {
        self.graph
    }

    fn constant(&mut self, number: i32, shape: &[usize], bytes: Vec<u8>) -> String {
        let mut key = vec![number as u8, shape.len() as u8];
        key.extend(shape.iter().flat_map(|length| length.to_le_bytes()));
        key.extend(&bytes);
        if let Some(name) = self.constants.get(&key) {
            return name.clone();
        }
        let name = self.next("constant");
        self.constants.insert(key, name.clone());
        self.initialise(name.clone(), number, shape, bytes);
        name
    }

    fn initialise(&mut self, name: String, number: i32, shape: &[usize], raw_data: Vec<u8>) {
        self.graph.initializer.push(TensorProto {
            dims: shape.iter().map(|&length| length as i64).collect(),
            data_type: number,
            name,
            raw_data,
            doc_string: String::new(),
        });
    }

    fn next(&mut self, op: &str) -> String {
        let kind = format!("{}{op}", self.prefix);
        let number = self.numbers.entry(kind.clone()).or_default();
        *number += 1;
        format!("{kind}.{number}")
    }

    fn push(
        &mut self,
        op: &str,
        inputs: &[&str],
        output: Vec<String>,
        attribute: Vec<AttributeProto>,
    ) {
        self.graph.node.push(NodeProto {
            input: inputs.iter().map(|name| name.to_string()).collect(),
            name: output.first().cloned().unwrap_or_default(),
            output,
            op_type: op.into(),
            attribute,
            doc_string: String::new(),
        });
    }
}

fn value_info(name: &str, number: i32, shape: &[Length], doc: String) -> ValueInfoProto {
    let dim = shape.iter().map(|length| match length {
        Length::Fixed(length) => DimensionProto {
            dim_value: Some(*length as i64),
            dim_param: None,
        },
        Length::Named(name) => DimensionProto {
            dim_value: None,
            dim_param: Some(name.to_string()),
        },
    });
    ValueInfoProto {
        name: name.into(),
        r#type: Some(TypeProto {
            tensor_type: Some(TensorTypeProto {
                elem_type: number,
                shape: Some(TensorShapeProto { dim: dim.collect() }),
            }),
        }),
        doc_string: doc,
    }
}
