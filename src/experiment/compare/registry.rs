//! Kinds of systems that a configuration may name: the built-in ones, and those that a program adds.

use super::system::{System, SystemConfig};
use crate::{
    detector::{DetectorConfig, HandMade},
    error::{Error, Result},
    experiment::{
        filter_config::FilterConfig,
        sensor_models::{Landmarks, SensorModelConfig},
    },
    learning::Recipe,
    localiser::{self, LocaliserConfig, monte_carlo::MonteCarloConfig},
    recogniser::{self, RecogniserConfig},
};
use serde::{
    Deserialize,
    de::{DeserializeOwned, Error as _},
};
use std::{fmt, path::PathBuf};

/// Makes a system of its table, without `kind`, `name` and `train`.
type Parse = Box<dyn Fn(&Registry, toml::Table) -> Parsed + Send + Sync>;
/// Makes a sensor model of its table, without `kind`.
type ParseSensor = Box<dyn Fn(toml::Table) -> ParsedSensor + Send + Sync>;
type ParsedSensor = std::result::Result<Box<dyn SensorModelConfig>, toml::de::Error>;
type Parsed = std::result::Result<System, toml::de::Error>;

/// Kinds of systems by the names that configurations use.
///
/// ```
/// use ballmark::{experiment::compare::{CompareConfig, Registry}, recording::{Channel, Observation, Recording}};
/// use ballmark::{Recogniser, Result, Seed, recogniser::{RecogniserConfig, Response}, registry::Constants};
///
/// /// Answers everything alike.
/// #[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Constant { class: usize }
///
/// impl Constants for Constant {
///     fn kind(&self) -> &str {
///         "constant"
///     }
/// }
///
/// impl RecogniserConfig for Constant {
///     fn learn(&self, _: &Recording, _: &[usize], _: Seed) -> Result<Box<dyn Recogniser>> {
///         Ok(Box::new(self.clone()))
///     }
/// }
///
/// impl Recogniser for Constant {
///     fn name(&self) -> &str {
///         "constant"
///     }
///     // …
/// #   fn responses(&self) -> usize { self.class + 1 }
/// #   fn matches(&self) -> usize { 1 }
/// #   fn bytes_per_place(&self) -> usize { 8 }
/// #   fn check_channels(&self, _: &[Channel]) -> Result<()> { Ok(()) }
/// #   fn respond(&self, _: &[Channel], _: &Observation) -> Option<Response> { Some(Response { class: self.class, fit: 1.0 }) }
/// }
///
/// let mut registry = Registry::built_in();
/// registry.add_recogniser::<Constant>("constant")?;
/// let config = CompareConfig::parse_with(&registry, r#"
///     dataset = [{ file = "walk.npz" }]
///     system = [{ kind = "constant", class = 7 }, { kind = "nearest" }]
///     [recognition]
/// "#)?;
/// assert_eq!(config.system[0].system.to_json()?["class"], 7);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct Registry {
    kinds: Vec<(String, Parse)>,
    /// Kinds of sensor models, for `landmarks`.
    sensor_models: Vec<(String, ParseSensor)>,
    /// Names that kinds had in the version before, and which kinds these are.
    former: Vec<(&'static str, &'static str)>,
}

impl Default for Registry {
    fn default() -> Self {
        Self::built_in()
    }
}

impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

impl Registry {
    /// All built-in kinds.
    pub fn built_in() -> Self {
        let mut registry = Self {
            kinds: Vec::new(),
            sensor_models: Vec::new(),
            former: Vec::new(),
        };
        for kind in recogniser::Kind::ALL {
            registry.put(kind.name(), |table| {
                let config: recogniser::Config = table.try_into()?;
                Ok(System::Recogniser(Box::new(config)))
            });
            let former = kind.former_name().map(|former| (former, kind.name()));
            registry.former.extend(former);
        }
        for name in Landmarks::NAMES {
            let parse = move |mut table: toml::Table| {
                table.insert("kind".into(), toml::Value::String(name.into()));
                let landmarks: Landmarks = table.try_into()?;
                Ok(Box::new(landmarks) as Box<dyn SensorModelConfig>)
            };
            registry.sensor_models.push((name.into(), Box::new(parse)));
        }
        registry
            .kinds
            .push(("bayes".into(), Box::new(Registry::filter)));
        let whole = localiser::Kind::ALL.iter();
        for kind in whole.filter(|&&kind| kind != localiser::Kind::Bayes) {
            registry.put(kind.name(), |table| {
                let config: localiser::Config = table.try_into()?;
                Ok(System::Localiser(Box::new(config)))
            });
            let former = kind.former_name().map(|former| (former, kind.name()));
            registry.former.extend(former);
        }
        let monte_carlo = |_: &Registry, table: toml::Table| {
            let config: MonteCarloConfig = table.try_into()?;
            Ok(System::Localiser(Box::new(config)))
        };
        let name = "monte_carlo".to_string();
        registry.kinds.push((name, Box::new(monte_carlo)));
        let external = |_: &Registry, table: toml::Table| Ok(System::External(table.try_into()?));
        registry.kinds.push(("external".into(), Box::new(external)));
        for name in HandMade::NAMES {
            registry.put(name, |table| {
                let config: HandMade = table.try_into()?;
                Ok(System::Detector(Box::new(config)))
            });
        }
        registry
    }

