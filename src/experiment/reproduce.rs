//! The experiments of the papers as comparisons that need no file: configurations and worlds are part of the program.

use super::compare::CompareConfig;
use crate::{
    error::{Error, Result},
    storage,
};
use std::{
    fmt,
    path::{Path, PathBuf},
    str::FromStr,
};

/// A paper whose tables can be made again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Paper {
    /// Thrun, *Bayesian Landmark Learning for Mobile Robot Localization*.
    Thrun1998,
    /// Duckett & Nehmzow, *Mobile robot self-localisation and measurement of performance in middle-scale environments*.
    Duckett1998,
    /// Duckett & Nehmzow, *Performance comparison of landmark recognition systems for navigating mobile robots*.
    Duckett2000,
    /// Ruiz-Mayor, Triviño & Bailador, *A performance metric for mobile robot localization*.
    Ruizmayor2006,
}

/// A file of the repository by its name below `configs/`, and what is in it.
macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../configs/", $name)))),*]
    };
}

impl Paper {
    /// All of them.
    pub const ALL: [Paper; 4] = [
        Paper::Thrun1998,
        Paper::Duckett1998,
        Paper::Duckett2000,
        Paper::Ruizmayor2006,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Paper::Thrun1998 => "thrun1998",
            Paper::Duckett1998 => "duckett1998",
            Paper::Duckett2000 => "duckett2000",
            Paper::Ruizmayor2006 => "ruizmayor2006",
        }
    }

    /// As it is cited.
    pub fn cited(self) -> &'static str {
        match self {
            Paper::Thrun1998 => "Thrun 1998",
            Paper::Duckett1998 => "Duckett & Nehmzow 1998",
            Paper::Duckett2000 => "Duckett & Nehmzow 2000",
            Paper::Ruizmayor2006 => "Ruiz-Mayor et al. 2006",
        }
    }

    /// The comparison first, where there is one, then the worlds.
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Paper::Thrun1998 => files!["worlds/thrun1998.toml", "worlds/thrun1998-twice.toml"],
            Paper::Duckett1998 => files![
                "duckett1998.toml",
                "worlds/duckett1998-a.toml",
                "worlds/duckett1998-b.toml",
                "worlds/duckett1998-c.toml",
                "worlds/duckett1998-d.toml",
                "worlds/duckett1998-e.toml",
                "worlds/duckett1998-f.toml",
            ],
            Paper::Duckett2000 => files![
                "duckett2000.toml",
                "worlds/duckett2000-a.toml",
                "worlds/duckett2000-b.toml",
                "worlds/duckett2000-c.toml",
                "worlds/duckett2000-d.toml",
            ],
            Paper::Ruizmayor2006 => files![
                "worlds/ruizmayor2006-r1.toml",
                "worlds/ruizmayor2006-r2.toml",
                "worlds/ruizmayor2006-r3.toml",
            ],
        }
    }

    /// Name of the comparison's file among those [unpacked](Self::unpack). None of [`Paper::Thrun1998`] and
    /// [`Paper::Ruizmayor2006`], whose experiments are those of [`thrun1998`](super::thrun1998) and [`ruizmayor2006`](super::ruizmayor2006).
    pub fn configuration(self) -> Option<&'static str> {
        match self {
            Paper::Thrun1998 | Paper::Ruizmayor2006 => None,
            Paper::Duckett1998 | Paper::Duckett2000 => Some(self.files()[0].0),
        }
    }

    /// The text of one of its files.
    pub(super) fn file(self, name: &str) -> Result<&'static str> {
        let mut files = self.files().iter();
        let file = files.find(|(known, _)| *known == name);
        file.map(|(_, text)| *text)
            .ok_or_else(|| Error::work(format!("{self}: no file `{name}`")))
    }

    /// The comparison that makes its tables, where one does.
    ///
    /// ```
    /// use ballmark::experiment::reproduce::Paper;
    /// let comparison = Paper::Duckett1998.comparison()?.unwrap();
    /// assert_eq!((comparison.dataset.len(), comparison.system.len()), (6, 3));
    /// assert_eq!(Paper::Thrun1998.comparison()?, None);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// Never, unless the program was built from a broken tree.
    pub fn comparison(self) -> Result<Option<CompareConfig>> {
        let text = self.configuration().map(|name| self.file(name));
        let text = text.transpose()?;
        text.map(CompareConfig::parse).transpose()
    }

    /// Writes all files below a folder, as the comparison expects to find them, and tells their names.
    ///
    /// # Errors
    /// Where a file can't be written.
    pub fn unpack(self, folder: &Path) -> Result<Vec<PathBuf>> {
        let write = |(name, text): &(&str, &str)| {
            let path = folder.join(name);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent)
                    .map_err(|e| Error::io("cannot make the folder", parent, e))?;
            }
            storage::write_file(&path, |out| out.write_all(text.as_bytes()))?;
            Ok(path)
        };
        self.files().iter().map(write).collect()
    }
}

impl fmt::Display for Paper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Paper {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let found = Paper::ALL.into_iter().find(|paper| paper.name() == name);
        found.ok_or_else(|| {
            Error::usage(format!(
                "no paper `{}`; expected one of {}",
                name.escape_debug(),
                Paper::ALL.map(Paper::name).join(", ")
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::printed::{DUCKETT_1998, DUCKETT_2000, DUCKETT_2000_SYSTEMS};

    /// Every environment and every system that the tables print is asked for, under the printed name.
    #[test]
    fn comparisons_ask_for_what_is_printed() {
        let names = |paper: Paper| {
            let comparison = paper.comparison().unwrap().unwrap();
            let datasets: Vec<String> = comparison.dataset.iter().map(|d| d.name.clone()).collect();
            let systems: Vec<String> = comparison.system.iter().map(|s| s.name.clone()).collect();
            (datasets, systems)
        };
        let (datasets, _) = names(Paper::Duckett1998);
        assert_eq!(datasets, DUCKETT_1998.map(|row| row.environment));
        let (datasets, systems) = names(Paper::Duckett2000);
        assert_eq!(datasets, DUCKETT_2000.map(|row| row.environment));
        assert_eq!(systems, DUCKETT_2000_SYSTEMS.map(|system| system.printed));
    }

    #[test]
    fn worlds_are_unpacked_where_the_comparison_looks_for_them() {
        for paper in Paper::ALL {
            let folder = tempfile::tempdir().unwrap();
            let unpacked = paper.unpack(folder.path()).unwrap();
            let comparison = paper.comparison().unwrap();
            for dataset in comparison.into_iter().flat_map(|c| c.dataset) {
                let world = folder.path().join(dataset.world.unwrap());
                assert!(unpacked.contains(&world) && world.exists(), "{world:?}");
            }
        }
    }
}
