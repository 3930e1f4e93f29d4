"""Stability of Gear's correctors: maps for an oscillator, damping rates and limits of real beds."""
