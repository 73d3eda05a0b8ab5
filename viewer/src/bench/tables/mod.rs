//! Tables 1 to 4, figures 4, 7 and 8 and section 6.5 of Stamminger et al. 2000: their figures beside ours.

mod basis;
mod convergence4;
mod methods;
mod refiner;
mod run;
mod sheet;
mod soda;
mod sum;
mod truth;

pub use basis::{GLOSSY_ROOM, basis};
pub use convergence4::{AREA_LIGHT, convergence4};
pub use methods::{Tables, TablesError, methods};
pub use refiner::refiner;
pub use run::Case;
pub use sheet::Sheet;
pub use soda::{soda, visibility};
pub use sum::{LAMP_GRIDS, sum};
