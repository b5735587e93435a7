//! What a barbule is made of: sections, stacks, species and their random instances.
pub mod stack;
