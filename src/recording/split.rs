//! stub
use crate::{error::Result, recording::Recording};
use serde::{Deserialize, Serialize};
#[derive(Debug, Clone, PartialEq)]
pub struct Split {
    pub train: Vec<usize>,
    pub validation: Vec<usize>,
    pub test: Vec<usize>,
}
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SplitConfig {
    pub stretch_m: Option<f64>,
    pub folds: usize,
    pub test_fold: Option<usize>,
    pub validation_every: usize,
}
impl Default for SplitConfig {
    fn default() -> Self {
        Self {
            stretch_m: Some(15.0),
            folds: 4,
            test_fold: None,
            validation_every: 8,
        }
    }
}
impl SplitConfig {
    pub fn check(&self) -> Result<()> {
        Ok(())
    }
    pub fn split(&self, r: &Recording) -> Result<Split> {
        let t = r.travelled_m();
        let mut s = Split {
            train: vec![],
            validation: vec![],
            test: vec![],
        };
        let mut unit = 0usize;
        let mut rest = 0usize;
        let mut last = None;
        let mut part = 0;
        for run in r.runs() {
            for k in run.clone() {
                let id = (run.start, self.stretch_m.map_or(0, |m| (t[k] / m) as usize));
                if last != Some(id) {
                    last = Some(id);
                    part = if self.test_fold == Some(unit % self.folds) {
                        2
                    } else {
                        rest += 1;
                        if rest % self.validation_every == self.validation_every / 2 {
                            1
                        } else {
                            0
                        }
                    };
                    unit += 1;
                }
                match part {
                    0 => s.train.push(k),
                    1 => s.validation.push(k),
                    _ => s.test.push(k),
                }
            }
        }
        Ok(s)
    }
}
