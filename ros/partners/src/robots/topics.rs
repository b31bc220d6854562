//! The names of the simulated robot's topics, services and actions.

use std::collections::BTreeMap;

use bags::{Remapping, resolve};
use remote::{Offered, action};
use scenarios::Error;

use super::config::RobotConfig;
use super::lifecycle::{self, ManagedNode};
use super::navigation;

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
    pub(super) doors: String,
    pub(super) estimate: String,
    pub(super) particles: String,
    pub(super) plan: String,
    /// The topics to which it subscribes.
    pub(super) command: String,
    pub(super) initial_pose: String,
    /// The services and topics of its action and of the scenario's components.
    pub(super) offered: OfferedNames,
    /// All topics except the clock, which robots share.
    names: Vec<String>,
}

/// The services and topics of components and of the robot's action. A name *within* the program is that of the
/// component's interface.
#[derive(Clone, Debug, Default)]
pub(super) struct OfferedNames {
    /// By their names in the domain: their names within the program, and their types.
    pub(super) services: BTreeMap<String, (String, String)>,
    /// By their names within the program.
    pub(super) topics: BTreeMap<String, OfferedTopic>,
}

/// A topic on which a component publishes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct OfferedTopic {
    /// Its name in the domain.
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) is_latched: bool,
}

/// Names in a namespace.
struct UsedNames<'a> {
    space: &'a str,
    remapped: &'a [Remapping],
    /// Which of the remappings apply to a name.
    is_used: Vec<bool>,
    /// The topics.
    all: Vec<String>,
}

impl UsedNames<'_> {
    fn resolve(&mut self, name: &str) -> String {
        let (name, rule) = resolve(self.space, name, self.remapped);
        rule.into_iter().for_each(|rule| self.is_used[rule] = true);
        name
    }

    fn topic(&mut self, name: &str) -> String {
        let name = self.resolve(name);
        self.all.push(name.clone());
        name
    }
}

impl OfferedNames {
    /// Adds services and topics by their names within the program. These begin with `/`, which the robot's namespace
    /// replaces in the domain.
    fn add(
        &mut self,
        services: impl Iterator<Item = (String, String)>,
        topics: impl Iterator<Item = (String, String)>,
        statuses: impl Iterator<Item = (String, String)>,
        names: &mut UsedNames<'_>,
    ) -> Result<(), Error> {
        for (within, kind) in services {
            let name = names.resolve(within.trim_start_matches('/'));
            if self.services.insert(name.clone(), (within, kind)).is_some() {
                return Err(twice(&name));
            }
        }
        let topics = topics.map(|topic| (topic, false)).chain(statuses.map(|topic| (topic, true)));
        for ((within, kind), is_latched) in topics {
            let name = names.topic(within.trim_start_matches('/'));
            self.topics.insert(within, OfferedTopic { name, kind, is_latched });
        }
        Ok(())
    }
}

fn twice(name: &str) -> Error {
    Error::refused(format!("`--remap`: two of them would have the name {name}"), "give each its own")
}

impl Topics {
    /// The topics in a namespace, with those of components. Several robots also have their transforms there, since
    /// their frames have the same names.
    ///
    /// # Errors
    /// If a remapping applies to none of them, or if two would have the same name.
    pub(super) fn of(config: &RobotConfig, space: &str, components: &[Offered]) -> Result<Self, Error> {
        let [tf, tf_static] = if config.namespaces.len() > 1 { ["tf", "tf_static"] } else { ["/tf", "/tf_static"] };
        let is_used = vec![false; config.remapped.len()];
        let mut names = UsedNames { space, remapped: &config.remapped, is_used, all: Vec::new() };
        let mut topics = Self {
            clock: names.topic("/clock"),
            tf: names.topic(tf),
            tf_static: names.topic(tf_static),
            map: names.topic("map"),
            scan: names.topic("scan"),
            odom: names.topic("odom"),
            battery: names.topic("battery_state"),
            contacts: names.topic("contacts"),
            doors: names.topic("doors"),
            estimate: names.topic("amcl_pose"),
            particles: names.topic("particle_cloud"),
            plan: names.topic("plan"),
            command: names.topic("cmd_vel"),
            initial_pose: names.topic("initialpose"),
            offered: OfferedNames::default(),
            names: Vec::new(),
        };
        // These names can be remapped even if the services are not offered.
        names.resolve(navigation::NAME);
        for node in ManagedNode::ALL {
            let name = names.resolve(node.service());
            if node.is_there(config) {
                let within = format!("/{}", node.service());
                topics.offered.services.insert(name, (within, lifecycle::KIND.to_owned()));
            }
        }
        if config.navigates {
            let (name, kind) = (format!("/{}", navigation::NAME), navigation::KIND);
            let services = action::services(&name, kind).into_iter();
            let feedback = (action::feedback(&name), action::feedback_kind(kind));
            let status = (action::status(&name), action::STATUS_KIND.to_owned());
            topics.offered.add(services, [feedback].into_iter(), [status].into_iter(), &mut names)?;
        }
        for (_, of) in components {
            topics.offered.add(of.services(), of.topics(), of.statuses(), &mut names)?;
        }
        let UsedNames { is_used, mut all, .. } = names;
        if let Some((_, name)) = all.iter().enumerate().find(|(place, name)| all[..*place].contains(name)) {
            return Err(twice(name));
        }
        match config.remapped.iter().zip(is_used).find(|(_, is_used)| !is_used) {
            Some((rule, _)) => {
                let message = format!("`--remap`: there is no `{}`, or an earlier one is about it", rule.from);
                Err(Error::refused(
                    message,
                    "`steward sim --help` lists what there is, besides the scenario's components",
                ))
            }
            None => {
                topics.names = all.split_off(1);
                Ok(topics)
            }
        }
    }

