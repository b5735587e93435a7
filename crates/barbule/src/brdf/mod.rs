//! Feather BRDFs: the smooth lobe, its random instances, evaluation and sampling.
