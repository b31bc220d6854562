//! The names of the simulated robot's topics and of its action.

use bags::resolve;
use scenarios::Error;

use super::navigation;
use crate::sim::SimArgs;

/// The names, resolved in a namespace and remapped.
#[derive(Debug)]
pub(super) struct Topics {
    pub(super) clock: String,
    pub(super) tf: String,
    pub(super) tf_static: String,
    pub(super) map: String,
    pub(super) scan: String,
    pub(super) odom: String,
    pub(super) battery: String,
    pub(super) contacts: String,
    pub(super) estimate: String,
    pub(super) particles: String,
    pub(super) plan: String,
    /// Those that it listens to.
    pub(super) command: String,
    pub(super) initial_pose: String,
    /// The action.
    pub(super) navigate: String,
    /// All of them but the clock, which robots share.
    names: Vec<String>,
}

impl Topics {
    /// The topics in a namespace. Several robots have their transforms there, too: their frames have the same names.
    ///
    /// # Errors
    /// If a remapping is about none of them, or if two would have one name.
    pub(super) fn of(args: &SimArgs, space: &str) -> Result<Self, Error> {
        let [tf, tf_static] = if args.namespaces.len() > 1 { ["tf", "tf_static"] } else { ["/tf", "/tf_static"] };
        let (mut is_used, mut names) = (vec![false; args.remapped.len()], Vec::new());
        let mut name = |name: &str| {
            let (name, rule) = resolve(space, name, &args.remapped);
            rule.into_iter().for_each(|rule| is_used[rule] = true);
            names.push(name.clone());
            name
        };
        let mut topics = Self {
            clock: name("/clock"),
            tf: name(tf),
            tf_static: name(tf_static),
            map: name("map"),
            scan: name("scan"),
            odom: name("odom"),
            battery: name("battery_state"),
            contacts: name("contacts"),
            estimate: name("amcl_pose"),
            particles: name("particle_cloud"),
            plan: name("plan"),
            command: name("cmd_vel"),
            initial_pose: name("initialpose"),
            navigate: name(navigation::NAME),
            names: Vec::new(),
        };
        if let Some((_, twice)) = names.iter().enumerate().find(|(place, name)| names[..*place].contains(name)) {
            let message = format!("`--remap`: two of them would have the name {twice}");
            return Err(Error::refused(message, "give each its own"));
        }
        match args.remapped.iter().zip(is_used).find(|(_, is_used)| !is_used) {
            Some((rule, _)) => {
                let message = format!("`--remap`: there is no `{}`, or an earlier one is about it", rule.from);
                Err(Error::refused(message, "`steward sim --help` lists what there is"))
            }
            None => {
                topics.names = names.split_off(1);
                Ok(topics)
            }
        }
    }

    /// Refuses robots of which two would speak or listen in one place, or that have several clocks.
    pub(super) fn check(robots: &[Self]) -> Result<(), Error> {
        for (place, robot) in robots.iter().enumerate() {
            let others = &robots[..place];
            let shared = robot.names.iter().find(|name| others.iter().any(|other| other.names.contains(name)));
            if let Some(name) = shared {
                let message = format!("two robots would have the name {name}");
                return Err(Error::refused(message, "remap to names without `/`: each robot has its own"));
            }
            if others.iter().any(|other| other.clock != robot.clock) {
                return Err(Error::refused("robots of one process have one clock", "do not remap it, or to `/NAME`"));
            }
        }
        Ok(())
    }
}
