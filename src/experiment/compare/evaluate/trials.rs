//! Localisation trials of all systems on one dataset.

use super::Evaluator;
use crate::{
    error::{Error, Result},
    experiment::{
        compare::System, localisation, method::Method, methods::MethodContext,
        more_particles::FewerParticles,
    },
};

impl Evaluator<'_, '_> {
    /// The trials with people in the way of what is tested on, where the section says so and `[degraded]` has not put them there.
    pub(super) fn among_people(
        &mut self,
        systems: &[Result<System>],
        context: &MethodContext,
    ) -> Result<localisation::Record> {
        let are_there = self.config.degraded.people.is_some();
        if are_there || context.config.people() == 0.0 {
            return self.localisation(systems, context);
        }
        let (parts, config) = (context.parts, context.config);
        let crowded = parts
            .run
            .with_people(&parts.unseen, config.people(), config.seed())?;
        let parts = parts.with_run(&crowded);
        let context = MethodContext {
            parts: &parts,
            ..context.clone()
        };
        self.localisation(systems, &context)
    }

    /// Every system plays the same trials; one that can't be made is left out, with the reason.
    fn localisation(
        &mut self,
        systems: &[Result<System>],
        context: &MethodContext,
    ) -> Result<localisation::Record> {
        let mut methods = Vec::new();
        for (system, config) in systems.iter().zip(&self.config.system) {
            let name = &config.name;
            let now = format!("{}: {name} gets ready", self.dataset);
            self.progress_counter.meanwhile(&now);
            let method = match system {
                Ok(system) => system.method(context, name),
                Err(fault) => Err(Error::work(fault.to_string())),
            };
            methods.push(method.unwrap_or_else(|fault| context.left_out(name, name, &fault)));
            methods.extend(self.with_more_particles(system, name, context));
        }
        localisation::play(context, methods, &mut |at| {
            let now = format!("{}: {} in trials", self.dataset, at.next);
            self.progress_counter.next(&now);
        })
    }

    /// The same system with more particles, where trials ask for it and it has any.
    fn with_more_particles<'a>(
        &mut self,
        system: &Result<System>,
        name: &str,
        context: &MethodContext<'a>,
    ) -> Option<Method<'a>> {
        let times = context.config.more_particles;
        let system = system.as_ref().ok().filter(|_| times > 1)?;
        let (system, [more, fewer]) = system.with_more_particles(times)?;
        let title = format!("{name}, {more} particles");
        let now = format!("{}: {title} gets ready", self.dataset);
        self.progress_counter.meanwhile(&now);
        let method = system.method(context, &title);
        let method = method.unwrap_or_else(|fault| context.left_out(&title, &title, &fault));
        let name = name.to_string();
        Some(Method {
            fewer_particles: Some(FewerParticles { name, fewer, more }),
            ..method
        })
    }
}
