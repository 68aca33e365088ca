//! From normalised inputs to probabilities, as nodes of a graph.

use super::graph::Graph;
use crate::detector::net::{Activation, Weights};

/// Adds the nodes; `inputs` are `[batch, input]`. The result is P(f_i = 1 | s), `[batch, feature]`. `prefix` begins the names of the arrays.
pub fn probabilities(graph: &mut Graph, inputs: &str, weights: &Weights, prefix: &str) -> String {
    let mut value = convolved(graph, inputs, weights, prefix);
    let dense = weights.convolutions.len()..weights.trunk;
    for number in dense {
        let [weight, bias] = arrays(graph, weights, number, prefix, "trunk");
        value = sum(graph, &value, &weight, &bias);
        value = activated(graph, &value, weights.activation);
    }
    let own = weights.trunk..weights.layers.len();
    let first = own.start;
    // The first layers of all networks at once: [batch, input] × [input, filter · unit].
    let (n, inputs, units) = weights.layers[first].weight.dim();
    let stacked = weights.layers[first].weight.view().permuted_axes([1, 0, 2]);
    let names = [
        format!("{prefix}filter.{first}.weight"),
        format!("{prefix}filter.{first}.bias"),
    ];
    graph.array(&names[0], stacked.iter().copied(), &[inputs, n * units]);
    let bias = weights.layers[first].bias.iter().copied();
    graph.array(&names[1], bias, &[n * units]);
    let mut answer = sum(graph, &value, &names[0], &names[1]);
    if own.len() > 1 {
        // [filter, batch, unit]
        answer = graph.reshape(&answer, &[-1, n as i64, units as i64]);
        answer = graph.node_of_list("Transpose", &[&answer], ("perm", &[1, 0, 2]));
        for number in own.skip(1) {
            answer = activated(graph, &answer, weights.activation);
            let [weight, bias] = arrays(graph, weights, number, prefix, "filter");
            answer = sum(graph, &answer, &weight, &bias);
        }
        answer = graph.node_of_list("Transpose", &[&answer], ("perm", &[1, 0, 2]));
        answer = graph.reshape(&answer, &[-1, n as i64]);
    }
    graph.node("Sigmoid", &[&answer], &[])
}

/// What the convolutions find, `[batch, position · number]`; the inputs themselves where there are none.
fn convolved(graph: &mut Graph, inputs: &str, weights: &Weights, prefix: &str) -> String {
    let Some(first) = weights.convolutions.first() else {
        return inputs.to_string();
    };
    // Inputs are ordered by statistic, then by sector.
    let shape = [-1, first.inputs as i64, first.positions as i64];
    let by_statistic = graph.reshape(inputs, &shape);
    let mut value = graph.node_of_list("Transpose", &[&by_statistic], ("perm", &[0, 2, 1]));
    let mut width = 0;
    for (number, layer) in weights.convolutions.iter().enumerate() {
        let taps = (layer.width * layer.inputs) as i64;
        let patches = graph.gather(&value, &layer.sources(), 1);
        let patches = graph.reshape(&patches, &[-1, layer.positions_out() as i64, taps]);
        let [weight, bias] = arrays(graph, weights, number, prefix, "convolution");
        let sums = sum(graph, &patches, &weight, &bias);
        value = activated(graph, &sums, weights.activation);
        width = layer.positions_out() * layer.outputs;
    }
    graph.reshape(&value, &[-1, width as i64])
}

/// Weight and bias of a layer, in the file: of one network `[input, output]`, of several `[filter, input, output]`.
fn arrays(
    graph: &mut Graph,
    weights: &Weights,
    number: usize,
    prefix: &str,
    what: &str,
) -> [String; 2] {
    let layer = &weights.layers[number];
    let (n, inputs, outputs) = layer.weight.dim();
    let names = ["weight", "bias"].map(|part| format!("{prefix}{what}.{number}.{part}"));
    let is_shared = number < weights.trunk;
    let shape = [n, inputs, outputs];
    let shape = if is_shared { &shape[1..] } else { &shape[..] };
    graph.array(&names[0], layer.weight.iter().copied(), shape);
    let shape = [n, 1, outputs];
    let shape = if is_shared { &shape[2..] } else { &shape[..] };
    graph.array(&names[1], layer.bias.iter().copied(), shape);
    names
}

fn sum(graph: &mut Graph, value: &str, weight: &str, bias: &str) -> String {
    let product = graph.node("MatMul", &[value, weight], &[]);
    graph.node("Add", &[&product, bias], &[])
}

fn activated(graph: &mut Graph, sum: &str, activation: Activation) -> String {
    let op = match activation {
        Activation::Sigmoid => "Sigmoid",
        Activation::Tanh => "Tanh",
        Activation::Relu => "Relu",
    };
    graph.node(op, &[sum], &[])
}