    /// Refuses robots that would share a topic or a service, or that have several clocks.
    pub(super) fn check(robots: &[Self]) -> Result<(), Error> {
        for (place, robot) in robots.iter().enumerate() {
            let others = &robots[..place];
            let has = |other: &Self, name| other.names.contains(name) || other.offered.services.contains_key(name);
            let mut names = robot.names.iter().chain(robot.offered.services.keys());
            let shared = names.find(|name| others.iter().any(|other| has(other, name)));
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

#[cfg(test)]
mod tests {
    use scenarios::scenario::{Scenario, find};

    use super::super::config::PaceConfig;
    use super::ManagedNode::{Localizer, Navigator};
    use super::*;

    /// The names of a robot in each of these namespaces, some of them remapped, which does the work of these nodes.
    fn topics(spaces: &[&str], remapped: &[[&str; 2]], nodes: &[ManagedNode]) -> Result<Vec<Topics>, String> {
        let rule = |[from, to]: &[&str; 2]| Remapping { from: (*from).to_owned(), to: (*to).to_owned() };
        let config = RobotConfig {
            namespaces: spaces.iter().map(|space| (*space).to_owned()).collect(),
            remapped: remapped.iter().map(rule).collect(),
            frames: Vec::new(),
            localizes: nodes.contains(&Localizer),
            navigates: nodes.contains(&Navigator),
            publishes_map: true,
            pace: PaceConfig::Steady { speed: 1.0 },
        };
        let found = find::find("parcel").expect("a shipped scenario");
        let scenario = Scenario::load(&found, &[]).expect("a sound scenario");
        let offered = scenario.offered().offered;
        let robots = config.spaces().into_iter().map(|space| Topics::of(&config, space, &offered));
        let robots = robots.collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())?;
        Topics::check(&robots).map_err(|error| error.to_string()).map(|()| robots)
    }

    #[test]
    fn components_have_their_names_in_the_namespace_unless_they_are_remapped() {
        let [robot] = &topics(&["/r1"], &[["Door/open", "gate/open"]], &[]).expect("names")[..] else {
            panic!("one robot")
        };
        let kind = || "std_srvs/srv/Trigger".to_owned();
        assert_eq!(robot.offered.services["/r1/gate/open"], ("/Door/open".to_owned(), kind()));
        assert_eq!(robot.offered.services["/r1/Door/close"], ("/Door/close".to_owned(), kind()));
        let moved = OfferedTopic {
            name: "/r1/Door/moved".to_owned(),
            kind: "std_msgs/msg/String".to_owned(),
            is_latched: false,
        };
        assert_eq!(robot.offered.topics["/Door/moved"], moved);
        assert!(!robot.offered.services.contains_key("/r1/navigate_to_pose/_action/send_goal"));
        let robots = topics(&[], &[["navigate_to_pose", "go"]], &[Localizer, Navigator]);
        let [robot] = &robots.expect("names")[..] else { panic!("one robot") };
        let (within, _) = &robot.offered.services["/go/_action/send_goal"];
        assert_eq!(within, "/navigate_to_pose/_action/send_goal");
        assert!(robot.offered.topics["/navigate_to_pose/_action/status"].is_latched);
    }

    #[test]
    fn the_states_of_those_nodes_of_nav2_are_offered_whose_work_the_robot_does() {
        let offered = |spaces: &[&str], remapped: &[[&str; 2]], nodes: &[ManagedNode]| {
            let [robot] = &topics(spaces, remapped, nodes).expect("names")[..] else { panic!("one robot") };
            let states = robot.offered.services.iter().filter(|(_, (_, kind))| kind == lifecycle::KIND);
            states.map(|(name, (within, _))| (name.clone(), within.clone())).collect::<Vec<_>>()
        };
        let state = |name: &str, within: &str| (name.to_owned(), within.to_owned());
        assert_eq!(offered(&[], &[], &[]), []);
        assert_eq!(offered(&[], &[], &[Localizer]), [state("/amcl/get_state", "/amcl/get_state")]);
        let expected = [
            state("/r1/bt_navigator/get_state", "/bt_navigator/get_state"),
            state("/r1/where/get_state", "/amcl/get_state"),
        ];
        let remapped = [["amcl/get_state", "where/get_state"]];
        assert_eq!(offered(&["/r1"], &remapped, &[Localizer, Navigator]), expected);
    }

    #[test]
    fn names_that_are_used_twice_are_refused() {
        for (spaces, rule, why) in [
            (&[] as &[&str], ["Door/open", "Door/close"], "two of them would have the name /Door/close"),
            (&[], ["Door/moved", "odom"], "two of them would have the name /odom"),
            (&[], ["Gate/open", "gate"], "there is no `Gate/open`"),
            (&["/a", "/b"], ["Door/open", "/gate"], "two robots would have the name /gate"),
            (&["/a", "/b"], ["Door/moved", "/gate"], "two robots would have the name /gate"),
        ] {
            let refused = topics(spaces, &[rule], &[]).expect_err(why);
            assert!(refused.contains(why), "{refused}");
        }
        assert_eq!(topics(&["/a", "/b"], &[], &[]).map(|robots| robots.len()), Ok(2));
    }
}
