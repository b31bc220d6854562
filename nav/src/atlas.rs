//! The data computed once from a map, shared by any number of runs.

pub(crate) mod clearance;
mod free_space;
pub(crate) mod likelihood_field;
mod parameters;
pub(crate) mod rays;
pub(crate) mod surface_field;
pub(crate) mod zones;

use std::sync::Arc;

use maps::{OccupancyGrid, Zone};
use robot::RobotModel;

use crate::Error;
use free_space::FreeSpace;
use likelihood_field::LikelihoodField;
use surface_field::SurfaceField;
use zones::Zones;

pub use parameters::LocalizationParameters;
pub use zones::closed_map;

/// A map prepared for localizing and navigating robots of one model.
///
/// Preparation takes about 50 ms for an office floor. Then any number of [`Localization`](crate::Localization)s and
/// [`Navigator`](crate::Navigator)s share it, and each is created in microseconds. It never changes.
///
/// ```
/// use std::sync::Arc;
///
/// use nav::{Atlas, InitialPose, Localization, LocalizationParameters, NavigationParameters, Navigator};
/// use robot::{RobotModel, Streams};
///
/// let map = Arc::new(maps::house::map());
/// let atlas = Arc::new(Atlas::new(map, &RobotModel::default(), LocalizationParameters::default())?);
/// for seed in 0..100 {
///     let rng = Streams::new(seed).stream("localization");
///     let localization = Localization::on(&atlas, &InitialPose::Anywhere, rng);
///     let navigator = Navigator::on(&atlas, NavigationParameters::of(atlas.model()))?;
/// }
/// # Ok::<(), nav::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Atlas {
    map: Arc<OccupancyGrid>,
    model: RobotModel,
    parameters: LocalizationParameters,
    pub(crate) surfaces: SurfaceField,
    pub(crate) likelihoods: LikelihoodField,
    pub(crate) free: FreeSpace,
    /// Clearance of each cell from the map's obstacles.
    pub(crate) clearances: Arc<Vec<u8>>,
    pub(crate) zones: Option<Zones>,
}

impl Atlas {
    /// Prepares a map for robots of this model, localized with these parameters.
    ///
    /// # Errors
    /// [`Error::Parameter`] if a parameter is invalid; [`Error::NoFreeSpace`] if the map has no free cell.
    pub fn new(map: Arc<OccupancyGrid>, model: &RobotModel, parameters: LocalizationParameters) -> Result<Self, Error> {
        parameters.check()?;
        let free = FreeSpace::new(&map).ok_or(Error::NoFreeSpace)?;
        let surfaces = SurfaceField::new(&map, parameters.laser_likelihood_max_dist);
        let range_max_m = model.lasers.iter().map(|laser| laser.range_max_m).fold(1.0, f64::max);
        let range_max_m = range_max_m.min(parameters.laser_max_range);
        Ok(Self {
            likelihoods: LikelihoodField::new(&map, &surfaces, &parameters, range_max_m),
            clearances: Arc::new(clearance::of_map(&map)),
            model: model.clone(),
            map,
            parameters,
            surfaces,
            free,
            zones: None,
        })
    }

    /// The same, with these zones for navigation.
    #[must_use]
    pub fn with_zones(mut self, zones: &[Zone]) -> Self {
        self.zones = (!zones.is_empty()).then(|| Zones::new(&self.map, zones));
        self
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &Arc<OccupancyGrid> {
        &self.map
    }

    /// The robots' model.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The parameters of localization.
    #[must_use]
    pub fn parameters(&self) -> &LocalizationParameters {
        &self.parameters
    }
}
