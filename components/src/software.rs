//! The robot's software: the drivers, and what they control.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelSystem, ProcessId};
use maps::{Places, Point, Pose};
use nav::{Atlas, Goal, InitialPose, NavigationParameters, NavigationStatus, Navigator, PoseEstimate};
use rand_chacha::ChaCha8Rng;
use robot::{Odometry, Reading, Robot, VelocityCommand};

use crate::Component;
use crate::battery_reader::BatteryReader;
use crate::localization::Localization;
use crate::navigation::{Navigation, Order, TripStatus};

/// The components' processes in a channel system.
#[derive(Clone, Copy, Debug)]
pub struct Processes {
    /// BatteryReader.
    pub battery_reader: ProcessId,
    /// Localization.
    pub localization: ProcessId,
    /// Navigation.
    pub navigation: ProcessId,
}

/// Localization and navigation of a robot, and the drivers that connect them with the components' processes.
///
/// It sees only the robot's readings and the map.
#[derive(Debug)]
pub struct Software {
    processes: Processes,
    places: Places,
    localization: nav::Localization,
    navigator: Navigator,
    estimate: PoseEstimate,
    odometry: Option<Odometry>,
    /// Whether the navigator drives to a goal that no skill has sent.
    has_foreign_goal: bool,
    readings: Vec<Reading>,
    initial: InitialPose,
    /// The components whose drivers are frozen.
    frozen: BTreeSet<Component>,
}

impl Software {
    /// The software of the atlas's robot on its map with places. `rng` is localization's own stream.
    ///
    /// # Errors
    /// [`nav::Error`] if the robot's model is invalid.
    pub fn new(
        atlas: &Arc<Atlas>,
        places: &Places,
        initial: &InitialPose,
        processes: Processes,
        rng: ChaCha8Rng,
    ) -> Result<Self, nav::Error> {
        let localization = nav::Localization::on(atlas, initial, rng);
        Ok(Self {
            navigator: Navigator::on(atlas, NavigationParameters::of(atlas.model()))?,
            estimate: localization.estimate(),
            localization,
            processes,
            places: places.clone(),
            odometry: None,
            has_foreign_goal: false,
            readings: Vec::new(),
            initial: *initial,
            frozen: BTreeSet::new(),
        })
    }

    /// Navigation ignores the zones with these names, and respects all others.
    pub fn ignore_zones(&mut self, is_ignored: impl Fn(&str) -> bool) {
        self.navigator.ignore_zones(is_ignored);
    }

    /// One control step: processes what the robot has sensed since the last step, exchanges data with the processes,
    /// and commands the base.
    pub fn step(&mut self, robot: &mut dyn Robot, system: &mut ChannelSystem, now: Duration) {
        let mut readings = std::mem::take(&mut self.readings);
        readings.clear();
        robot.read(&mut readings);
        for reading in &readings {
            self.take_in(reading, system);
        }
        self.readings = readings;
        self.estimate = self.localization.estimate();
        if !self.is_frozen(Component::Localization) {
            self.report_places(system);
        }
        if self.is_frozen(Component::Navigation) {
            robot.drive(VelocityCommand::STOP);
            return;
        }
        self.follow_orders(system);
        robot.drive(self.navigate(now));
        self.report_trip_status(system);
    }

    fn take_in(&mut self, reading: &Reading, system: &mut ChannelSystem) {
        match reading {
            Reading::Odometry(odometry) => {
                if !self.is_frozen(Component::Localization) {
                    self.localization.odometry(odometry);
                }
                self.odometry = Some(*odometry);
            }
            Reading::Scan(scan) => {
                if !self.is_frozen(Component::Localization) {
                    self.localization.scan(scan);
                }
                self.navigator.scan(scan, &self.localization.estimate());
            }
            Reading::Battery(_) if self.is_frozen(Component::BatteryReader) => {}
            Reading::Battery(state) => {
                if let Some(process) = system.process_mut::<BatteryReader>(self.processes.battery_reader) {
                    process.update(state);
                }
            }
        }
    }

    /// Reports to Localization which places contain the estimated pose, when that has changed.
    fn report_places(&self, system: &mut ChannelSystem) {
        let pose = &self.estimate.pose;
        let is_outdated = |process: &Localization| !process.is_up_to_date(&self.places, pose);
        if system.process::<Localization>(self.processes.localization).is_some_and(is_outdated)
            && let Some(process) = system.process_mut::<Localization>(self.processes.localization)
        {
            process.update(&self.places, pose);
        }
    }

    /// Carries out the orders that Navigation received since the last step.
    fn follow_orders(&mut self, system: &mut ChannelSystem) {
        while system.process::<Navigation>(self.processes.navigation).is_some_and(Navigation::has_orders) {
            let order = system.process_mut::<Navigation>(self.processes.navigation).and_then(Navigation::next_order);
            match order {
                Some(Order::Start(place)) => {
                    self.has_foreign_goal = false;
                    match self.places.get(place.name()) {
                        Some(place) => self.navigator.start(Goal::to(place)),
                        None => self.navigator.stop(),
                    }
                }
                // The trip that ends has already been aborted.
                Some(Order::Stop) if self.has_foreign_goal => {}
                Some(Order::Stop) => self.navigator.stop(),
                None => return,
            }
        }
    }

