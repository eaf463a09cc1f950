//! Ambient occlusion by cone and ray tracing.
