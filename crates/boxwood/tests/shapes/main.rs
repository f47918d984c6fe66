//! Shapes and implicit surfaces against dense double-precision sampling, against each other, and in structures.

mod functions;
mod generators;
mod leaving;
mod roots;
mod sampling;
mod structures;