    /// Sends Navigation a goal that no skill has sent, as RViz's "2D Goal Pose" does. As in Nav2, it replaces the
    /// current trip, which is aborted: its status becomes a failure, and stopping it has no further effect. The next
    /// trip of a skill replaces this goal.
    ///
    /// # Errors
    /// The reason why Navigation does not accept the goal: it is not running.
    pub fn drive_to(&mut self, goal: Goal, system: &mut ChannelSystem) -> Result<(), &'static str> {
        if self.is_frozen(Component::Navigation) {
            return Err("Navigation does not accept goals now");
        }
        // Requests that skills have already sent come first.
        self.follow_orders(system);
        self.navigator.start(goal);
        self.has_foreign_goal = true;
        if let Some(process) = system.process_mut::<Navigation>(self.processes.navigation)
            && process.trip_status() == Some(TripStatus::Running)
        {
            process.set_trip_status(TripStatus::Failure);
        }
        Ok(())
    }

    /// Ends the navigator's trip, wherever its goal came from, unless Navigation is frozen.
    pub fn end_trip(&mut self) {
        if !self.is_frozen(Component::Navigation) {
            self.navigator.stop();
        }
    }

    fn navigate(&mut self, now: Duration) -> VelocityCommand {
        let Some(odometry) = &self.odometry else { return VelocityCommand::STOP };
        self.navigator.update(now, &self.estimate, odometry)
    }

    /// Reports the status of the trip to Navigation when it has changed.
    fn report_trip_status(&self, system: &mut ChannelSystem) {
        if self.has_foreign_goal {
            return;
        }
        let status = match self.navigator.status() {
            NavigationStatus::GoalReached => TripStatus::Success,
            NavigationStatus::Aborted | NavigationStatus::Error | NavigationStatus::Idle => TripStatus::Failure,
            _ => TripStatus::Running,
        };
        let reported = system.process::<Navigation>(self.processes.navigation).and_then(Navigation::trip_status);
        if reported.is_some_and(|reported| reported != status)
            && let Some(process) = system.process_mut::<Navigation>(self.processes.navigation)
        {
            process.set_trip_status(status);
        }
    }

    /// Freezes the driver of a component, like a node that hangs, or lets it continue, from the next step on.
    ///
    /// The component's process continues to answer with the data it received last. To freeze the process too, suspend
    /// it ([`channels::ChannelSystem::suspend`]).
    ///
    /// - BatteryReader gets no readings of the battery.
    /// - The pose estimate and the data of Localization stay unchanged. Odometry and scans are lost; the first odometry
    ///   afterwards includes the distance driven in the meantime.
    /// - For Navigation, no velocity is commanded, so the base stands still, as with a command watchdog. Orders wait,
    ///   and Navigation gets no status of its trip. Laser scans are still recorded: a queue would deliver them as soon
    ///   as the driver continues.
    pub fn freeze(&mut self, component: Component, is_frozen: bool) {
        if is_frozen {
            self.frozen.insert(component);
        } else {
            self.frozen.remove(&component);
        }
    }

    /// Whether the driver of a component is frozen.
    #[must_use]
    pub fn is_frozen(&self, component: Component) -> bool {
        self.frozen.contains(&component)
    }

    /// Crashes and restarts a component: its process and its driver return to their initial state. Requests that it had
    /// received are never answered.
    ///
    /// - BatteryReader has no level until the next reading.
    /// - Localization starts from its configured initial pose, wherever the robot is now, as AMCL does when it restarts
    ///   with the same parameters.
    /// - Navigation forgets its trip and its laser scans; the robot stops.
    pub fn restart(&mut self, component: Component, system: &mut ChannelSystem) {
        match component {
            Component::BatteryReader => {
                if let Some(process) = system.process_mut::<BatteryReader>(self.processes.battery_reader) {
                    process.restart();
                }
            }
            Component::Localization => {
                self.localization.restart(&self.initial);
                if let Some(process) = system.process_mut::<Localization>(self.processes.localization) {
                    process.restart();
                }
            }
            Component::Navigation => {
                self.navigator.restart();
                self.has_foreign_goal = false;
                if let Some(process) = system.process_mut::<Navigation>(self.processes.navigation) {
                    process.restart();
                }
            }
        }
    }

    /// Restarts localization at a pose, right or wrong, as RViz's "2D Pose Estimate" does.
    pub fn relocalize(&mut self, pose: &InitialPose) {
        self.localization.restart(pose);
    }

    /// What the robot sensed in the last step, oldest first.
    #[must_use]
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// The estimated pose of the robot.
    #[must_use]
    pub fn estimate(&self) -> &PoseEstimate {
        &self.estimate
    }

    /// The last odometry; none before the first.
    #[must_use]
    pub fn odometry(&self) -> Option<&Odometry> {
        self.odometry.as_ref()
    }

    /// The number of particles that localization uses.
    #[must_use]
    pub fn particle_count(&self) -> usize {
        self.localization.particles().len()
    }

    /// The poses of localization's particles, in the `map` frame, with their weights, whose sum is 1.
    pub fn particles(&self) -> impl Iterator<Item = (Pose, f64)> {
        self.localization.particles()
    }

    /// The rest of the path that the robot is following, in the `map` frame; empty if there is none.
    #[must_use]
    pub fn path(&self) -> &[Point] {
        let path = self.navigator.path();
        let here = Point::from(self.estimate.pose.translation.vector);
        let squared = |point: &Point| (point - here).norm_squared();
        let nearest = (0..path.len()).min_by(|&a, &b| squared(&path[a]).total_cmp(&squared(&path[b])));
        &path[nearest.unwrap_or(0)..]
    }

    /// What drives to goals.
    #[must_use]
    pub fn navigator(&self) -> &Navigator {
        &self.navigator
    }
}
