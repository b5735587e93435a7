//! Many illuminations of many instances: units of work, statistics, resumption.
