//! Load stepping: runs the stages of a model with adaptive steps.