    /// A built-in kind: an enumeration whose `kind` says which of its members the constants are of.
    fn put(&mut self, kind: &'static str, parse: fn(toml::Table) -> Parsed) {
        let with_kind = move |_: &Registry, mut table: toml::Table| {
            table.insert("kind".into(), toml::Value::String(kind.into()));
            parse(table)
        };
        self.kinds.push((kind.into(), Box::new(with_kind)));
    }

    /// Adds a kind of recogniser. Its constants are read from the keys of a `[[system]]` but `kind`, `name` and `train`.
    ///
    /// # Errors
    /// A usage error where there is a kind of this name already.
    pub fn add_recogniser<C>(&mut self, kind: &str) -> Result<()>
    where
        C: RecogniserConfig + DeserializeOwned + 'static,
    {
        self.add(kind, |table| {
            let config: C = table.try_into()?;
            Ok(System::Recogniser(Box::new(config)))
        })
    }

    /// The same of a localiser.
    ///
    /// # Errors
    /// A usage error where there is a kind of this name already.
    pub fn add_localiser<C>(&mut self, kind: &str) -> Result<()>
    where
        C: LocaliserConfig + DeserializeOwned + 'static,
    {
        self.add(kind, |table| {
            let config: C = table.try_into()?;
            Ok(System::Localiser(Box::new(config)))
        })
    }

    /// The same of a detector.
    ///
    /// # Errors
    /// A usage error where there is a kind of this name already.
    pub fn add_detector<C>(&mut self, kind: &str) -> Result<()>
    where
        C: DetectorConfig + DeserializeOwned + 'static,
    {
        self.add(kind, |table| {
            let config: C = table.try_into()?;
            Ok(System::Detector(Box::new(config)))
        })
    }

    /// The same of a sensor model: a name that `landmarks` of `kind = "bayes"` may have.
    ///
    /// # Errors
    /// A usage error where there is a sensor model of this name already.
    pub fn add_sensor_model<C>(&mut self, kind: &str) -> Result<()>
    where
        C: SensorModelConfig + DeserializeOwned + 'static,
    {
        if self.sensor_models.iter().any(|(known, _)| known == kind) {
            return Err(taken(kind));
        }
        let parse = |table: toml::Table| {
            let config: C = table.try_into()?;
            Ok(Box::new(config) as Box<dyn SensorModelConfig>)
        };
        self.sensor_models.push((kind.into(), Box::new(parse)));
        Ok(())
    }

    fn add(&mut self, kind: &str, parse: fn(toml::Table) -> Parsed) -> Result<()> {
        if self.find(kind).is_some() {
            return Err(taken(kind));
        }
        let parse = move |_: &Registry, table| parse(table);
        self.kinds.push((kind.into(), Box::new(parse)));
        Ok(())
    }

    /// The grid Bayes filter: `landmarks` names a sensor model, or is its table with `kind`, or several of them.
    fn filter(&self, table: toml::Table) -> Parsed {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Keys {
            landmarks: Option<toml::Value>,
            #[serde(default)]
            model: PathBuf,
        }
        let Keys { landmarks, model } = table.try_into()?;
        let landmarks = match landmarks {
            None => vec![toml::Value::String("learned".into())],
            Some(toml::Value::Array(several)) => several,
            Some(one) => vec![one],
        };
        let landmarks = landmarks.into_iter().map(|one| self.landmarks(one));
        let landmarks = landmarks.collect::<std::result::Result<_, _>>()?;
        Ok(System::Filter(FilterConfig { landmarks, model }))
    }

