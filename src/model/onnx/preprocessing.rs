//! From raw channel values to normalised inputs, as nodes of a graph.

use super::graph::Graph;
use crate::{
    detector::input::{ChannelSteps, Input, SectorValue},
    error::Result,
    recording::Channel,
};
use std::{collections::BTreeMap, ops::Range};

/// Adds the nodes; `raw` are the values of all channels side by side, `[batch, value]`. The result is `[batch, input]`. `prefix` begins the
/// names of the arrays.
pub fn inputs(
    graph: &mut Graph,
    raw: &str,
    input: &Input,
    channels: &[Channel],
    prefix: &str,
) -> Result<String> {
    let (mut pooled, mut from) = (Vec::new(), 0);
    for steps in input.steps(channels)? {
        match &steps {
            ChannelSteps::Ranges {
                columns,
                clip,
                far_clip,
                sectors,
                statistics,
            } => {
                let width = sectors.len() * statistics.len();
                let mean = &input.mean[from..from + width];
                from += width;
                let beams = beams(graph, raw, columns, *far_clip);
                let sorted = Sorted::of(graph, &beams, sectors);
                for (number, statistic) in statistics.iter().enumerate() {
                    let means = &mean[number * sectors.len()..(number + 1) * sectors.len()];
                    pooled.push(sorted.statistic(graph, *statistic, *clip, (&beams, means)));
                }
            }
            ChannelSteps::Values { columns, may_miss } => {
                from += columns.len() + may_miss.len();
                let own: Vec<usize> = columns.clone().collect();
                let values = graph.gather(raw, &own, 1);
                if !may_miss.is_empty() {
                    let some = graph.gather(&values, may_miss, 1);
                    let missing = graph.node("IsNaN", &[&some], &[]);
                    let there = graph.node("Not", &[&missing], &[]);
                    let there = graph.node("Cast", &[&there], &[("to", 1)]); // f32
                    pooled.extend([values, there]);
                } else {
                    pooled.push(values);
                }
            }
        }
    }
    let pooled: Vec<&str> = pooled.iter().map(String::as_str).collect();
    let pooled = match &pooled[..] {
        [one] => one.to_string(),
        all => graph.node("Concat", all, &[("axis", 1)]),
    };
    let [mean, deviation] = ["mean", "deviation"].map(|name| format!("{prefix}input.{name}"));
    graph.array(&mean, input.mean.iter().copied(), &[input.mean.len()]);
    let own = input.deviation.iter().copied();
    graph.array(&deviation, own, &[input.deviation.len()]);
    let centred = graph.node("Sub", &[&pooled, &mean], &[]);
    let normal = graph.node("Div", &[&centred, &deviation], &[]);
    // What is missing is at its mean.
    let (missing, zero) = (graph.node("IsNaN", &[&pooled], &[]), graph.scalar(0.0));
    Ok(graph.node("Where", &[&missing, &zero, &normal], &[]))
}

/// The beams of a channel, those without return at the clip.
fn beams(graph: &mut Graph, raw: &str, columns: &Range<usize>, far_clip: f32) -> String {
    let own: Vec<usize> = columns.clone().collect();
    let beams = graph.gather(raw, &own, 1);
    let (nothing, most) = (graph.scalar(0.0), graph.scalar(far_clip));
    let missing = graph.node("IsNaN", &[&beams], &[]);
    let beams = graph.node("Where", &[&missing, &most, &beams], &[]);
    graph.node("Clip", &[&beams, &nothing, &most], &[])
}

/// The sectors with their beams in ascending order, those of as many beams together.
struct Sorted {
    /// Of each number of beams: the sectors, and their values `[batch, sector, beam]`; of none, no values.
    groups: Vec<(usize, Vec<usize>, Option<String>)>,
    sectors: usize,
}

impl Sorted {
    fn of(graph: &mut Graph, beams: &str, sectors: &[Vec<usize>]) -> Self {
        let mut by_size: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (sector, beams) in sectors.iter().enumerate() {
            by_size.entry(beams.len()).or_default().push(sector);
        }
        let groups = by_size.into_iter().map(|(size, own)| {
            let at: Vec<usize> = own.iter().flat_map(|&s| &sectors[s]).copied().collect();
            let values = (size > 0).then(|| {
                let some = graph.gather(beams, &at, 1);
                let shaped = graph.reshape(&some, &[-1, own.len() as i64, size as i64]);
                match size {
                    1 => shaped,
                    _ => graph.sorted(&shaped, size),
                }
            });
            (size, own, values)
        });
        Self {
            groups: groups.collect(),
            sectors: sectors.len(),
        }
    }

    /// A statistic of every sector, in their order, `[batch, sector]`; where there is no beam, the mean.
    fn statistic(
        &self,
        graph: &mut Graph,
        statistic: SectorValue,
        clip: f32,
        (beams, means): (&str, &[f32]),
    ) -> String {
        let (mut values, mut order) = (Vec::new(), Vec::<usize>::new());
        for (size, own, sorted) in &self.groups {
            order.extend_from_slice(own);
            let Some(sorted) = sorted else {
                // Zeros of the batch's size, and the means.
                let first = graph.gather(beams, &vec![0; own.len()], 1);
                let zero = graph.scalar(0.0);
                let zeros = graph.node("Mul", &[&first, &zero], &[]);
                let means: Vec<f32> = own.iter().map(|&sector| means[sector]).collect();
                let means = graph.floats(&means);
                values.push(graph.node("Add", &[&zeros, &means], &[]));
                continue;
            };
            let at = match statistic {
                SectorValue::Nearest => 0,
                SectorValue::Middle | SectorValue::MiddleLog => (size - 1) / 2,
                SectorValue::Farthest | SectorValue::FarthestLog => size - 1,
            };
            let chosen = graph.gather(sorted, &[at], 2);
            let chosen = graph.reshape(&chosen, &[-1, own.len() as i64]);
            values.push(match statistic.is_log() {
                true => {
                    let one = graph.scalar(1.0);
                    let more = graph.node("Add", &[&chosen, &one], &[]);
                    graph.node("Log", &[&more], &[])
                }
                false => {
                    let clip = graph.scalar(clip);
                    graph.node("Min", &[&chosen, &clip], &[])
                }
            });
        }
        let values: Vec<&str> = values.iter().map(String::as_str).collect();
        let [one] = values[..] else {
            let all = graph.node("Concat", &values, &[("axis", 1)]);
            let mut back = vec![0; self.sectors];
            order
                .iter()
                .enumerate()
                .for_each(|(at, &sector)| back[sector] = at);
            return graph.gather(&all, &back, 1);
        };
        one.to_string()
    }
}
