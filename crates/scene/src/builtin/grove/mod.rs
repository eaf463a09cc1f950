use super::assembly::Assembly;
use crate::Scene;
pub(crate) fn grove() -> Scene {
    Assembly::new("grove").finish()
}
