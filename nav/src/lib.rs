//! Localization, planning and path following.
