use super::assembly::Assembly;
use crate::Scene;
pub(crate) fn atrium() -> Scene {
    Assembly::new("atrium").finish()
}
