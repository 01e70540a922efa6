//! What each opcode computes.
