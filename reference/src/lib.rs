//! Draws a scene on the CPU by ray tracing: the truth that techniques are measured against.