    fn landmarks(&self, value: toml::Value) -> ParsedSensor {
        let mut table = match value {
            toml::Value::String(kind) => toml::Table::from_iter([("kind".into(), kind.into())]),
            toml::Value::Table(table) => table,
            other => {
                let fault = format!(
                    "{other}: expected the name of a sensor model in quotes, or its table with `kind`"
                );
                return Err(toml::de::Error::custom(fault));
            }
        };
        let Some(toml::Value::String(kind)) = table.remove("kind") else {
            return Err(toml::de::Error::custom(
                "no `kind` in quotes in a table of `landmarks`",
            ));
        };
        let found = self.sensor_models.iter().find(|(known, _)| *known == kind);
        let Some((_, parse)) = found else {
            let all: Vec<&str> = self
                .sensor_models
                .iter()
                .map(|(name, _)| name.as_str())
                .collect();
            return Err(toml::de::Error::custom(format!(
                "no sensor model `{}`; expected one of {}",
                kind.escape_debug(),
                all.join(", ")
            )));
        };
        parse(table).map_err(|fault| {
            toml::de::Error::custom(format!("`{}`: {}", kind.escape_debug(), fault.message()))
        })
    }

    /// Names of all kinds.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.kinds.iter().map(|(name, _)| name.as_str())
    }

    fn find(&self, kind: &str) -> Option<&Parse> {
        let former = self.former.iter().find(|(former, _)| *former == kind);
        let name = former.map_or(kind, |(_, name)| name);
        let found = self.kinds.iter().find(|(known, _)| known == name);
        found.map(|(_, parse)| parse)
    }

    /// A system from its table: `kind`, optional `name` and `train`, and the constants of its kind.
    pub(super) fn parse(
        &self,
        mut keys: toml::Table,
    ) -> std::result::Result<SystemConfig, KeyFault> {
        let word = |keys: &mut toml::Table, key: &str| match keys.remove(key) {
            None => Ok(None),
            Some(toml::Value::String(word)) => Ok(Some(word)),
            Some(other) => Err((
                Some(key.to_string()),
                format!("`{key}` is {other}; expected words in quotes"),
            )),
        };
        let every_kind = || format!("one of {}", self.names().collect::<Vec<_>>().join(", "));
        let kind = word(&mut keys, "kind")?;
        let kind = kind.ok_or_else(|| (None, format!("no `kind`; expected {}", every_kind())))?;
        let name = word(&mut keys, "name")?.unwrap_or_else(|| kind.clone());
        let train = keys.remove("train").map(|table| {
            let recipe = table.try_into::<Recipe>();
            recipe.map_err(|e| {
                (
                    Some("train".to_string()),
                    format!("`train`: {}", e.message()),
                )
            })
        });
        let parse = self.find(&kind).ok_or_else(|| {
            let fault = format!(
                "no kind `{}`; expected {}",
                kind.escape_debug(),
                every_kind()
            );
            (Some("kind".to_string()), fault)
        })?;
        let system = parse(self, keys.clone()).map_err(|fault| {
            // Each key tried alone tells which one is at fault, unless another one is missing then.
            let faults = keys.iter().filter_map(|(key, value)| {
                let alone = toml::Table::from_iter([(key.clone(), value.clone())]);
                let fault = parse(self, alone).err()?;
                let is_of_key = !fault.message().starts_with("missing field");
                is_of_key.then(|| (Some(key.clone()), fault_of_key(&kind, key, &fault)))
            });
            let mut faults = faults;
            let first = faults.next();
            first.unwrap_or_else(|| (None, format!("{kind}: {}", fault.message())))
        })?;
        Ok(SystemConfig {
            name,
            system,
            train: train.transpose()?,
        })
    }
}

fn taken(kind: &str) -> Error {
    Error::usage(format!(
        "there is a kind `{}` already; expected another name",
        kind.escape_debug()
    ))
}

/// What is wrong in a system's table: the key, where it is one key's fault, and the fault.
pub(super) type KeyFault = (Option<String>, String);

fn fault_of_key(kind: &str, key: &str, fault: &toml::de::Error) -> String {
    match fault.message() {
        unknown if unknown.starts_with("unknown field") => format!("{kind}: {unknown}"),
        other => format!("{kind}: `{key}`: {other}"),
    }
}
