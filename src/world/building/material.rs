//! `[materials.NAME]`: what walls, floors and things are made of, by name.

use crate::{
    error::{Error, Result},
    world::{Look, Material},
};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A material as the file tells it; what it is silent about is as in the built-in material of that name, else plain.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialConfig {
    /// See [`Material::reflectivity`].
    pub reflectivity: Option<f64>,
    /// Largest angle between a ray and the surface's normal at which sound comes back, up to 90 degrees. Beyond it the
    /// surface is a mirror.
    pub critical_angle_deg: Option<f64>,
    /// See [`Material::infrared`].
    pub infrared: Option<f64>,
    /// See [`Look::colour`].
    pub colour: Option<[f64; 3]>,
    /// See [`Look::contrast`].
    pub contrast: Option<f64>,
    /// See [`Look::grain_m`].
    pub grain_m: Option<f64>,
    /// See [`Look::daylight`].
    pub daylight: Option<[f64; 3]>,
}

/// Materials by name: the file's own and the built-in ones.
#[derive(Debug, Clone)]
pub(super) struct Materials(BTreeMap<String, Material>);

impl Materials {
    /// Checks the file's materials and adds the built-in ones.
    pub(super) fn new(told: &BTreeMap<String, MaterialConfig>) -> Result<Self> {
        let mut all: BTreeMap<String, Material> = built_in()
            .into_iter()
            .map(|(name, material)| (name.to_string(), material))
            .collect();
        for (name, config) in told {
            let base = all.get(name).copied().unwrap_or(Material::PLAIN);
            let material = config.over(base);
            material
                .check()
                .map_err(|fault| Error::usage(format!("[materials.{name}]: {fault}")))?;
            all.insert(name.clone(), material);
        }
        Ok(Self(all))
    }

    /// The material of that name, wanted at a place in the file.
    pub(super) fn named(&self, name: &str, place: &str) -> Result<Material> {
        self.0.get(name).copied().ok_or_else(|| {
            let known: Vec<&str> = self.0.keys().map(String::as_str).collect();
            Error::usage(format!(
                "{place}: no material `{name}`; expected one of {}",
                known.join(", ")
            ))
        })
    }

    /// The same where a name is given, else another material.
    pub(super) fn named_or(
        &self,
        name: Option<&String>,
        otherwise: Material,
        place: &str,
    ) -> Result<Material> {
        name.map_or(Ok(otherwise), |name| self.named(name, place))
    }
}

impl MaterialConfig {
    fn over(&self, base: Material) -> Material {
        Material {
            reflectivity: self.reflectivity.unwrap_or(base.reflectivity),
            critical_angle_rad: self
                .critical_angle_deg
                .map_or(base.critical_angle_rad, f64::to_radians),
            infrared: self.infrared.unwrap_or(base.infrared),
            look: Look {
                colour: self.colour.unwrap_or(base.look.colour),
                contrast: self.contrast.unwrap_or(base.look.contrast),
                grain_m: self.grain_m.unwrap_or(base.look.grain_m),
                daylight: self.daylight.unwrap_or(base.look.daylight),
            },
        }
    }
}

/// What every file may name without saying more. Assumed values: reflectivity and roughness to ultrasound, brightness
/// to the infrared of a proximity sensor, and colour, of common surfaces.
fn built_in() -> [(&'static str, Material); 7] {
    let made =
        |reflectivity, critical_angle_deg: f64, infrared, colour, contrast, grain_m| Material {
            reflectivity,
            critical_angle_rad: critical_angle_deg.to_radians(),
            infrared,
            look: Look {
                colour,
                contrast,
                grain_m,
                daylight: [0.0; 3],
            },
        };
    [
        ("plain", Material::PLAIN),
        ("brick", made(0.9, 25.0, 0.5, [0.6, 0.35, 0.28], 0.15, 0.08)),
        ("wood", made(0.8, 10.0, 0.6, [0.55, 0.38, 0.22], 0.10, 0.05)),
        ("steel", made(1.0, 7.0, 0.5, [0.6, 0.6, 0.62], 0.03, 0.10)),
        ("glass", made(1.0, 7.0, 0.1, [0.25, 0.28, 0.3], 0.02, 0.20)),
        (
            "plastic",
            made(0.7, 30.0, 0.6, [0.35, 0.35, 0.38], 0.05, 0.05),
        ),
        ("cloth", made(0.4, 60.0, 0.4, [0.3, 0.3, 0.45], 0.15, 0.03)),
    ]
}
