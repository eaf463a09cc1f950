//! Two-level bounding volume hierarchy with robust ray queries.
