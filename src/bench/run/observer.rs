//! Observers of a run, which write its files and show its progress.

use crate::bench::{CasePictures, Results, Row};
use crate::scene::Picture;
use crate::technique::Spec;
use crate::{Error, Result};

/// Receives notifications about rows as they are measured.
pub trait Observer {
    /// Called when a row begins.
    fn row_begins(&mut self, _scene: &str, _spec: &Spec) {}

    /// Called when a row has drawn its pictures. The names of their files may be written into the row.
    fn row_is_drawn(&mut self, _row: &mut Row, _pictures: &RowPictures) {}

    /// Called when a row has ended and is among `results`.
    ///
    /// # Errors
    /// An error ends the scene, as in [`Observer::scene_fails`].
    fn row_ends(&mut self, _row: &Row, _spec: &Spec, _results: &Results) -> Result<()> {
        Ok(())
    }

    /// Called when a scene has failed, for example because it does not fit on the device.
    ///
    /// # Errors
    /// An error ends the run; without one, the next scene follows.
    fn scene_fails(&mut self, error: Error) -> Result<()> {
        Err(error)
    }
}

/// An observer for runs of which only the results matter.
impl Observer for () {}

/// The pictures of a row.
pub struct RowPictures<'a> {
    /// The row's place among its scene's rows, from 1.
    pub number: usize,
    /// The pictures that the row drew.
    pub drawn: &'a CasePictures,
    /// The picture lit by the truth; `None` if no picture was compared with it.
    pub reference: Option<&'a Picture>,
    /// One bounce of light, if the picture was compared with it.
    pub bounce: Option<&'a Picture>,
    /// The results without the row.
    pub before: &'a Results,
}
