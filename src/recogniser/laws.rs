//! What every recogniser of the registry must keep.
